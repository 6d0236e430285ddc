"""Gyros on a table that turns slower than it says, in both senses, and gyros that bend of themselves.

The scene is a turn about one axis of the package at a time; what the table is slow by is known here and in no row.
"""

from collections.abc import Callable

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.observations import Observations

_RATES_DPS = (-100.0, -60.0, -30.0, 0.0, 30.0, 60.0, 100.0)
_NOISE_V, _V_PER_DPS = 2e-5, 0.02
_SEEDS = range(6)
_ALIKE = "are bent alike"


def _solved(
    seed: int,
    *,
    turned: Callable[[np.ndarray], np.ndarray] = lambda rates_dps: rates_dps,
    bent_ppm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    declared_ppm: float = 5.0,
    polarity: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Calibration:
    """``turned``: true rates of those that are stated; ``bent_ppm``: K₃ of each gyro, at the largest rate."""
    rng, replications = np.random.default_rng([153, seed]), 4
    stated = np.concatenate([np.outer(_RATES_DPS, axis) for axis in np.eye(3)])  # along x, y and z of the package
    points = len(stated)
    point = np.concatenate([rng.permutation(points) for _ in range(replications)])
    directions = np.diag(polarity) + 0.005 * rng.standard_normal((3, 3))
    sensed = turned(stated[point]) @ directions.T
    sensed = sensed + 1e-4 * np.array(bent_ppm) * (sensed / 100.0) ** 3
    read = _V_PER_DPS * sensed + 0.01 * rng.standard_normal(3) + _NOISE_V * rng.standard_normal(sensed.shape)
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
    errors = (SharedError("rate of the table", "rate", 1e-6 * declared_ppm),)
    return calibrate(rows, CalibrationRequest(model="gyro", shared_errors=dict.fromkeys("xyz", errors)))


def _slow(rates_dps: np.ndarray) -> np.ndarray:
    """By 0.01 °/s in both senses, as where something drags on the table."""
    return np.asarray(rates_dps - 0.01 * np.sign(rates_dps))


def _lopsided(rates_dps: np.ndarray) -> np.ndarray:
    """By 100 ppm in one sense."""
    return np.asarray(rates_dps * np.where(rates_dps > 0.0, 1.0 - 1e-4, 1.0))


def _is_said(solved: Calibration) -> bool:
    return any(_ALIKE in said.fact for axis in solved.axes.values() for said in axis.findings)


@pytest.mark.parametrize("turned", [_slow, _lopsided])
@pytest.mark.parametrize("polarity", [(1.0, 1.0, 1.0), (1.0, -1.0, 1.0)])
def test_a_table_that_is_slow_makes_the_result_of_its_gyros_not_usable(
    turned: Callable[[np.ndarray], np.ndarray], polarity: tuple[float, float, float]
) -> None:
    for seed in _SEEDS:
        solved = _solved(seed, turned=turned, polarity=polarity)
        assert (solved.verdict, _is_said(solved)) == ("not usable", True)


def test_a_table_that_is_slow_by_less_than_is_declared_is_not_said_to_be() -> None:
    for seed in _SEEDS:
        solved = _solved(seed, turned=_slow, declared_ppm=200.0)
        assert (solved.verdict, _is_said(solved)) == ("usable", False)


def test_gyros_that_bend_each_by_an_amount_of_its_own_are_not_the_table() -> None:
    for seed in _SEEDS:
        sizes = np.random.default_rng([154, seed]).permutation([150.0, 60.0, -100.0])
        solved = _solved(seed, bent_ppm=tuple(sizes.tolist()))
        assert any(said.kind == "cubic" and said.is_significant for said in solved.axes["x"].findings)
        assert not _is_said(solved)


def test_a_table_that_is_as_it_says_is_said_nothing_of() -> None:
    assert not any(_is_said(_solved(seed)) for seed in range(20))
