"""The changelog is for users: every line leads somewhere, and the file stays one that somebody reads."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "CHANGELOG.md"
LINK = re.compile(r"\]\((?P<path>[^)#]+)(?:#(?P<anchor>[^)]+))?\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """Where its headings can be led to: small letters, words joined by hyphens, no other signs."""
    headings = HEADING.findall(page.read_text(encoding="utf-8"))
    bare = (re.sub(r"[^\w\s-]", "", re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", heading)) for heading in headings)
    return {heading.strip().lower().replace(" ", "-") for heading in bare}


def test_every_link_of_the_changelog_leads_to_a_place_that_is_there() -> None:
    links = list(LINK.finditer(PAGE.read_text(encoding="utf-8")))
    assert len(links) > 80
    lost = [link[0] for link in links if not (ROOT / link["path"]).exists()]
    astray = [link[0] for link in links if link["anchor"] and link["anchor"] not in anchors(ROOT / link["path"])]
    assert (lost, astray) == ([], [])


def test_an_item_of_the_changelog_is_a_line_and_no_story() -> None:
    """Two lines of 200 letters at most: what was wrong before stands in the message of the commit."""
    items = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("- ")]
    assert [item for item in items if len(re.sub(r"\]\([^)]+\)", "]", item)) > 400] == []
