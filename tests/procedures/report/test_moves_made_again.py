"""A jam that clears stands in every report: with its time, its axis and what was found, by a run on the twin."""

from pathlib import Path

import pytest
from report_scene import Scene, run_view
from runs_with_faults import faults, run_with_faults
from small_run import Bench, bench
from unattended_run import UnattendedRun, events

from procedures.journal.journal_reader import JournalReader
from procedures.records.dwells import Event
from procedures.records.states import State
from procedures.report.assemble import assemble_view
from procedures.report.figures import Figures
from procedures.report.page import render_page
from procedures.report.sections.rejected import NotBelieved
from procedures.report.view import RunView
from procedures.run.handover import handover
from procedures.run.stop_page import explain
from procedures.solution.record import read_record
from rig.local_time import at_both, local_clock

FOUND = "no progress in 2 s"


@pytest.fixture(scope="module")
def jammed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run in which pitch stuck once and went on from where it came."""
    small: Bench = bench(tmp_path_factory.mktemp("bench"))
    unattended = UnattendedRun(tmp_path_factory.mktemp("jammed") / "run")
    stall = {"line": "axes.pitch", "kind": "stall", "for_s": 1000.0, "at_s": 60.0}
    outcome, _ = run_with_faults(small, unattended, faults(stall=stall))
    assert outcome.state is State.FINISHED, outcome.reason
    return unattended.run_dir


def _jam(run_dir: Path) -> Event:
    (again,) = events(run_dir, "again")
    return again


def _without_figures(view: RunView) -> Figures:
    return Figures((), {sensor.name: () for sensor in view.sensors})


@pytest.mark.parametrize("only", [None, "SN1"])
def test_report_and_document_of_a_sensor_tell_a_jam_with_time_axis_and_what_was_found(
    jammed: Path, only: str | None
) -> None:
    with JournalReader.open(jammed) as reader:
        view = assemble_view(read_record(reader), {}, only=only)
    brought = view.of_sections["rejected"]
    assert isinstance(brought, NotBelieved)
    (move,) = brought.made_again
    assert (move.axis, move.utc) == ("pitch", _jam(jammed).utc)
    assert f"{move.axis}: {move.found}" == _jam(jammed).detail["reason"]
    assert any(ground.startswith("1 move was made again") for ground in view.verdict.grounds)
    section = render_page(view, _without_figures(view)).partition('<h2 id="rejected">')[2].partition("<h2 ")[0]
    assert f"{move.utc:%Y-%m-%d %H:%M}" in section
    assert "<td>pitch</td>" in section
    assert FOUND in section


def test_a_run_in_which_every_move_ended_at_once_says_nothing_of_moves() -> None:
    view = run_view(Scene())
    assert "made again" not in render_page(view, _without_figures(view))


def test_handover_and_the_page_of_a_stop_tell_a_jam_though_it_was_long_before(jammed: Path) -> None:
    jam = _jam(jammed)
    assert f"moves made again (1)\n  {at_both(jam.utc)} {jam.detail['reason']}" in handover(jammed)
    page = explain(jammed, "somebody wants to know")
    assert page is not None
    text = page.with_suffix(".txt").read_text(encoding="utf-8").partition("last events")[0]
    assert f"{local_clock(jam.utc)}  {jam.detail['reason']}" in text
    html = page.read_text(encoding="utf-8").partition("<h2>Last events</h2>")[0]
    assert f'<td>{local_clock(jam.utc)}</td><td class="s">pitch</td>' in html
    assert FOUND in html
