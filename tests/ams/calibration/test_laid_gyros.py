"""A package of gyros that is laid three ways on one vertical axis, with what its rows do not say.

The scene is a turn about one axis of the package at a time, and rows at rest in every laying; what every laying adds to
the outputs is known here and in no row. The larger it is, the plainer it is told.
"""

import numpy as np
import pytest

from ams.analysis.diagnostics.declared.earth_on_gyros import EARTH_ON_RATES
from ams.analysis.diagnostics.declared.laid_points import LAID_OTHERWISE
from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

_EARTH_DPS = 15.041067 / 3600.0
_NOISE_DPS = 1e-3
_TURNS = (-100.0, -60.0, -30.0, 30.0, 60.0, 100.0)
_REST = (*_TURNS[:3], 0.0, *_TURNS[3:])
_SEEDS = range(4)


def _solved(seed: int, added_dps: np.ndarray, rates_dps: tuple[float, ...]) -> Calibration:
    """``added_dps``: (3, 3) what the laying of a row adds to what each gyro senses."""
    rng, of_laying, replications = np.random.default_rng([148, seed]), len(rates_dps), 4
    stated = np.concatenate([np.outer(rates_dps, axis) for axis in np.eye(3)])  # along x, y and z of the package
    points = len(stated)
    point, laying = np.tile(np.arange(points), replications), np.tile(np.repeat(np.arange(3), of_laying), replications)
    directions = np.eye(3) + 0.005 * rng.standard_normal((3, 3))
    sensed = (stated[point] @ directions.T) + added_dps[laying]
    read = 0.02 * (sensed + _NOISE_DPS * rng.standard_normal(sensed.shape)) + 0.01 * rng.standard_normal(3)
    still = np.zeros(point.size)
    rows = Observations(
        np.repeat(np.arange(replications), points),
        point,
        still,
        still,
        dict(zip("xyz", read.T, strict=True)),
        yaw_rad=still,
        euler_rate_rad_s=np.deg2rad(stated[point][:, [1, 2, 0]]),  # of pitch (y), yaw (z) and roll (x)
        time_s=np.linspace(0.0, 120.0 * (point.size - 1), point.size, dtype=np.float64),
    )
    return calibrate(rows, CalibrationRequest(model="gyro"))


def _tests_of(solved: Calibration) -> set[str]:
    every = (said for axis in solved.axes.values() for said in axis.findings if said.is_significant)
    return {str(said.details.get("test")) for said in every}


@pytest.mark.parametrize("rates_dps", [_TURNS, _REST])
@pytest.mark.parametrize("part", [0.5, 0.8, 0.97])
def test_the_earth_along_the_axis_that_turns_is_told_however_large_it_is(
    part: float, rates_dps: tuple[float, ...]
) -> None:
    for seed in _SEEDS:
        solved = _solved(seed, part * _EARTH_DPS * np.eye(3), rates_dps)
        assert solved.verdict == "not usable"
        assert EARTH_ON_RATES in _tests_of(solved)


@pytest.mark.parametrize("rates_dps", [_TURNS, _REST])
@pytest.mark.parametrize("size", [3.0, 10.0, 100.0])
def test_a_zero_that_differs_between_layings_is_not_in_the_stated_uncertainties(
    size: float, rates_dps: tuple[float, ...]
) -> None:
    for seed in _SEEDS:
        added = size * _NOISE_DPS * np.random.default_rng([149, seed]).standard_normal((3, 3))
        assert _solved(seed, added, rates_dps).verdict == "not usable"


def test_points_that_are_stated_alike_and_read_alike_are_not_told() -> None:
    for seed in range(10):
        assert LAID_OTHERWISE not in _tests_of(_solved(seed, np.zeros((3, 3)), _REST))


def test_rows_at_rest_that_read_otherwise_are_told_as_that() -> None:
    added = 20.0 * _EARTH_DPS * np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    solved = _solved(0, added, _REST)
    assert LAID_OTHERWISE in _tests_of(solved)
    (said,) = [said for said in solved.axes["x"].findings if said.details.get("test") == LAID_OTHERWISE]
    assert float(str(said.details["size"])) == pytest.approx(20.0 * _EARTH_DPS * 0.02, rel=0.05)
