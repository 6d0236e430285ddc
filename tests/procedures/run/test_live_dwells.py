"""What is told of a phase is told by the clock of who looks, however fast the twins live."""

import json
from datetime import UTC, datetime
from pathlib import Path

import pytest

from procedures.journal.live import LIVE_FILE, LiveFile
from procedures.plan.learned_times import PartTime
from procedures.plan.step_times import SETTLE
from procedures.plan.steps import Soak
from procedures.run.live_dwells import LiveDwells
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
