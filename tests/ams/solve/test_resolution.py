"""Steps of a meter that are large beside the noise: their size is told, and intervals hold."""

import numpy as np
import pytest
from physics_scenes import campaigns
from solved_campaigns import coverage, solved

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration, ParameterEstimate
from ams.inputs.request import CalibrationRequest
from ams.inputs.step_of_readings import _may_repeat, step_of, steps_of
from ams.models.straight_line import StraightLine
from ams.observations import Observations
from ams.solve.resolution import NAME, shared_variance


@pytest.mark.parametrize("step", [5e-4, 1e-4 / 3.0, 20.0 / 2**21])
def test_the_step_is_told_whatever_its_size(step: float) -> None:
    """A 24-bit converter's least digit, or a meter's last: from an offset, printed to seven places of a volt."""
    chance = np.random.default_rng(4)
    true = np.tile(chance.uniform(-2.5, 2.5, 150), 6) + 0.1 * step * chance.standard_normal(900)
    read = np.round(step * np.rint(true / step) + 0.0123456, 9)
    assert step_of(read) == pytest.approx(step, rel=1e-6)


def test_no_step_is_told_of_noise_or_of_readings_without_any() -> None:
    chance = np.random.default_rng(5)
    true = np.tile(chance.uniform(-2.5, 2.5, 150), 6)
    assert step_of(true + 2e-5 * chance.standard_normal(900)) is None
    assert step_of(true) is None
    assert step_of(np.full(900, 0.3)) is None


@pytest.mark.parametrize("sigma", [0.0, 0.05, 0.1, 0.2, 0.3, 0.5])
def test_what_replications_share_is_what_rounding_leaves_of_a_true_value(sigma: float) -> None:
    """Drawn: true values anywhere in a step, their mean error over ever so much noise; by the scatter that it shows."""
    chance = np.random.default_rng(6)
    true = chance.uniform(0.0, 1.0, 4000)
    read = np.rint(true[:, None] + sigma * chance.standard_normal((4000, 400)))
    error, scatter = (read - true[:, None]).mean(axis=1), read.var(axis=1, ddof=1).mean()
    drawn = error.var() - scatter / 400
    assert shared_variance(1.0, scatter, true.size) == pytest.approx(drawn, rel=0.06, abs=3e-4)


@pytest.mark.parametrize(
    ("size", "count"),
    [(500.0, 40), *(pytest.param(size, 400, marks=pytest.mark.thorough) for size in (50.0, 100.0, 200.0, 500.0))],
)
def test_intervals_hold_on_a_staircase(size: float, count: int) -> None:
    drawn = campaigns("quantisation", size, np.random.default_rng(7), count)
    held = coverage(drawn, solved(drawn), np.random.default_rng(1))
    assert min(held.offset, held.sensitivities, held.prediction) > (0.93 if count > 100 else 0.9)


@pytest.mark.parametrize("size", [0.0, 20.0])
def test_nothing_changes_where_the_noise_is_larger_than_half_a_step(size: float) -> None:
    drawn = campaigns("quantisation", size, np.random.default_rng(8), 5)
    for columns in solved(drawn).values():
        parts = {part.name: part.covariance for part in columns.components}
        assert np.all(parts.get(NAME, 0.0) < 1e-4 * columns.primary_covariance.max())


def test_the_rough_look_at_columns_leaves_out_none_whose_step_shows() -> None:
    """Readings that count as one value by 1e-9 of the span, on either side of any rough one: a twentieth of them."""
    chance = np.random.default_rng(8)
    true = chance.uniform(-2.5, 2.5, (900, 40))
    read = np.round(true / 1e-3) * 1e-3 + chance.uniform(-4e-10, 4e-10, true.shape) * 5.0
    few = true.copy()
    few[855:] = few[:45] + 0.9e-9 * np.ptp(few, axis=0)  # 45 of 900: as few as may show a step
    columns = np.column_stack([read, few, np.full((900, 1), 0.3), true])
    assert steps_of(columns) == [step_of(column) for column in columns.T]
    assert all(steps_of(read))
    assert _may_repeat(np.ascontiguousarray(few.T)).all()
    assert not _may_repeat(np.ascontiguousarray(true.T)).any()


def _line(levels: list[float], replications: int, read: np.ndarray) -> Calibration:
    """Of whole counts, replication by replication."""
    points = len(levels)
    still = np.zeros(read.size)
    rows = Observations(
        np.repeat(np.arange(replications), points),
        np.tile(np.arange(points), replications),
        still,
        still,
        {"x": read},
        units={"x": "counts"},
        reference_level=np.tile(levels, replications),
    )
    models = {"x": StraightLine("x", "ut", "counts")}
    return calibrate(rows, CalibrationRequest(nominal_axes={"x": "x"}, models=models))


def _estimates(levels: list[float], replications: int, read: np.ndarray) -> list[ParameterEstimate]:
    """Gain and offset."""
    return list(_line(levels, replications, read).axes["x"].parameters)


def test_two_levels_of_whole_counts_that_repeat_are_uncertain_by_the_rounding_of_each() -> None:
    """By hand, GUM F.2.2.1: u = 1/sqrt(12) count each, the slope by their difference over 80 and the zero by half."""
    gain, offset = _estimates([-40.0, 40.0], 4, np.tile([-1228.0, 1252.0], 4))
    rounding, slope = np.sqrt(1.0 / 12.0), 31.0
    assert gain.standard_uncertainty == pytest.approx(np.sqrt(2.0) * rounding / 80.0 / slope**2, rel=1e-6)
    of_slope = 12.0 / slope**2 * np.sqrt(2.0) * rounding / 80.0
    expected = np.hypot(rounding / np.sqrt(2.0) / slope, of_slope)
    assert offset.standard_uncertainty == pytest.approx(expected, rel=1e-6)


_TWO, _THREE, _FIVE, _ELEVEN = ([*np.linspace(-50.0, 50.0, size).tolist()] for size in (2, 3, 5, 11))


@pytest.mark.parametrize(
    ("levels", "replications", "counts_per_ut", "noise"),
    [
        (_TWO, 4, 31.0, 0.0),
        (_TWO, 4, 31.0, 0.05),
        (_TWO, 4, 31.0, 0.2),
        (_THREE, 4, 31.0, 0.05),
        (_THREE, 1, 31.0, 0.05),
        (_FIVE, 4, 31.0, 0.0),
        (_FIVE, 4, 31.0, 0.1),
        (_FIVE, 4, 31.0, 0.5),
        (_FIVE, 1, 31.0, 0.1),
        (_FIVE, 4, 0.3, 0.1),
        (_ELEVEN, 4, 0.5, 0.1),
        (_ELEVEN, 4, 0.1, 0.0),
    ],
)
def test_intervals_of_lines_hold_in_whole_counts(
    levels: list[float], replications: int, counts_per_ut: float, noise: float
) -> None:
    """However few different readings there are; 0.1 count/µT puts all eleven levels at one place within a count."""
    held = []
    for seed in range(60):
        chance = np.random.default_rng(seed)
        slope = counts_per_ut * (1.0 if counts_per_ut < 0.2 else 1.0 + chance.uniform(-0.3, 0.3))
        zero = chance.uniform(-20.0, 20.0)
        true = slope * np.tile(levels, replications) + zero
        estimates = _estimates(levels, replications, np.rint(true + noise * chance.standard_normal(true.size)))
        for estimate, truth in zip(estimates, (1.0 / slope, -zero / slope), strict=True):
            assert estimate.interval_95 is not None
            assert estimate.standard_uncertainty > 0.0
            low, high = estimate.interval_95
            held.append(low <= truth <= high)
    assert np.mean(held) >= 0.93


@pytest.mark.parametrize(
    ("read", "step"),
    [
        ([-1228.0, 1252.0], 1.0),
        ([1.2340, 1.2350, -1.2340], 1e-3),
        ([-1228.0, -614.0, 0.0, 614.0, 1228.0], 1.0),  # evenly spaced: the levels, and no step of 614
        ([0.31234567, 1.71234891, -0.91234617], None),  # eight digits: no meter repeats them by its step
    ],
)
def test_few_readings_show_their_last_decimal(read: list[float], step: float | None) -> None:
    assert step_of(np.tile(read, 4)) == (None if step is None else pytest.approx(step))


def test_few_readings_show_a_step_that_is_no_decimal() -> None:
    """A converter of 1333 counts/g, read at six attitudes."""
    step = 9.80665 / 1333.0
    assert step_of(np.tile(step * np.array([-1290.0, -7.0, 3.0, 11.0, 802.0, 1361.0]), 4)) == pytest.approx(step)


def test_an_uncertainty_of_nothing_is_said_where_readings_repeat_and_no_step_shows() -> None:
    """Eight digits that no meter repeats; with the step of their last decimal nothing needs to be said."""
    exact = _line(_TWO, 4, np.tile([-1.2345678123, 1.3123456789], 4))
    assert [estimate.standard_uncertainty for estimate in exact.axes["x"].parameters] == pytest.approx([0.0, 0.0])
    (warning,) = [text for text in exact.axes["x"].warnings if "no step of a meter shows" in text]
    assert warning.startswith("axis x: nothing scatters")
    assert exact.verdict != "sound"
    stepped = _line(_TWO, 4, np.tile([-1.234, 1.312], 4))
    assert not any("no step of a meter shows" in text for text in stepped.axes["x"].warnings)
    uneven = _line(_FIVE, 4, np.tile([-15.0, -7.0, 0.0, 7.0, 16.0], 4))
    assert not any("no step of a meter shows" in text for text in uneven.axes["x"].warnings)
