"""From which side an axis came: the sense of its last move, and what is not known counts as neither."""

import numpy as np
import pytest

from ams.analysis.diagnostics.steps.approach import last_way, turned_by_play
from ams.frames import specific_force

NOWHERE = (0.0, 0.0)


def _way(degrees: list[float], order: list[int] | None = None, step: list[int] | None = None) -> list[float]:
    angle = np.deg2rad(degrees)
    in_time = np.arange(angle.size) if order is None else np.array(order)
    return last_way(angle, in_time, None if step is None else np.array(step)).tolist()


def test_an_axis_that_does_not_move_stays_where_it_lay_and_before_its_first_move_nobody_knows() -> None:
    assert _way([10.0, 10.0, 20.0, 20.0, -5.0, -5.0, 0.0]) == [0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 1.0]


def test_the_order_of_time_counts_and_not_that_of_the_rows() -> None:
    assert _way([0.0, 1.0, 2.0, 3.0], order=[3, 1, 2, 0]) == [-1.0, -1.0, 1.0, 0.0]


def test_after_a_step_that_is_no_row_nobody_knows_until_the_axis_moves_again() -> None:
    assert _way([0.0, 1.0, 2.0, 2.0, 1.0], step=[5, 6, 8, 9, 10]) == [0.0, 1.0, 0.0, 0.0, -1.0]
    assert _way([0.0, 1.0, 2.0, 2.0, 1.0], step=[5, 7, 9, 11, 13]) == [0.0, 1.0, 1.0, 1.0, -1.0]


def test_what_an_index_reads_otherwise_on_coming_back_is_no_move() -> None:
    assert _way([0.0, 10.0, 9.999, 9.998]) == [0.0, 1.0, 1.0, 1.0]


def _turned(pitch_deg: list[float], roll_deg: list[float], single_approach: frozenset[str] = frozenset()) -> np.ndarray:
    pitch, roll = np.deg2rad(pitch_deg), np.deg2rad(roll_deg)
    return turned_by_play(("pitch", "roll"), pitch, roll, None, np.arange(pitch.size), None, single_approach, NOWHERE)


def test_a_radian_of_play_turns_the_package_by_half_of_it_to_the_side_that_it_came_from() -> None:
    pitch, roll = [0.0, 40.0, 40.0, 10.0], [0.0, -30.0, 50.0, 50.0]
    found = _turned(pitch, roll)
    ways = {0: [0.0, 1.0, 1.0, -1.0], 3: [0.0, -1.0, 1.0, 1.0]}
    play = 1e-6
    for first, way in ways.items():
        angles = [np.deg2rad(pitch), np.deg2rad(roll)]
        clean = specific_force(*angles)
        angles[first // 3] = angles[first // 3] + 0.5 * play * np.array(way)
        np.testing.assert_allclose(play * found[:, first : first + 3], specific_force(*angles) - clean, atol=1e-12)


@pytest.mark.parametrize("axis", ["pitch", "roll"])
def test_an_axis_that_comes_from_one_side_always_shows_no_play(axis: str) -> None:
    rising, to_and_fro = [0.0, 10.0, 20.0, 30.0], [0.0, 10.0, 5.0, 30.0]
    angles = {"pitch": to_and_fro, "roll": to_and_fro}
    kept = slice(3, 6) if axis == "pitch" else slice(0, 3)
    gone = slice(0, 3) if axis == "pitch" else slice(3, 6)
    by_design = _turned(*({**angles, axis: rising}[name] for name in ("pitch", "roll")))
    by_machine = _turned(*angles.values(), frozenset({axis}))
    for found in (by_design, by_machine):
        assert not found[:, gone].any()
        assert found[:, kept].any()
