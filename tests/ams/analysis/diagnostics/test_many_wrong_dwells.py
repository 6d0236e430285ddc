"""Wrong dwells that hide each other in the scatter they make are named; a coarse meter's other step is none of them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.findings import Finding
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
REPLICATIONS, NOISE_V, SENSITIVITY_V_PER_G = 4, 2e-5, 2.5
PITCH, ROLL = (angles.ravel() for angles in np.meshgrid(np.arange(-60.0, 61.0, 20.0), np.arange(0.0, 360.0, 45.0)))
DWELLS = REPLICATIONS * PITCH.size


def _solved(read_v: FloatArray, chance: np.random.Generator) -> AxisCalibration:
    """Solve what is read beside a linear sensor, points in an order of their own in every replication."""
    point = np.concatenate([chance.permutation(PITCH.size) for _ in range(REPLICATIONS)])
    pitch, roll = np.deg2rad(PITCH[point]), np.deg2rad(ROLL[point])
    outputs = specific_force(pitch, roll) @ [SENSITIVITY_V_PER_G, 0.015, -0.01] + 0.002 + read_v
    rows = Observations(np.repeat(np.arange(REPLICATIONS) + 1, PITCH.size), point + 1, pitch, roll, {"x": outputs})
    return calibrate(rows, CalibrationRequest()).axes["x"]


def _named(solved: AxisCalibration) -> list[Finding]:
    found = [entry for entry in solved.findings if entry.kind == "wrong-dwell" and entry.is_significant]
    return [entry for entry in found if entry.details["test"] == "wrong dwell"]


@pytest.mark.parametrize("size", [20.0, pytest.param(100.0, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("wrong", [3, 11, 16])
def test_wrong_dwells_that_hide_each_other_are_named(wrong: int, size: float) -> None:
    """Of 224, either way: of 16 none was named in 15 of 20 campaigns, and the result was usable without a word."""
    told = 0
    for seed in range(10):
        chance = np.random.default_rng([1, seed])
        read_v = NOISE_V * chance.standard_normal(DWELLS)
        off = chance.choice(DWELLS, wrong, replace=False)
        read_v[off] += size * NOISE_V * chance.choice([-1.0, 1.0], wrong)
        named = _named(_solved(read_v, chance))
        told += bool(named)
        listed = sum(entry.text.count("standard deviations of a dwell") for entry in named)
        assert listed <= 5, "a sentence names five and counts the others"
    assert told >= 9


def test_no_dwell_of_plain_noise_is_named() -> None:
    """At 5 % of all tests of a campaign, hardly one in a hundred names a dwell."""
    rings = 0
    for seed in range(30):
        chance = np.random.default_rng([2, seed])
        rings += bool(_named(_solved(NOISE_V * chance.standard_normal(DWELLS), chance)))
    assert rings <= 1


@pytest.mark.parametrize("steps", [0.05, 0.1])
def test_a_reading_that_is_rounded_the_other_way_is_not_wrong(steps: float) -> None:
    """Noise far below a meter's step: a few dwells read one step beside the others of their point.

    Those were "wrong by 20 standard deviations" in one campaign of three, and taken out they left nothing to test.
    """
    step_v = 1e-4
    for seed in range(8):
        chance = np.random.default_rng([3, seed])
        point = np.concatenate([chance.permutation(PITCH.size) for _ in range(REPLICATIONS)])
        pitch, roll = np.deg2rad(PITCH[point]), np.deg2rad(ROLL[point])
        exact = specific_force(pitch, roll) @ [SENSITIVITY_V_PER_G, 0.015, -0.01] + 0.002
        read = np.round((exact + steps * step_v * chance.standard_normal(DWELLS)) / step_v) * step_v
        replication = np.repeat(np.arange(REPLICATIONS) + 1, PITCH.size)
        solved = calibrate(Observations(replication, point + 1, pitch, roll, {"x": read}), CalibrationRequest())
        assert not _named(solved.axes["x"])
        assert solved.axes["x"].findings
