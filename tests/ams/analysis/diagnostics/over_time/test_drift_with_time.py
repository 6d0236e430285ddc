"""Offsets that differ from replication to replication, each by chance, are no drift; what drifts evenly is."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.calibration.calibrate import calibrate
from ams.calibration_result import AxisCalibration
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

FloatArray = NDArray[np.float64]
NOISE_V, DWELL_S = 2e-5, 20.0
PITCH, ROLL = (angles.ravel() for angles in np.meshgrid(np.arange(-60.0, 61.0, 20.0), np.arange(0.0, 360.0, 45.0)))
Moved = Callable[[np.random.Generator, FloatArray, NDArray[np.int64]], FloatArray]
"""(N,) what the output is moved by, in noises of a dwell, by the share of the run that has passed and replication."""


def _jumps(size: float) -> Moved:
    return lambda chance, passed, replication: size * chance.standard_normal(replication.max() + 1)[replication]


def _line(size: float) -> Moved:
    return lambda chance, passed, replication: size * passed


def _told(seed: int, replications: int, moved: Moved) -> AxisCalibration:
    chance, points = np.random.default_rng([156, seed]), PITCH.size
    point = np.concatenate([chance.permutation(points) for _ in range(replications)])
    replication, time_s = np.repeat(np.arange(replications), points), DWELL_S * np.arange(point.size)
    pitch, roll = np.deg2rad(PITCH[point]), np.deg2rad(ROLL[point])
    read = specific_force(pitch, roll) @ [2.5, 0.015, -0.01] + NOISE_V * chance.standard_normal(point.size)
    read = read + NOISE_V * moved(chance, time_s / time_s[-1], replication)
    rows = Observations(replication + 1, point + 1, pitch, roll, {"x": read}, time_s=time_s)
    return calibrate(rows, CalibrationRequest()).axes["x"]


def _significant(solved: AxisCalibration) -> set[str]:
    return {str(entry.details.get("test")) for entry in solved.findings if entry.is_significant}


@pytest.mark.parametrize(
    ("replications", "size", "at_most"), [(2, 10.0, 1), (3, 1.0, 0), (3, 10.0, 0), (6, 1.0, 0), (6, 10.0, 0)]
)
def test_offsets_that_jump_are_not_said_to_drift_evenly(replications: int, size: float, at_most: int) -> None:
    """Beside the scatter of dwells they lie on a line of time in nearly every campaign.

    Of two replications that differ by little, nothing within them contradicts the line.
    """
    found = [_told(seed, replications, _jumps(size)) for seed in range(10)]
    assert sum("drift with time" in _significant(solved) for solved in found) <= at_most
    if size > 1.0:
        assert sum("drift of offset" in _significant(solved) for solved in found) >= 8


@pytest.mark.parametrize(("replications", "size"), [(2, 4.0), (3, 4.0), (6, 2.0)])
def test_what_drifts_evenly_is_said_to(replications: int, size: float) -> None:
    """From the first dwell to the last by as many noises of one."""
    told = ["drift with time" in _significant(_told(seed, replications, _line(size))) for seed in range(10)]
    assert sum(told) >= 9


def test_two_replications_that_differ_move_no_parameter_by_a_drift() -> None:
    for seed in range(6):
        assert "drift in the parameters" not in _significant(_told(seed, 2, _jumps(10.0)))
