"""The page about the archive is run, and names every command and every verdict."""

import doctest
import os
from pathlib import Path
from typing import get_args

import pytest

from ams.archive.signatures import Role
from ams.surveillance.adjustment import RULES, Verdict

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "archive.md"


def test_the_examples_of_the_page_give_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    results = doctest.testfile(os.fspath(PAGE), module_relative=False, encoding="utf-8")
    assert (results.failed, results.attempted) == (0, 15)


def test_the_page_names_every_command_role_rule_and_verdict() -> None:
    from procedures.cli.archive.archive import app

    page = PAGE.read_text("utf-8")
    commands = [f"calrig archive {name}" for name in app if not name.startswith("-")]
    assert len(commands) >= 9
    wanted = [*commands, "calrig resolve", *get_args(Role), *(f"`{rule}`" for rule in RULES), *get_args(Verdict)]
    assert [name for name in wanted if name not in page] == []
