"""Laws of the lines' figures: over all connections of a run, told by status and report."""

from pathlib import Path

import pytest
from report_dwells import event
from small_run import bench

from procedures.journal.audit.line_figures import LineFigures, lines_in, lines_in_words
from procedures.journal.journal_reader import JournalReader
from procedures.journal.status.status import status
from procedures.records.states import State
from procedures.report.conditions import condition_sections


def test_counts_are_added_over_connections_and_not_within_one() -> None:
    events = [
        event(1, "opened", 0.0, pid=7),
        event(2, "links", 1.0, **{"axes.pitch": [100, 1, 0]}),
        event(3, "links", 2.0, **{"axes.pitch": [250, 2, 8]}),
        event(4, "opened", 2.5, pid=7),  # a new epoch of the same process over the same lines
        event(5, "links", 3.0, **{"axes.pitch": [300, 2, 8]}),
        event(6, "reconnect", 3.5, failed="still out"),
        event(7, "reconnect", 3.6, failed=""),
        event(8, "links", 4.0, **{"axes.pitch": [40, 5, 0], "axes.roll": [10, 0, 0]}),
        event(9, "opened", 5.0, pid=8),
        event(10, "links", 6.0, **{"axes.pitch": [50, 0, 0]}),
        event(11, "links", 7.0, **{"axes.pitch": [20, 0, 0]}),  # opened anew by somebody who did not say so
    ]
    assert lines_in(events) == {"axes.pitch": LineFigures(410, 7, 8), "axes.roll": LineFigures(10, 0, 0)}


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        (LineFigures(1000, 0, 0), "1000 questions, 0 without a good answer"),
        (LineFigures(1000, 25, 0), "1000 questions, 25 without a good answer (2.50%)"),
        (LineFigures(1000, 0, 0, 1), "1000 questions, 0 without a good answer, lost once"),
        (LineFigures(1000, 0, 0, 2), "1000 questions, 0 without a good answer, lost 2 times"),
        (LineFigures(3, 0, 12), "3 questions, 0 without a good answer, 12 bytes nobody asked for"),
    ],
)
def test_figures_are_told_in_one_phrase(figures: LineFigures, expected: str) -> None:
    assert figures.in_words() == expected


def test_a_line_that_was_lost_is_told_as_that_though_it_gave_no_bad_answer() -> None:
    gone = "link lost: readouts.daq at socket://127.0.0.1:5: connection lost: the other side closed the connection"
    events = [
        event(1, "opened", 0.0, pid=7),
        event(2, "links", 1.0, **{"readouts.daq": [100, 0, 0], "axes.pitch": [10, 0, 0]}),
        event(3, "state", 1.5, to="held", reason=gone),
        event(4, "reconnect", 2.0, failed=gone),
        event(5, "reconnect", 3.0, failed=""),
        event(6, "state", 3.1, to="running", reason=gone),
        event(7, "links", 4.0, **{"readouts.daq": [40, 0, 0], "axes.pitch": [5, 0, 0]}),
    ]
    assert lines_in(events) == {"readouts.daq": LineFigures(140, 0, 0, 1), "axes.pitch": LineFigures(15, 0, 0)}


def test_a_run_tells_its_lines_in_status_and_report(tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    assert bench(tmp_path).run(run_dir).state is State.FINISHED
    lines = status(run_dir).lines
    assert set(lines) == {"axes.pitch", "readouts.dmm", "environment.air"}
    assert all(line.questions > 50 and line.errors == 0 for line in lines.values())
    with JournalReader.open(run_dir) as reader:
        sections = condition_sections(tuple(reader.events()))
    assert sections["lines"] == {name: line.in_words() for name, line in lines.items()}
    assert set(sections["watchdogs of the axes"]) == {"pitch", "roll"}


def test_lines_with_trouble_stand_one_by_one_and_the_others_together() -> None:
    lines = {
        "axes.pitch": LineFigures(30, 0, 0),
        "readouts.dmm": LineFigures(1000, 25, 0),
        "axes.roll": LineFigures(50, 0, 0),
    }
    counted = "as last counted (every hundred dwells and at a stop)"
    assert lines_in_words(lines) == [
        f"line of readouts.dmm, {counted}: 1000 questions, 25 without a good answer (2.50%)",
        f"lines without a bad answer, {counted}: axes.pitch (30 questions), axes.roll (50 questions)",
    ]
    assert lines_in_words({}) == []
