"""The page of the files has every key that is the same for all drivers, and no key that the files refuse."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from file_keys import keys_of
from pydantic import BaseModel

from procedures.cli.prepare.new import QUESTIONS
from procedures.kinds.read import procedure_form
from rig.description.read import rig_form

DOCS = Path(__file__).parents[2] / "docs"
FORMS = {"rig.toml": rig_form, "procedure.toml": procedure_form}
ROW = re.compile(r"^\| (?P<table>[^|]*)\| (?P<keys>[^|]*)\| (?P<meaning>.*) \|$", re.MULTILINE)
TICKED = re.compile(r"`([^`]+)`")
WORD = re.compile(r"[a-z][a-z0-9_]*")
TOP_LEVEL = {"approved_by"}
SET_APART = {("axes.*", "driver"), ("readouts.*", "driver"), ("environment.*", "driver"), ("streams.*", "driver")} | {
    ("field.*", "driver")
}
"""The walk through the forms leaves the key out by which it chooses among them."""


def tables_of(cell: str) -> list[str]:
    """The tables of a row as the walk names them: `[chain."readout.channel"]` is chain.*."""
    found = []
    for header in re.findall(r"`\[([^`]+)\]`", cell):
        first, *names = re.findall(r'"[^"]*"|[^.]+', header)
        found.append(".".join([first, *("*" if name.isupper() or name.startswith('"') else name for name in names)]))
    return found


def documented(name: str) -> Iterator[tuple[list[str], str, str]]:
    """Yield table, key and what stands in the row of the key, in words of the file."""
    section = (DOCS / "files.md").read_text(encoding="utf-8").partition(f"\n## {name}\n")[2].partition("\n## ")[0]
    tables: list[str] = []
    for row in ROW.finditer(section):
        if row["table"].strip() in ("table", "---"):
            continue
        tables = tables_of(row["table"]) or tables
        for ticked in TICKED.findall(row["keys"]):
            yield tables, ticked, row["keys"] + row["meaning"]


def without_driver(key: str) -> str:
    return re.sub(r":[^.]+", "", key)


def keys(form: type[BaseModel]) -> dict[str, bool]:
    """Every key, and whether a driver of its own brings it."""
    return {without_driver(key): ":" in key for key in keys_of(form)}


@pytest.mark.parametrize("name", FORMS)
def test_every_key_on_the_page_is_one_of_the_file(name: str) -> None:
    known = {*keys(FORMS[name]())}
    tables = {".".join(key.split(".")[:end]) for key in known for end in range(len(key.split(".")) + 1)}
    strangers = [
        (at, key)
        for at, key, _ in documented(name)
        if key not in TOP_LEVEL
        and not any(f"{table}.{key}" in known | tables or (table, key) in SET_APART for table in at)
    ]
    assert strangers == []


@pytest.mark.parametrize("name", FORMS)
def test_every_key_that_no_driver_brings_is_on_the_page(name: str) -> None:
    found: dict[str, set[str]] = {}
    for tables, key, row in documented(name):
        for table in tables:
            found.setdefault(table, set()).add(key)
            found.setdefault(f"{table}.{key}", set()).update(WORD.findall(row))
            found.setdefault(f"{table}.{key}.*", set()).update(WORD.findall(row))
    everywhere = [key for key, is_drivers in keys(FORMS[name]()).items() if not is_drivers and key not in TOP_LEVEL]
    assert len(everywhere) > 80
    assert [key for key in everywhere if key.rpartition(".")[2] not in found.get(key.rpartition(".")[0], set())] == []


def test_every_key_that_a_driver_brings_is_on_some_page() -> None:
    pages = " ".join(page.read_text(encoding="utf-8") for page in DOCS.glob("*.md"))
    own = {key.rpartition(".")[2] for key, is_drivers in keys(rig_form()).items() if is_drivers}
    assert [key for key in sorted(own) if not re.search(rf"\b{key}\b", pages)] == []


def test_the_page_has_every_option_of_calrig_new() -> None:
    text = (DOCS / "files.md").read_text(encoding="utf-8")
    assert [name for name in QUESTIONS if f"`--{name.replace('_', '-')}`" not in text] == []
