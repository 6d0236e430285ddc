"""A section that is no part of the package stands on the page and on paper (examples/own_section)."""

from dataclasses import replace
from pathlib import Path

import pytest
from installed_examples import install_example
from report_scene import Scene, run_view
from stored_runs import DATA, StoredCase

from procedures.journal.journal_reader import JournalReader
from procedures.report.assemble import assemble_view
from procedures.report.figures import Figures
from procedures.report.page import render_page
from procedures.report.section import SECTIONS, sections_in_order
from procedures.report.view import RunView
from procedures.solution.record import RunRecord, read_record

ORDER = ["overview", "sensors", "findings", "run", "interruptions", "rejected", "equipment", "provenance", "signatures"]


def page_of(view: RunView) -> str:
    return render_page(view, Figures((), {sensor.name: () for sensor in view.sensors}))


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return install_example("own_section", tmp_path / "site", monkeypatch)


def test_the_sections_of_calrig_stand_in_their_order() -> None:
    names = [section.name for section in sections_in_order()]
    assert [name for name in names if name in ORDER] == ORDER
    assert (names[0], names[-1]) == (ORDER[0], ORDER[-1])


def test_before_it_is_installed_it_is_not_on_the_page() -> None:
    assert 'id="dwells"' not in page_of(run_view(Scene()))


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> RunRecord:
    run = StoredCase(DATA / "runs_0_1_0" / "grid").copy("finished", tmp_path_factory.mktemp("stored") / "run")
    with JournalReader.open(run) as reader:
        return read_record(reader)


@pytest.fixture
def view(installed: Path, record: RunRecord) -> RunView:
    return assemble_view(record, {})


def test_it_brings_a_number_of_its_own(view: RunView, record: RunRecord) -> None:
    """One that the view does not have: from the beginnings and ends in the journal."""
    took_s = {dwell.step: dwell.ended_s - dwell.started_s for dwell in record.dwells if dwell.accepted}
    longest = max(took_s.values())
    said = " ".join(page_of(view).partition('id="dwells"')[2].partition("</p>")[0].split())
    assert f"The {len(took_s)} dwells that count took {sum(took_s.values()) / len(took_s):.1f} s each" in said
    step = int(said.partition("(step ")[2].partition(")")[0])
    assert took_s[step] == longest
    assert f"the longest took {longest:.1f} s" in said


def test_it_stands_where_its_order_says_and_in_the_contents(view: RunView) -> None:
    page = page_of(view)
    names = [section.name for section in sections_in_order()]
    assert names[names.index("run") + 1] == "dwells"
    assert page.index('id="run"') < page.index('id="dwells"') < page.index('id="interruptions"')
    assert '<a href="#dwells">Dwells</a>' in page
    assert "design dwells of" in page


def test_what_it_prints_is_escaped_like_everything_else(view: RunView) -> None:
    assert "<script>" not in page_of(replace(view, title="<script>alert(1)</script>"))


def test_where_it_has_nothing_to_show_it_is_not_there(view: RunView) -> None:
    page = page_of(replace(view, counts=replace(view.counts, design_planned=0)))
    assert 'href="#dwells"' not in page
    assert SECTIONS["dwells"].is_shown(view)
