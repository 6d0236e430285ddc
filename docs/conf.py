"""The documentation site: Sphinx with MyST over the pages of this folder. `make site` builds it without a warning."""

import re
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.highlighting import lexers

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE)]

from reference_pages import write_reference  # noqa: E402

project = "calrig"
author = "the calrig developers"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["studies/performance", "studies/tp_study", "studies/attitude", "studies/attitude_study"]
html_theme = "furo"
html_title = "calrig"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
linkcheck_timeout = 20
linkcheck_retries = 2
myst_heading_anchors = 4
autodoc_typehints = "signature"
lexers["mermaid"] = TextLexer()  # the repository's pages draw it; here it stays text
write_reference(HERE / "reference")

FOLDER_LINK = re.compile(r"\[([^\]]+)\]\((?:\.\./)+examples/[\w-]+\)")


def without_links_to_folders(app: Sphinx, name: str, source: list[str]) -> None:  # noqa: ARG001  the event's signature
    """Keep the words of links to folders of the repository, which a site has not."""
    source[0] = FOLDER_LINK.sub(r"\1", source[0])


def setup(app: Sphinx) -> None:
    """Register what is done to pages before they are read."""
    app.connect("source-read", without_links_to_folders)
