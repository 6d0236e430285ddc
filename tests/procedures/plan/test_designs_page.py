"""The page about designs is run, and names every kind and every order."""

import doctest
import os
from pathlib import Path
from typing import get_args

from procedures.description.described_designs import DESCRIBED_DESIGNS
from procedures.description.procedure_file import Order

PAGE = Path(__file__).parents[3] / "docs" / "designs.md"


def test_the_examples_of_the_page_give_what_it_shows():
    results = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert (results.failed, results.attempted) == (0, 8)


def test_the_page_names_every_kind_and_every_order():
    page = PAGE.read_text("utf-8")
    assert [name for name in (*DESCRIBED_DESIGNS, "schedule", *get_args(Order)) if f"`{name}`" not in page] == []
