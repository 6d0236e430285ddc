"""What a person sees of a run: the JSON of status, plain lines, and a bar in a terminal."""

import io
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from small_run import bench, in_child, killed_after

from procedures.journal.status.status import status
from procedures.records.progress import Progress, line_of
from procedures.records.states import State
from procedures.run.progress import Pace, PlainLines, shown_on
from rig.local_time import at_both

MOMENT = Progress(
    event="dwell",
    state=State.RUNNING,
    dwells_done=120,
    dwells_planned=1482,
    replication=1,
    replications=6,
    rate_per_min=7.43,
    eta_utc=datetime(2026, 3, 1, 4, 12, tzinfo=UTC),
    message="",
)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_line_tells_done_planned_rate_and_end() -> None:
    assert MOMENT.eta_utc is not None
    text = "running 120/1482 · replication 1 of 6 · 7.43 dwells/min · ends "
    assert line_of(MOMENT) == text + at_both(MOMENT.eta_utc)  # by the watch of whoever reads, wherever that is


def test_plain_lines_are_one_a_twentieth_and_every_state_and_rejection() -> None:
    lines: list[str] = []
    observer = PlainLines(lines.append)
    for done in range(1483):
        observer.on_event(replace(MOMENT, dwells_done=done))
    assert len(lines) == 21
    observer.on_event(replace(MOMENT, event="rejected", message="dmm.x: noise"))
    observer.on_event(replace(MOMENT, event="state", state=State.FINISHED))
    assert lines[-2].endswith("dmm.x: noise")
    assert lines[-1].startswith("finished 120/1482")


def test_a_stream_that_is_no_terminal_gets_plain_lines() -> None:
    stream = io.StringIO()
    with shown_on(stream) as observer:
        observer.on_event(MOMENT)
    assert stream.getvalue() == line_of(MOMENT) + "\n"


@pytest.mark.usefixtures("wide_terminal")
def test_a_terminal_gets_a_screen_and_the_rejections_above_it() -> None:
    stream = Terminal()
    with shown_on(stream) as observer:
        observer.on_event(MOMENT)
        observer.on_event(replace(MOMENT, event="rejected", message="dmm.x: [noise]"))
    assert "120 of 1482 dwells (8 %), replication 1 of 6" in stream.getvalue()
    assert "dmm.x: [noise]" in stream.getvalue()


def test_the_end_is_the_plans_at_first_and_the_measured_one_later() -> None:
    pace = Pace(planned_s=10.0, started_s=100.0)
    assert pace.remaining(10, 100.0) == timedelta(seconds=100.0)
    assert pace.rate_per_min(100.0) is None
    pace.done = 995
    assert pace.remaining(10, 100.0 + 995 * 20.0).total_seconds() == pytest.approx(199.5, rel=1e-6)
    assert pace.rate_per_min(100.0 + 995 * 20.0) == pytest.approx(3.0)


def test_the_status_of_a_finished_run_has_the_keys_of_the_command(tmp_path: Path) -> None:
    small, run_dir = bench(tmp_path), tmp_path / "run"
    small.run(run_dir)
    assert status(run_dir).to_document() == {
        "run": str(run_dir), "state": "finished", "dwells_done": 24, "dwells_planned": 24, "eta_utc": None,
        "held_by": None,
    }  # fmt: skip


def test_a_run_whose_process_died_is_interrupted(tmp_path: Path) -> None:
    small, run_dir = bench(tmp_path, rig=(("seed = 7", "seed = 7\ntime = 30.0"),)), tmp_path / "run"
    assert killed_after(in_child(lambda: small.run(run_dir)), 0.6)
    found = status(run_dir)
    assert (found.state, found.eta_utc, found.dwells_planned) == (State.INTERRUPTED, None, 24)


class Ends:
    """What the engine and the status say of the end at the same moments."""

    def __init__(self, run_dir: Path) -> None:
        self._run_dir = run_dir
        self.estimates: list[tuple[datetime, datetime | None, datetime | None]] = []

    def on_event(self, progress: Progress) -> None:
        if progress.state is State.RUNNING and progress.event == "dwell":
            found = status(self._run_dir)
            self.estimates += [(datetime.now(UTC), progress.eta_utc, progress.late_utc)]
            self.estimates += [(datetime.now(UTC), found.eta_utc, found.late_utc)]


def test_the_end_of_a_run_whose_twins_live_faster_is_told_by_a_persons_clock(tmp_path: Path) -> None:
    small = bench(tmp_path, rig=(("seed = 7", "seed = 7\ntime = 60.0"),))
    ends = Ends(tmp_path / "run")
    small.run(tmp_path / "run", observer=ends)
    finished, expected_s = datetime.now(UTC), small.plan.expected.p50_s
    assert len(ends.estimates) >= 2 * 24
    for now, median, late in ends.estimates:
        assert median is not None
        assert late is not None
        assert (
            now - timedelta(seconds=expected_s / 10.0)
            < median
            <= late
            < finished + timedelta(seconds=expected_s / 10.0)
        )
