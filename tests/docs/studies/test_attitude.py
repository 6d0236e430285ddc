"""The study of the reports' attitudes: it shows what it names, and its page is what its script makes."""

import re
from importlib import import_module
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[3] / "docs" / "studies"
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")


@pytest.fixture(autouse=True)
def _studies_on_path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(STUDIES)


def test_every_picture_that_the_page_shows_exists_and_no_other() -> None:
    shown = PICTURE.findall((STUDIES / "attitude.md").read_text("utf-8"))
    assert sorted(shown) == sorted(f"attitude/{path.name}" for path in (STUDIES / "attitude").iterdir())
    assert max(path.stat().st_size for path in (STUDIES / "attitude").iterdir()) < 150_000


def test_every_section_says_what_agrees_and_what_differs() -> None:
    sections = (STUDIES / "attitude.md").read_text("utf-8").split("\n## ")[1:]
    of_reports = [text for text in sections if text.startswith(("TP", "CR", "SR"))]
    assert (len(sections), len(of_reports)) == (10, 9)
    assert all("*Agrees.*" in text and "*Differs.*" in text for text in of_reports)


@pytest.mark.thorough
def test_the_page_is_what_the_script_makes_and_the_reports_numbers_come_out() -> None:
    facts = import_module("attitude_study.page").facts()
    template = (STUDIES / "attitude_study" / "page.template.md").read_text("utf-8")
    made, stored = template.format_map(facts), (STUDIES / "attitude.md").read_text("utf-8")
    rounding = re.compile(r"\d\.\de-1\d|\d+e-1\d")  # the last digits of a double differ between machines
    assert rounding.sub("", made) == rounding.sub("", stored)
    assert facts["one_at_30"] == pytest.approx(15.0, abs=1.0)
    assert facts["hold_100"] == pytest.approx(0.16, abs=0.001)
    assert max(facts["cubic"], facts["butcher"]) < 1e-9
    assert 94.0 < facts["all_least"] < facts["all_most"] < 96.0
    assert facts["some_least"] > 93.0
    assert facts["flight_filter"] < 2.0 < 90.0 < facts["flight_gyro"]
