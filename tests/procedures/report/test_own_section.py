"""A section that is no part of the package stands on the page and on paper (examples/own_section)."""

from dataclasses import replace
from pathlib import Path

import pytest
from installed_examples import install_example
from report_scene import Scene, run_view

from procedures.report.figures import Figures
from procedures.report.page import render_page
from procedures.report.section import SECTIONS, sections_in_order
from procedures.report.view import RunView

OWN = [
    "overview",
    "sensors",
    "findings",
    "run",
    "missing",
    "interruptions",
    "rejected",
    "equipment",
    "provenance",
    "signatures",
]


def page_of(view: RunView) -> str:
    return render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return install_example("own_section", tmp_path / "site", monkeypatch)


def test_the_sections_of_calrig_stand_in_their_order() -> None:
    assert [section.name for section in sections_in_order()] == OWN


def test_before_it_is_installed_it_is_not_on_the_page() -> None:
    assert 'id="dwells"' not in page_of(run_view(Scene()))


@pytest.mark.usefixtures("installed")
def test_it_stands_where_its_order_says_and_in_the_contents() -> None:
    page = page_of(run_view(Scene()))
    assert [section.name for section in sections_in_order()] == [*OWN[:4], "dwells", *OWN[4:]]
    assert page.index('id="run"') < page.index('id="dwells"') < page.index('id="interruptions"')
    assert '<a href="#dwells">Dwells</a>' in page
    assert "design dwells of" in page


@pytest.mark.usefixtures("installed")
def test_what_it_prints_is_escaped_like_everything_else() -> None:
    view = replace(run_view(Scene()), title="<script>alert(1)</script>")
    assert "<script>" not in page_of(view)


@pytest.mark.usefixtures("installed")
def test_where_it_has_nothing_to_show_it_is_not_there() -> None:
    view = run_view(Scene())
    page = page_of(replace(view, counts=replace(view.counts, design_planned=0)))
    assert 'href="#dwells"' not in page
    assert SECTIONS["dwells"].is_shown(view)
