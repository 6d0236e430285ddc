"""Laws of the orders."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.description.procedure_file import Order
from procedures.plan import designs
from procedures.plan.order import sequence, travel_deg, visits

ORDERS = get_args(Order)
CIRCLE = designs.uniform_circle_deg(12, repeat=True)
NINETY = designs.full_grid(tuple(float(angle) for angle in range(-90, 91, 10)), CIRCLE)
HALF_CIRCLE = designs.full_grid(tuple(float(angle) for angle in range(-180, 181, 10)), CIRCLE)


def in_order(design, order, seed=5):
    return sequence(visits(design, order), order, np.random.default_rng(seed))


@given(
    order=st.sampled_from(ORDERS),
    rows=st.integers(1, 9),
    columns=st.integers(1, 9),
    every=st.sampled_from([(1, 1), (2, 2), (3, 2)]),
)
def test_every_order_visits_every_point_exactly_once(order, rows, columns, every):
    n, m = rows * every[0] + 1, columns * every[1] + 1
    design = designs.fractional(range(n), range(m), every)
    points = visits(design, order).points
    assert sorted(point.label for point in in_order(design, order)) == [point.label for point in points]


def test_forward_reverse_visits_every_attitude_twice_under_two_labels():
    visited = in_order(NINETY, "forward-reverse")
    out, back = visited[:247], visited[247:]
    assert [point.label + 247 for point in out] == [point.label for point in reversed(back)]
    assert [(p.pitch_deg, p.roll_deg) for p in out] == [(p.pitch_deg, p.roll_deg) for p in reversed(back)]
    assert [p.pitch_deg for p in out] == sorted(p.pitch_deg for p in out)


@pytest.mark.parametrize("design", [NINETY, HALF_CIRCLE])
def test_time_is_nearly_orthogonal_to_every_term_of_the_model_there_and_back(design):
    visited = in_order(design, "there-and-back")
    pitch, roll = (np.deg2rad([getattr(point, key) for point in visited]) for key in ("pitch_deg", "roll_deg"))
    time = np.arange(len(visited))
    for term in (pitch, np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)):
        assert abs(np.corrcoef(time, term)[0, 1]) < 0.1


def test_time_is_pitch_in_disguise_in_a_serpentine():
    """What there-and-back is for: the plain snake gives a drift the shape of a sensitivity."""
    visited = in_order(NINETY, "serpentine")
    assert np.corrcoef(np.arange(247), np.sin(np.deg2rad([point.pitch_deg for point in visited])))[0, 1] > 0.98


def test_there_and_back_goes_out_on_every_second_row_and_back_on_the_rows_between():
    visited = in_order(designs.full_grid(range(7), (0.0, 1.0)), "there-and-back")
    assert [point.pitch_deg for point in visited[::2]] == [0, 2, 4, 6, 5, 3, 1]
    assert [point.roll_deg for point in visited] == [0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1]


def test_raster_rolls_the_same_way_in_every_row():
    visited = in_order(designs.full_grid((0.0, 1.0), (0.0, 1.0, 2.0)), "raster")
    assert [(point.pitch_deg, point.roll_deg) for point in visited] == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]


def test_points_as_listed_are_visited_as_they_were_given():
    listed = designs.scattered("file", [(10.0, 0.0), (-20.0, 90.0), (10.0, -90.0), (0.0, 0.0)])
    assert in_order(listed, "as-listed") == listed.points


def test_blocks_finish_a_pitch_row_before_the_next():
    pitch = [point.pitch_deg for point in in_order(NINETY, "blocks")]
    rows = [pitch[start : start + 13] for start in range(0, 247, 13)]
    assert all(len(set(row)) == 1 for row in rows)
    assert [row[0] for row in rows] != sorted(row[0] for row in rows)


@pytest.mark.parametrize("order", ["neighbours", "blocks", "random", "seeded"])
def test_the_same_seed_gives_the_same_order_and_another_seed_another(order):
    assert in_order(NINETY, order, 1) == in_order(NINETY, order, 1)
    assert in_order(NINETY, order, 1) != in_order(NINETY, order, 2)


def test_there_and_back_travels_little_more_than_a_serpentine():
    def travel(order):
        return travel_deg([(point.pitch_deg, point.roll_deg) for point in in_order(NINETY, order)])

    assert travel("serpentine") == (180.0, 19 * 360.0)
    assert travel("there-and-back") == (180.0 + 10.0 + 160.0, 19 * 360.0)
    assert travel("raster") == (180.0, 19 * 360.0 + 18 * 360.0)


@given(
    rows=st.integers(2, 40),
    columns=st.integers(1, 14),
    span=st.sampled_from([20.0, 90.0, 180.0]),
    seed=st.integers(0, 1000),
)
def test_neighbours_travel_at_most_15_percent_more_than_a_serpentine(rows, columns, span, seed):
    design = designs.full_grid(np.linspace(-span, span, rows).tolist(), np.linspace(-180.0, 180.0, columns).tolist())

    def travel(order):
        return sum(travel_deg([(point.pitch_deg, point.roll_deg) for point in in_order(design, order, seed)]))

    assert travel("neighbours") <= 1.15 * travel("serpentine") + 1e-9


def test_neighbours_spread_a_replication_over_blocks_that_each_span_the_pitch_range():
    for seed in range(20):
        visited = in_order(NINETY, "neighbours", seed)
        pitch = np.array([point.pitch_deg for point in visited[::13]])
        assert np.sum(np.diff(np.sign(np.diff(pitch))) != 0) >= 1
        for half in (pitch[:10], pitch[10:]):
            assert half.min() <= -50.0
            assert half.max() >= 50.0
        assert abs(np.corrcoef(np.arange(247), np.sin(np.deg2rad([p.pitch_deg for p in visited])))[0, 1]) < 0.5
