"""A step of the offset within what was declared of it is told, and the result stays usable."""

from math import sqrt

import numpy as np
import pytest
from physics_scenes.designs import Setup, schedule_of

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SHIFTS_WITHIN, SharedError
from ams.observations import Observations


@pytest.mark.parametrize(("limit_v", "verdict"), [(60e-6, "usable"), (20e-6, "not usable"), (0.0, "not usable")])
def test_a_step_is_held_up_to_the_declared_limit_and_not_beyond(limit_v: float, verdict: str) -> None:
    chance = np.random.default_rng(3)
    schedule = schedule_of(Setup(), chance)
    pitch, roll = np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg)
    outputs = specific_force(pitch, roll) + 8e-6 * chance.standard_normal((pitch.size, 3))
    outputs[400:, 0] += 40e-6
    rows = Observations(
        schedule.replication + 1, schedule.point + 1, pitch, roll, dict(zip("xyz", outputs.T, strict=True)),
        time_s=schedule.time_s,
    )  # fmt: skip
    declared = (SharedError(SHIFTS_WITHIN[0], "reading-course", limit_v / sqrt(3.0)),) if limit_v > 0.0 else ()
    solved = calibrate(rows, CalibrationRequest(shared_errors={"x": declared}))
    told = [entry for entry in solved.axes["x"].findings if entry.is_significant]
    assert "sensor-change" in {entry.kind for entry in told}
    assert solved.verdict == verdict
    assert any("largest_offset_shift_v" in entry.text for entry in told) == (verdict == "usable")
