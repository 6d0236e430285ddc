"""A wander that dwells share with the dwells before them is told as that, and hides nothing that is plainly there."""

import numpy as np
import pytest
from physics_scenes.designs import Setup, schedule_of

from ams.calibration.calibrate import calibrate
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FALSE = ("temperature-residual", "lack-of-fit", "wrong-dwell", "sensor-change", "table-rotation")


def told(correlation: float, order: str, seed: int, warmth_v_per_degc: float = 0.0) -> list[Finding]:
    """Return what is told of an axis whose noise is known to the next dwell, in a room that wanders by itself."""
    chance = np.random.default_rng([37, seed])
    schedule = schedule_of(Setup(order=order), chance)
    pitch, roll = np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg)
    noise = chance.standard_normal(pitch.size)
    for dwell in range(1, noise.size):
        noise[dwell] = correlation * noise[dwell - 1] + np.sqrt(1.0 - correlation**2) * noise[dwell]
    above_degc = 0.0016 * np.cumsum(chance.standard_normal(pitch.size))
    output = specific_force(pitch, roll) @ (1.0, 0.005, -0.004) + 8e-6 * noise + warmth_v_per_degc * above_degc
    rows = Observations(
        schedule.replication + 1, schedule.point + 1, pitch, roll, {"x": output}, time_s=schedule.time_s,
        temperature_degc=22.0 + above_degc,
    )  # fmt: skip
    return [entry for entry in calibrate(rows, CalibrationRequest()).axes["x"].findings if entry.is_significant]


@pytest.mark.parametrize(("correlation", "order"), [(0.6, "random"), (0.9, "random"), (0.9, "there-and-back")])
def test_a_wander_is_no_temperature_no_transient_and_no_lack_of_fit(correlation: float, order: str) -> None:
    """Beside the autocorrelation one of these was told in two of three campaigns."""
    found = [told(correlation, order, seed) for seed in range(8)]
    assert all("autocorrelation" in {entry.kind for entry in findings} for findings in found)
    false = [entry for findings in found for entry in findings if entry.kind in FALSE or "settles at" in entry.text]
    assert len(false) <= 1


def test_a_temperature_that_is_there_is_told_beside_a_wander() -> None:
    for seed in range(3):
        assert "temperature-residual" in {entry.kind for entry in told(0.6, "random", seed, warmth_v_per_degc=5e-3)}
