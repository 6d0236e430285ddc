"""The page about coefficient sets is run, and names every entry of a set."""

import doctest
import os
from pathlib import Path

import pytest
from solved import provenance, solved_package

from ams.exports.formats import FORMATS
from ams.sets.coefficients import build_set

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "coefficient-sets.md"


def test_the_examples_of_the_page_give_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert (results.failed, results.attempted) == (0, 13)


def test_the_page_names_every_entry_and_every_format() -> None:
    page = PAGE.read_text("utf-8")
    entries = set(build_set(solved_package(), provenance()).document) - {"warnings", "inputs"}
    assert [name for name in [*entries, *FORMATS] if f"`{name}`" not in page] == []
