"""A journal on the disk becomes a page: reader, solvers, view, figures and templates together."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from report_journal import write_journal

from procedures.journal.journal_reader import JournalReader
from procedures.kinds.solve import solve_record
from procedures.report.sections.equipment import Equipment
from procedures.report.sections.provenance import Provenance
from procedures.report.sections.rejected import NotBelieved
from procedures.report.view import RunView
from procedures.report.write import draw_report, view_of, write_paper, write_screen
from procedures.solution.record import RunRecord, read_record


def _record(path: Path) -> RunRecord:
    with JournalReader.open(path) as reader:
        return read_record(reader)


@pytest.fixture(scope="module")
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_journal(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def view(journal: Path) -> RunView:
    record = _record(journal)
    return view_of(record, solve_record(record))


def test_the_estimates_lie_within_three_expanded_uncertainties_of_the_truth(view: RunView) -> None:
    rows = [row for axis in view.sensors[0].axes for row in axis.parameters]
    assert len(rows) == 3 * (4 + 6 + 1)  # the four of TP, the terms of second and third order, the offset beside them
    for row in rows:
        assert row.value is not None
        assert row.truth is not None
        assert row.expanded_uncertainty is not None
        assert abs(row.value - row.truth) < 3.0 * row.expanded_uncertainty


def test_every_dwell_is_accounted_for(view: RunView) -> None:
    # 5 × 7 attitudes × 3 replications, 6 check attitudes, a reference visit after every 20th design dwell
    assert view.counts.design_planned == view.counts.design_accepted == 105
    assert view.counts.accepted == view.counts.planned
    assert view.counts.rejected == view.counts.rejected_and_repeated == 1
    brought = view.of_sections["rejected"]
    assert isinstance(brought, NotBelieved)
    (rejected,) = brought.dwells
    assert rejected.reasons == ("scatter 4.1 times the reference",)
    assert view.design.points == 35


def test_a_dwell_that_was_taken_back_and_nobody_measured_again_does_not_count_as_measured_again(journal: Path) -> None:
    record = _record(journal)
    *_, last = (dwell for dwell in record.dwells if dwell.purpose == "design")
    taken_back = tuple(replace(dwell, accepted=dwell is not last and dwell.accepted) for dwell in record.dwells)
    counts = view_of(replace(record, dwells=taken_back), solve_record(record)).counts
    assert (counts.rejected, counts.rejected_and_repeated) == (2, 1)


def test_the_pause_is_told_with_its_length(view: RunView) -> None:
    (pause,) = view.interruptions
    assert pause.what == "paused"
    assert pause.by == "A. Operator"
    assert pause.ended_utc is not None
    assert (pause.ended_utc - pause.began_utc).total_seconds() == 600.0


def test_the_design_is_drawn_in_the_order_of_the_first_replication(view: RunView) -> None:
    assert sorted(view.design.point.tolist()) == list(range(1, 36))
    assert view.design.order == "there-and-back"
    assert np.ptp(view.design.pitch_deg) == 120.0


def test_devices_standards_and_hashes_are_those_of_the_run(view: RunView, journal: Path) -> None:
    found, provenance = view.of_sections["equipment"], view.of_sections["provenance"]
    assert isinstance(found, Equipment)
    assert isinstance(provenance, Provenance)
    assert [device.name for device in found.devices] == ["axes.pitch", "axes.roll", "readouts.dmm", "environment.air"]
    assert found.standards[0].uncertainty == "±1 ″ (limit)"
    with JournalReader.open(journal) as reader:
        assert provenance.hashes["journal content"] == reader.sha256_of_content()
        assert provenance.hashes["plan"] == reader.header.plan.sha256
    assert view.is_simulated
    assert view.stamps == ("SIMULATED", "ENGINEERING")


def test_the_reference_attitude_and_the_temperature_are_traced(view: RunView) -> None:
    assert [trace.label for trace in view.reference] == ["SN1047 x", "SN1047 y", "SN1047 z"]
    assert view.temperature[0].temperature_degc.size == view.counts.accepted + view.counts.rejected
    assert view.temperature[0].hours[-1] > 0.9


@pytest.mark.thorough
def test_report_and_figures_are_written_and_the_same_again(view: RunView, tmp_path: Path) -> None:
    drawn = draw_report(view)
    first, again = ([write(drawn, tmp_path).read_bytes() for write in (write_screen, write_paper)] for _ in "12")
    assert first == again
    assert (tmp_path / "figures" / "1-sn1047-residuals-pitch.svg").exists()


def test_a_run_aborted_before_it_could_be_solved_has_a_report_that_says_why(tmp_path: Path) -> None:
    record = _record(write_journal(tmp_path, until_step=8))
    view = view_of(record, solve_record(record))
    assert view.verdict.trust == "unusable"
    assert view.sensors[0].failure
    why = view.verdict.grounds[0]
    assert (why.startswith("SN1047: "), why.count("SN1047"), view.run_id in why) == (True, 1, False)
    assert view.interruptions[-1].what == "aborted"
    page = write_screen(draw_report(view), tmp_path).read_text(encoding="utf-8")
    assert "NO RESULT" in page
    assert "did not finish (state “aborted”)" in page


def test_a_run_aborted_before_its_first_dwell_has_a_report_too(tmp_path: Path) -> None:
    record = _record(write_journal(tmp_path, until_step=0))
    view = view_of(record, solve_record(record))
    assert "NO RESULT" in write_screen(draw_report(view), tmp_path).read_text(encoding="utf-8")
