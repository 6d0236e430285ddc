"""PDF/A-3b of a page, by typst: fonts inside, the same bytes for the same page, the results attached as files.

Source: ISO 19005-3 (PDF/A-3, level b); attachments as associated files of the document (relationship *data*).
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from procedures.report.paper.letters import breakable, fonts, printable
from procedures.report.paper.page_tree import PageTree, page_tree_of

TEMPLATE = Path(__file__).with_name("paper.typ")
STANDARD = "a-3b"
_KEPT = 10
"""Compilations for which typst keeps what it has laid out, 40 MB for a package: of one that follows nothing is used."""


@dataclass(frozen=True)
class Attachment:
    """A file inside the PDF."""

    name: str
    media_type: str
    description: str
    content: bytes


@dataclass(frozen=True)
class Imprint:
    """What stands at the foot of every page and in the file's own data."""

    title: str
    stamps: Sequence[str]
    """``SIMULATED``, ``ENGINEERING``: repeated on every page."""
    foot: str
    """The identity of the document."""
    moment: datetime
    """When the results came to be; not when they were printed, so that a reprint is the same file."""


def paper_of(page: str, imprint: Imprint, attachments: Sequence[Attachment] = ()) -> bytes:
    """Return the PDF's bytes.

    Raises: ValueError for a page that uses an element the paper has no form of.
    """
    import typst

    compile_pages: Any = typst.compile  # its type stubs do not know sources given by name
    searched = typst.Fonts(include_system_fonts=False, font_paths=[fonts()])
    tree = page_tree_of(page)
    pdf = compile_pages(
        _sources(tree, imprint, attachments),
        format="pdf",
        pdf_standards=[STANDARD],
        font_paths=searched,
        timestamp=int(imprint.moment.timestamp()),
    )
    assert isinstance(pdf, bytes)
    for _ in range(_KEPT + 1):
        compile_pages({"main.typ": b""}, format="svg", font_paths=searched)
    return pdf


def _sources(tree: PageTree, imprint: Imprint, attachments: Sequence[Attachment]) -> dict[str, bytes]:
    """Return everything that typst may read, by name: it sees no other file."""
    moment = imprint.moment.astimezone(UTC)
    document: dict[str, object] = {
        "title": imprint.title,
        "stamps": list(imprint.stamps),
        "foot": imprint.foot,
        "date": [moment.year, moment.month, moment.day, moment.hour, moment.minute, moment.second],
        "attachments": [
            {
                "file": f"attachments/{attachment.name}",
                "name": attachment.name,
                "type": attachment.media_type,
                "about": attachment.description,
            }
            for attachment in attachments
        ],
    }
    document = {**printable(document), "page": breakable(printable(tree.body.as_json()))}
    return {
        "main.typ": TEMPLATE.read_bytes(),
        "document.json": json.dumps(document, ensure_ascii=False).encode("utf-8"),
        **tree.pictures,
        **{f"attachments/{attachment.name}": attachment.content for attachment in attachments},
    }
