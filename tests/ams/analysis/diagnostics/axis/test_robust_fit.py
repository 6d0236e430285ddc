"""A robust fit beside the estimate: dwells that stand out to one side are told, long tails to both sides are not."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from ams.analysis.diagnostics.axis.robust_fit import robust_fit
from ams.calibration.output.believed import evidence_of
from ams.calibration.solving.columns import solve_columns
from ams.frames import specific_force
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations

FloatArray = NDArray[np.float64]
Noise = Callable[[np.random.Generator, tuple[int, ...]], FloatArray]
SEVEN_BY_EIGHT = [(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 45)]
THREE_BY_FOUR = [(p, r) for p in (-45, 0, 45) for r in range(-180, 180, 90)]
SHARE = 0.05 / 34
"""Of the level, what a test of a lone axis has."""


def _p_values(points: list[tuple[int, int]], replications: int, noise: FloatArray) -> FloatArray:
    """Return (m,) the chance that the test gives (n K, m) noise of a dwell, in its standard deviations."""
    pitch, roll = np.deg2rad(np.tile(points, (replications, 1)).astype(float)).T
    replication, point = np.divmod(np.arange(pitch.size), len(points))
    outputs = 0.002 + 2.5 * specific_force(pitch, roll)[:, :1] + 2e-5 * noise
    rows = Observations(replication + 1, point + 1, pitch, roll, {"x": outputs[:, 0]})
    evidence = evidence_of(solve_columns(rows, outputs, [PitchRoll("x")] * noise.shape[1]), rows)
    found = [robust_fit(evidence, evidence.grid.of(output)) for output in range(noise.shape[1])]
    return np.array([1.0 if test is None else test.p_value for test in found])


def _outliers(chance: np.random.Generator, dwells: int, campaigns: int, count: int, size: float) -> FloatArray:
    noise = chance.standard_normal((dwells, campaigns))
    struck = chance.permuted(np.tile(np.arange(dwells)[:, None], campaigns), axis=0)[:count]
    np.put_along_axis(noise, struck, np.take_along_axis(noise, struck, axis=0) + size, axis=0)
    return noise


@pytest.mark.parametrize(
    ("replications", "count", "size", "least"),
    [(4, 8, 5.0, 0.6), (4, 5, 7.0, 0.6), (4, 8, 7.0, 0.9), (3, 8, 5.0, 0.5), (6, 12, 5.0, 0.6)],
)
def test_a_few_dwells_of_few_replications_that_stand_out_to_one_side_are_told(
    replications: int, count: int, size: float, least: float
) -> None:
    """They feed the scatter from point to point: held against that, eight of 5 σ among 224 were told in one of 500."""
    noise = _outliers(np.random.default_rng(1), replications * len(SEVEN_BY_EIGHT), 200, count, size)
    assert np.mean(_p_values(SEVEN_BY_EIGHT, replications, noise) <= SHARE) >= least


def _normal(chance: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    return chance.standard_normal(shape)


def _student(dof: float) -> Noise:
    return lambda chance, shape: chance.standard_t(dof, shape)


def _read_to(step: float) -> Noise:
    """Return normal noise that a meter reads to a step, every point at its own place between two of them."""

    def drawn(chance: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
        place = np.resize(chance.uniform(0.0, step, (len(SEVEN_BY_EIGHT), shape[1])), shape)
        return step * np.round((chance.standard_normal(shape) + place) / step) - place

    return drawn


def _unsteady(chance: np.random.Generator, shape: tuple[int, ...]) -> FloatArray:
    """Return noise that is twice as large in the second half of the run."""
    return chance.standard_normal(shape) * np.where(np.arange(shape[0]) < shape[0] // 2, 1.0, 2.0)[:, None]


@pytest.mark.parametrize(
    ("noise", "most"),
    [
        pytest.param(_normal, 0.004, id="normal"),
        pytest.param(_student(8.0), 0.015, id="Student 8"),
        pytest.param(_student(5.0), 0.03, id="Student 5"),
        pytest.param(_read_to(1.0), 0.004, id="steps of a standard deviation"),
        pytest.param(_read_to(3.0), 0.015, id="steps of three"),
        pytest.param(_unsteady, 0.01, id="unsteady"),
    ],
)
@pytest.mark.parametrize("replications", [4, pytest.param(3, marks=pytest.mark.thorough)])
def test_noise_that_is_as_long_to_both_sides_is_told_no_more_than_its_share(
    noise: Noise, most: float, replications: int
) -> None:
    """Its share is 0.0015; beside one side's tail of a dozen dwells no test knows how long the other may be."""
    shape = (replications * len(SEVEN_BY_EIGHT), 2000)
    assert np.mean(_p_values(SEVEN_BY_EIGHT, replications, noise(np.random.default_rng(2), shape)) <= SHARE) <= most


@pytest.mark.parametrize(
    ("points", "replications"), [(SEVEN_BY_EIGHT, 3), (SEVEN_BY_EIGHT, 6), (THREE_BY_FOUR, 4), (THREE_BY_FOUR, 10)]
)
def test_normal_noise_is_told_as_often_as_its_chance_says(points: list[tuple[int, int]], replications: int) -> None:
    noise = np.random.default_rng(3).standard_normal((replications * len(points), 1500))
    p_values = _p_values(points, replications, noise)
    assert np.mean(p_values <= 0.05) <= 0.06
    assert np.mean(p_values <= 0.01) <= 0.015
