"""The page of the catalogue, the tests that it tells of and the times that it states belong together."""

import re

import pytest
from fault_table import PAGE, TITLES, described, fault_tests, page
from standstill import STRIKES, standstill_s

TESTS = fault_tests()


@pytest.mark.parametrize("entry", TITLES)
def test_every_entry_has_a_test_that_says_how_it_is_detected_and_answered(entry: int) -> None:
    assert described(entry, TESTS) is not None


def test_the_page_is_what_the_tests_say() -> None:
    stated = {
        int(row[1]): float(row[2])
        for row in re.finditer(r"^\| (\d+) \|.*\| (\d+\.\d) s \|", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    }
    assert stated.keys() == STRIKES.keys()
    on_the_page, from_the_tests = (
        [line.rpartition(" | ")[0] for line in text.splitlines()]
        for text in (PAGE.read_text(encoding="utf-8"), page(TESTS, stated))
    )
    assert on_the_page == from_the_tests, "write it anew: python tests/support/fault_table.py"


def test_what_is_told_as_damaged_is_on_the_page_with_what_to_do() -> None:
    """The word that status, handover, lists and refusals print; each with a way out that is a command, or a copy."""
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    told = {what: way for what, way in rows if what != "damaged" and not what.startswith("-")}
    for word in ("dwell of a run", "journal", "set or an export", "archive", "queue"):
        ways = [way for what, way in told.items() if word in what]
        assert ways, word
        assert all("calrig " in way or "copy" in way or "keep" in way for way in ways)


def test_every_file_that_the_page_names_holds_a_test_of_its_entry() -> None:
    held = {(test.entry, test.file) for test in TESTS}
    rows = re.findall(r"^\| (\d+) \|.*\| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert len(rows) == len(TITLES)
    for entry, links in rows:
        for file in re.findall(r"\(\.\./([^)]+)\)", links):
            assert (int(entry), file) in held


@pytest.mark.parametrize("entry", sorted(STRIKES))
def test_the_time_to_standstill_on_the_page_is_what_the_twins_take(entry: int) -> None:
    (row,) = re.findall(rf"^\| {entry} \|.*\| (\d+\.\d) s \|", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert standstill_s(entry) == pytest.approx(float(row), abs=0.25)
