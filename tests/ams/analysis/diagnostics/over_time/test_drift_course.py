"""A drift that is plain is told as that, and nothing else is told for it."""

import numpy as np
import pytest
from physics_scenes.designs import Setup, schedule_of

from ams.analysis.advice import advise
from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

NOISE_V, REPLICATIONS = 8e-6, 6


def measured(drift_v: float, order: str, seed: int, warmth_v_per_degc: float = 0.0) -> Observations:
    """Return an axis of 1 V/g that drifts evenly by so much a replication, in a room that wanders by itself."""
    chance = np.random.default_rng([31, seed])
    schedule = schedule_of(Setup(order=order, replications=REPLICATIONS), chance)
    pitch, roll = np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg)
    dwells = pitch.size
    above_degc = 0.0016 * np.cumsum(chance.standard_normal(dwells)) + 0.002 * chance.standard_normal(dwells)
    output = 0.01 + specific_force(pitch, roll) @ (1.0, 0.005, -0.004) + NOISE_V * chance.standard_normal(dwells)
    output += drift_v * np.linspace(0.0, REPLICATIONS, dwells) + warmth_v_per_degc * above_degc
    return Observations(
        schedule.replication + 1, schedule.point + 1, pitch, roll, {"x": output}, time_s=schedule.time_s,
        temperature_degc=22.0 + above_degc,
    )  # fmt: skip


def solved(drift_v: float, order: str, seed: int, warmth_v_per_degc: float = 0.0) -> AxisCalibration:
    return calibrate(measured(drift_v, order, seed, warmth_v_per_degc), CalibrationRequest()).axes["x"]


def told(axis: AxisCalibration) -> set[str]:
    return {finding.kind for finding in axis.findings if finding.is_significant}


@pytest.mark.parametrize("order", ["there-and-back", "random"])
@pytest.mark.parametrize("size_v", [10e-6, 30e-6, 100e-6, 1e-3])
def test_a_drift_rings_for_nothing_else(order: str, size_v: float) -> None:
    """It rang for a memory, a transient, a temperature and terms of second and third order in most campaigns."""
    for seed in range(3):
        axis = solved(size_v, order, seed)
        assert "drift" in told(axis) <= {"drift", "time-confounded"}
        assert axis.replication is not None
        offsets = [row["offset_v"] for row in axis.replication.per_replication.values()]
        assert np.ptp(offsets) == pytest.approx(size_v * (REPLICATIONS - 1), abs=4.0 * NOISE_V)


def test_a_room_that_wanders_is_no_drift_of_the_sensor() -> None:
    for seed in range(3):
        assert told(solved(0.0, "there-and-back", seed, warmth_v_per_degc=5e-3)) == {"temperature-residual"}


@pytest.mark.parametrize("size_v", [30e-6, 1e-3])
def test_the_advice_on_a_drift_is_about_the_drift(size_v: float) -> None:
    """It was that the residuals repeat as cos α, “usually the zero of the pitch axis or the level of the base”."""
    for seed in range(3):
        rows = measured(size_v, "there-and-back", seed)
        sentences = advise(calibrate(rows, CalibrationRequest()).axes["x"], rows).sentences
        assert any(sentence.startswith("Offset drifts by") for sentence in sentences)
        assert not any("usually" in sentence for sentence in sentences)
