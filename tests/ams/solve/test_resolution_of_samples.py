"""Means of samples that came in steps: simulated sample by sample, and intervals hold whatever the noise."""

from dataclasses import dataclass

import numpy as np
import pytest

from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.inputs.samples_of_dwells import sampled_of
from ams.models.straight_line import StraightLine
from ams.observations import Observations

COUNTS_PER_G, SAMPLES, DRAWS = 1333.0, 30, 400
UP_DOWN, SEVEN = [-1.0, 1.0], np.linspace(-1.0, 1.0, 7).tolist()


@dataclass(frozen=True)
class _Held:
    inside: np.ndarray
    """(2,) share of the intervals of gain and offset that hold the truth."""
    stated: np.ndarray
    """(2,) root of the mean square of the standard uncertainties."""
    error: np.ndarray
    """(2,) the same of the errors."""


def _campaign(levels: list[float], replications: int, sigma: float, between: float = 0.0) -> _Held:
    """Whole counts of truth and noise: ``sigma`` from sample to sample, ``between`` from dwell to dwell."""
    chance, points = np.random.default_rng(27), len(levels)
    level = np.tile(levels, replications)
    slope = COUNTS_PER_G * (1.0 + chance.uniform(-0.05, 0.05, DRAWS))
    zero = chance.uniform(-20.0, 20.0, DRAWS)
    true = slope[:, None] * level + zero[:, None] + between * chance.standard_normal((DRAWS, level.size))
    samples = np.rint(true[..., None] + sigma * chance.standard_normal((*true.shape, SAMPLES)))
    still, point = np.zeros(level.size), np.tile(np.arange(points), replications)
    rows = Observations(
        np.repeat(np.arange(replications), points), point, still, still, {}, reference_level=level, time_s=None
    )
    model = StraightLine("x", "g", "counts")
    sampled = [sampled_of(list(of_draw), point, 1.0) for of_draw in samples]
    solved = solve_columns(rows, samples.mean(axis=2).T, [model] * DRAWS, sampled=sampled)
    return _held(solved, np.stack([1.0 / slope, -zero / slope], axis=1))


def _held(solved: SolvedColumns, truth: np.ndarray) -> _Held:
    found = [solved.parameters.estimates(row) for row in range(len(truth))]
    ends = np.array([[estimate.interval_95 for estimate in estimates] for estimates in found], dtype=float)
    values = np.array([[estimate.value for estimate in estimates] for estimates in found], dtype=float)
    stated = np.array([[estimate.standard_uncertainty for estimate in estimates] for estimates in found], dtype=float)
    inside = (ends[..., 0] <= truth) & (truth <= ends[..., 1])
    return _Held(inside.mean(axis=0), _root_mean(stated), _root_mean(values - truth))


def _root_mean(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


@pytest.mark.parametrize("levels", [UP_DOWN, SEVEN])
@pytest.mark.parametrize("steps_in_sigma", [0.1, 1.0, 1.8, 2.2, 3.0, 5.0, 10.0, 20.0])
def test_intervals_hold_through_the_step_that_noise_does_not_smooth(levels: list[float], steps_in_sigma: float) -> None:
    held = _campaign(levels, 6, 1.0 / steps_in_sigma)
    assert held.inside.min() >= 0.93


@pytest.mark.parametrize(("sigma", "between"), [(0.1, 0.1), (0.1, 0.3), (0.05, 1.0)])
def test_intervals_hold_where_points_move_within_their_step_from_dwell_to_dwell(sigma: float, between: float) -> None:
    held = _campaign(UP_DOWN, 6, sigma, between)
    assert held.inside.min() >= 0.93
    if between >= 0.3:
        assert np.all(held.stated <= 1.6 * held.error)


@pytest.mark.parametrize("steps_in_sigma", [0.1, 0.5, 1.0])
def test_uncertainties_are_those_of_the_noise_alone_where_it_is_a_step_or_more(steps_in_sigma: float) -> None:
    held = _campaign(UP_DOWN, 6, 1.0 / steps_in_sigma)
    assert np.all(held.stated <= 1.1 * held.error)


def test_single_dwells_that_do_not_scatter_are_uncertain_by_their_step() -> None:
    """GUM F.2.2.1: 1/√12 count at both ends of 2 g, however many samples agree."""
    held = _campaign([-1.0, 0.0, 1.0], 1, 1e-4)
    assert held.inside.min() >= 0.93
    assert held.stated[0] * COUNTS_PER_G**2 >= np.sqrt(2.0 / 12.0) / 2.0 * 0.95
