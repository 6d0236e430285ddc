"""What is told of a phase is told by the clock of who looks, however fast the twins live."""

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

import pytest
from asking import put
from small_run import bench
from unattended_run import UnattendedRun, asks, run_unattended

from procedures.journal.sidecar.live import LIVE_FILE, LiveFile, read_live
from procedures.plan.learned_times import PartTime
from procedures.plan.step_times import SETTLE
from procedures.plan.steps import Soak
from procedures.records.progress import Progress
from procedures.records.states import State
from procedures.run.live_dwells import LiveDwells, usual_moves_s
from procedures.run.services import RunServices
from rig.clock import VirtualClock


@pytest.mark.parametrize("factor", [1.0, 20.0])
def test_phases_and_soaks_are_told_in_seconds_of_who_looks(tmp_path: Path, factor: float) -> None:
    clock = VirtualClock(datetime(2026, 3, 1, tzinfo=UTC))
    file = LiveFile(tmp_path, clock)
    dwells = LiveDwells(file, {SETTLE: PartTime(82, 984.0, 1230.0, 12.0, 15.0)}, factor)

    def seen() -> dict[str, object]:
        clock.sleep(2.0)
        file.look()
        found: dict[str, object] = json.loads((tmp_path / LIVE_FILE).read_text(encoding="utf-8"))
        return found

    dwells.phase("settling")
    found = seen()
    assert (found["usual_s"], found["seldom_over_s"]) == (12.0 / factor, 15.0 / factor)
    tell = dwells.soaks(Soak(3, 1, "air", 20.0, 1.0, 1800.0))
    assert seen()["soak_left_s"] == 1800.0 / factor
    tell(20.1, 600.0)
    assert seen()["soak_left_s"] == 600.0 / factor


def test_a_way_is_told_with_how_long_it_usually_takes(tmp_path: Path) -> None:
    """A quarter of a turn at 180 deg/s takes half a second, beside 1.3 s of the coupling."""
    small = bench(tmp_path)
    ways_s = usual_moves_s(small.rig, small.plan)
    first, second = (dwell for dwell in small.plan.design_dwells if dwell.step in (7, 8))
    assert first.targets_deg["pitch"] == second.targets_deg["pitch"]
    assert abs(first.targets_deg["roll"] - second.targets_deg["roll"]) == 90.0
    assert ways_s[8][0] == pytest.approx(0.5 + 1.3)

    clock = VirtualClock(datetime(2026, 3, 1, tzinfo=UTC))
    file = LiveFile(tmp_path, clock)
    LiveDwells(file, {}, 20.0, ways_s).moves(second, [])
    clock.sleep(2.0)
    file.look()
    found = json.loads((tmp_path / LIVE_FILE).read_text(encoding="utf-8"))
    assert found["usual_s"] == pytest.approx(1.8 / 20.0)
    assert found["seldom_over_s"] >= found["usual_s"]


def test_a_pause_that_is_asked_for_in_a_soak_is_shown_as_waiting(tmp_path: Path) -> None:
    """A soak takes hours: who asked must see that it was heard, and what it waits for."""
    small = bench(tmp_path, procedure=(("[check]", "[environment]\nplateaus_degc = [30.0]\nsoak_s = 600.0\n[check]"),))
    run_dir = tmp_path / "run"
    seen: list[tuple[str, str, str]] = []

    class Racing(UnattendedRun):
        """Seconds pass at every look, so that every look is written."""

        def monotonic_s(self) -> float:
            self._clock.sleep(1.0)
            return super().monotonic_s()

        def on_event(self, progress: Progress) -> None:
            if progress.event == "soak":
                put(self.spool, "pause", "anna")
            super().on_event(progress)

    def pulse() -> Sequence[Mapping[str, object]]:
        if (live := read_live(run_dir)) is not None:
            seen.append((live.phase, live.pending_request, live.waiting_for))
        return ()

    unattended = Racing(run_dir, at={3: asks("continue")})
    outcome = run_unattended(small, unattended, RunServices(pulse=pulse))
    assert outcome.state is State.FINISHED
    assert {asked for phase, asked, _ in seen if phase == "soaking"} == {"", "pause, by anna"}
    first = seen.index(("waiting", "", "a person to say continue"))
    assert {asked for _, asked, _ in seen[first:]} == {""}, "it was done"
