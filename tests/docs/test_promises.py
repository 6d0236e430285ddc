"""Every promise of running unattended names the tests that hold it, and they are there."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "unattended-proofs.md"
ROW = re.compile(r"^\| (?P<promise>[^|]+) \| (?P<tests>[^|]+) \|$", re.MULTILINE)
LINK = re.compile(r"\]\(\.\./(?P<path>tests/[^)#]+)(?:#(?P<name>\w+))?\)")


def test_every_promise_names_tests_that_are_there() -> None:
    page = PAGE.read_text(encoding="utf-8").partition("## Each promise and its test")[2]
    rows = [row for row in ROW.finditer(page) if row["promise"] not in ("promise", "---")]
    assert len(rows) >= 19
    for row in rows:
        links = list(LINK.finditer(row["tests"]))
        assert links, row["promise"]
        for link in links:
            source = (ROOT / link["path"]).read_text(encoding="utf-8")
            assert link["name"] is None or f"def {link['name']}(" in source, link[0]
