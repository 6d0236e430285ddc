"""Laws of the times of rows: a clock that was set back is told, rows in another order are not."""

from dataclasses import replace

import numpy as np
import pytest

from ams.inputs.reading_times import clock_warnings
from ams.inputs.request import select_rows
from ams.observations import Observations

POINTS, REPLICATIONS, STEP_S = 14, 4, 60.0


def rows_of(time_s: np.ndarray, points: int = POINTS) -> Observations:
    size = time_s.size
    point = np.tile(np.arange(1, points + 1), size // points)
    replication, still = np.repeat(np.arange(1, size // points + 1), points), np.zeros(size)
    return Observations(replication, point, still, still, {"x": still}, time_s=time_s, source="rows.csv")


def steady(points: int = POINTS) -> np.ndarray:
    return STEP_S * np.arange(points * REPLICATIONS)


@pytest.mark.parametrize("jittered", [False, True])
@pytest.mark.parametrize("back_s", [70.0, 600.0, 3600.0, 1e6])
@pytest.mark.parametrize("at", [5, POINTS + 1, 2 * POINTS + 9, REPLICATIONS * POINTS - 2])
def test_a_clock_that_was_set_back_inside_a_replication_is_told_with_its_row(
    at: int, back_s: float, jittered: bool
) -> None:
    time_s = steady() + (np.random.default_rng(at).uniform(0.0, 9.0, POINTS * REPLICATIONS) if jittered else 0.0)
    time_s[at:] -= back_s
    (text,) = clock_warnings(rows_of(time_s))
    assert (
        f"replication {at // POINTS + 1}, point {at % POINTS + 1} is {time_s[at - 1] - time_s[at]:.4g} s before" in text
    )
    assert text.startswith("rows.csv: time_s goes back in mid-run")
    assert "time terms" in text


def test_a_clock_that_was_set_back_between_replications_by_all_that_had_gone_is_told() -> None:
    time_s = steady()
    time_s[2 * POINTS :] -= STEP_S * (2 * POINTS + 2)
    (text,) = clock_warnings(rows_of(time_s))
    assert "replication 3, point 1 is " in text


@pytest.mark.parametrize("points", [6, POINTS])
def test_times_that_begin_anew_with_every_replication_are_told(points: int) -> None:
    (text,) = clock_warnings(rows_of(np.tile(STEP_S * np.arange(points), REPLICATIONS), points))
    assert f"point 1 is {STEP_S * (points - 1):.4g} s before the row above it" in text
    assert "(3 such rows)" in text


def test_a_clock_that_stood_still_is_told() -> None:
    (text,) = clock_warnings(rows_of(np.full(POINTS * REPLICATIONS, 17.0)))
    assert text.startswith("rows.csv: time_s is 17 s in every row")
    assert clock_warnings(rows_of(np.repeat(steady()[::POINTS], POINTS))) == (), "the time of a replication is one"


def test_rows_in_another_order_than_they_were_read_in_are_none() -> None:
    rows = rows_of(steady())
    by_point = np.lexsort([rows.replication, rows.point])
    exchanged = np.concatenate([np.flatnonzero(rows.replication == label) for label in (3, 1, 4, 2)])
    backwards = np.arange(rows.rows)[::-1]
    shuffled = np.random.default_rng(1).permutation(rows.rows)
    for order in (np.arange(rows.rows), by_point, exchanged, backwards, shuffled):
        assert clock_warnings(select_rows(rows, order)) == ()
    assert clock_warnings(replace(rows, time_s=None)) == ()


@pytest.mark.parametrize("again", [(5,), (5, 6), (20, 40)])
def test_a_dwell_that_was_measured_again_in_its_old_place_is_none(again: tuple[int, ...]) -> None:
    time_s = steady()
    for count, row in enumerate(again):
        time_s[row] = STEP_S * (POINTS * REPLICATIONS + 3 + count)
    assert clock_warnings(rows_of(time_s)) == ()


def test_a_replication_that_was_measured_again_at_the_end_is_none() -> None:
    time_s = steady()
    time_s[POINTS : 2 * POINTS] += STEP_S * POINTS * REPLICATIONS
    assert clock_warnings(rows_of(time_s)) == ()
