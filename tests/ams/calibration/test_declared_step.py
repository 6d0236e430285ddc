"""A step of offset or sensitivity within what was declared of it is told, and the result stays usable."""

import re
from math import sqrt

import numpy as np
import pytest
from physics_scenes.designs import Setup, schedule_of

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import COURSES, SHIFTS_WITHIN, SharedError
from ams.observations import Observations

LIMIT_V = 50e-6


@pytest.mark.parametrize(("limit_v", "verdict"), [(60e-6, "usable"), (20e-6, "not usable"), (0.0, "not usable")])
def test_a_step_is_held_up_to_the_declared_limit_and_not_beyond(limit_v: float, verdict: str) -> None:
    found, told = _stepped(40e-6, limit_v, 3)
    assert found == verdict
    assert ("within the declared largest_offset_shift_v of 60 µV" in told) == (verdict == "usable")
    assert ("the result is a mixture of both; measure them again" in told) == (verdict == "not usable")
    assert ("mixture" in told) == (verdict == "not usable")


@pytest.mark.parametrize(
    ("limit", "verdict", "words"),
    [
        (80e-6, "usable", ", within the declared largest_sensitivity_shift of 80 ppm"),
        (20e-6, "not usable", ", beyond the declared largest_sensitivity_shift of 20 ppm"),
        (0.0, "not usable", ""),
    ],
)
def test_a_step_of_the_sensitivity_is_held_against_the_limit_of_sensitivities(
    limit: float, verdict: str, words: str
) -> None:
    """Of 60 ppm of 1 V/g."""
    found, told = _stepped(0.0, limit, 3, gain=1.0 + 60e-6, which=1)
    assert found == verdict
    size, twice_u, after = re.search(r"by \+([\d.]+) ± ([\d.]+) ppm(.*)", told).groups()  # type: ignore[union-attr]
    assert abs(float(size) - 60.0) < 2.0 * float(twice_u)
    assert after.startswith(words)
    assert ("mixture" in told) == (verdict == "not usable")


@pytest.mark.parametrize(("step_v", "verdict"), [(LIMIT_V, "usable"), (1.2 * LIMIT_V, "not usable")])
def test_a_step_of_the_limit_is_within_and_one_of_a_fifth_more_beyond(step_v: float, verdict: str) -> None:
    for seed in range(4):
        found, told = _stepped(step_v, LIMIT_V, seed)
        assert found == verdict
        size, twice_u = map(float, re.search(r"by \+([\d.]+) ± ([\d.]+) µV, (?:within|beyond)", told).groups())  # type: ignore[union-attr]
        assert abs(1e-6 * size - step_v) < 2e-6 * twice_u


def _stepped(step_v: float, limit: float, seed: int, gain: float = 1.0, which: int = 0) -> tuple[str, str]:
    """Return the verdict and what is said of the step; ``which``: of whose limit, offset or sensitivity."""
    chance = np.random.default_rng(seed)
    schedule = schedule_of(Setup(), chance)
    pitch, roll = np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg)
    outputs = specific_force(pitch, roll) + 8e-6 * chance.standard_normal((pitch.size, 3))
    outputs[400:, 0] = gain * outputs[400:, 0] + step_v
    rows = Observations(
        schedule.replication + 1, schedule.point + 1, pitch, roll, dict(zip("xyz", outputs.T, strict=True)),
        time_s=schedule.time_s,
    )  # fmt: skip
    declared = (SharedError(SHIFTS_WITHIN[which], COURSES[which], limit / sqrt(3.0)),) if limit > 0.0 else ()
    solved = calibrate(rows, CalibrationRequest(shared_errors={"x": declared}))
    told = (entry for entry in solved.axes["x"].findings if entry.is_significant)
    return solved.verdict, next(entry.text for entry in told if entry.kind == "sensor-change")
