"""How every page of ours is made from its template: escaped, strict, and with its own style sheet pinned by hash."""

import hashlib
import re
from base64 import b64encode
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from rig.plain_text import shown

_OPTION: Final = re.compile(r"(?<=[\s(])--[a-z][a-z-]*(?=[^<>]*<)")
"""An option where text stands; what is followed by the end of a tag first is an attribute's."""
_WHOLE: Final = r'<span class="option">\g<0></span>'


def page_environment(*folders: Path) -> Environment:
    """Templates of these folders, the first first: what is filled in is escaped, and a name that is not given fails."""
    return Environment(
        loader=FileSystemLoader(folders),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_shown,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _shown(value: object) -> object:
    """Show what a name or a note hides, on every page and so on paper."""
    return shown(value) if type(value) is str else value


def with_whole_options(page: str) -> str:
    """Return the page with every option of a printed command set so that no line breaks inside it."""
    head, end, body = page.partition("</head>")
    return f"{head}{end}{_OPTION.sub(_WHOLE, body)}"


def page_style(sheet: Path) -> Mapping[str, object]:
    """``style`` and ``style_hash`` for a template: the sheet must reach the page as it is for its hash to hold."""
    style = sheet.read_text(encoding="utf-8")
    digest = b64encode(hashlib.sha256(style.encode()).digest()).decode()
    return {"style": Markup(style), "style_hash": digest}  # noqa: S704 (a constant of this package)
