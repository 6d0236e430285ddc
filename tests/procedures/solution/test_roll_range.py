"""Laws of the roll range that a set is valid in: angles that go round leave no gap."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.solution.provenance import pitch_range_deg, roll_range_deg


@pytest.mark.parametrize(
    "roll_deg",
    [
        range(-180, 180, 30),
        range(-180, 180, 45),
        (-180.0, -90.0, 0.0, 90.0),
        (0.0, 120.0, 240.0),
        (0.0, 90.0, 180.0, 270.0, 90.0),
        range(-180, 181, 30),
    ],
)
def test_angles_that_go_round_are_valid_all_round(roll_deg: Sequence[float]) -> None:
    assert roll_range_deg(np.array(roll_deg, dtype=float)) == (-180.0, 180.0)


@pytest.mark.parametrize(
    ("roll_deg", "ends"),
    [
        (range(-180, 121, 30), (-180.0, 120.0)),
        ((-90.0, 0.0, 90.0), (-90.0, 90.0)),
        ((0.0, 180.0), (0.0, 180.0)),
        ((-45.0, 45.0), (-45.0, 45.0)),
        ((0.0,), (0.0, 0.0)),
        ((320.0, 340.0, 350.0, 0.0, 20.0, 40.0), (-40.0, 40.0)),
        ((-180.0, -160.0, 160.0, 140.0), (140.0, 200.0)),  # across 180°, ends counted on
        ((-180.0, 0.0, 180.0), (0.0, 180.0)),  # two places on the circle
    ],
)
def test_a_gap_wider_than_the_step_is_no_part_of_it(roll_deg: Sequence[float], ends: tuple[float, float]) -> None:
    assert roll_range_deg(np.array(roll_deg, dtype=float)) == ends


def test_pitch_is_counted_as_it_is_inferred() -> None:
    assert pitch_range_deg(np.array([330.0, 350.0, 0.0, 30.0])) == (-30.0, 30.0)
    assert pitch_range_deg(np.array([-180.0, 0.0, 180.0])) == (-180.0, 180.0)


def test_a_read_back_that_misses_by_an_arc_second_still_goes_round() -> None:
    read_deg = np.arange(-180.0, 180.0, 30.0) + np.random.default_rng(4).normal(0.0, 1.0 / 3600.0, 12)
    assert roll_range_deg(read_deg) == (-180.0, 180.0)
