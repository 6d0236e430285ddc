"""The study of findings: it simulates what it says, and the page in the documentation is its own."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).parents[3] / "docs" / "studies"


@pytest.fixture
def findings(monkeypatch):
    monkeypatch.syspath_prepend(STUDIES)
    return import_module("findings")


def test_an_obvious_cause_is_named_and_the_threshold_is_between(findings) -> None:
    nothing, obvious = (findings.line("k3", size, 20, np.random.default_rng(1)) for size in (0.0, 20.0))
    assert nothing.rings <= 0.15
    assert obvious.cause >= 0.95
    assert obvious.offset >= 0.8


def test_the_page_has_every_line_of_the_script(findings) -> None:
    stored = (STUDIES / "findings.md").read_text(encoding="utf-8")
    assert stored.startswith(findings.HEAD.format(campaigns=findings.CAMPAIGNS))
    for name, sizes in findings.LINES:
        section = stored[stored.index(f"## {name}\n") :].split("\n## ")[0]
        text = [line.split("|")[1].strip() for line in section.splitlines() if line.startswith("| ")][1:]
        assert text == [f"{size:g}" for size in sizes]
