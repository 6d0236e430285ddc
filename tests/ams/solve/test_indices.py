"""Indices of an axis from angles as they are read back: those of the design, as long as that is coarser."""

import numpy as np
import pytest

from ams.solve.indices import READ_BACK_RAD, has_moved, index_around, index_of, is_back

PITCH_DEG, ROLL_DEG = np.arange(-75.0, 76.0, 25.0), np.arange(-180.0, 180.0, 45.0)
JITTERS_DEG = (0.0, 1e-6, 5e-4, 2e-3, 5e-3, 0.02)


def _read_back(at_deg: np.ndarray, jitter_deg: float) -> np.ndarray:
    return np.deg2rad(at_deg + jitter_deg * np.random.default_rng(5).standard_normal(at_deg.size))


@pytest.mark.parametrize("jitter_deg", JITTERS_DEG)
def test_indices_are_those_of_the_design_whatever_is_read_back(jitter_deg: float) -> None:
    number, mean = index_of(_read_back(np.tile(PITCH_DEG, 8), jitter_deg))
    np.testing.assert_array_equal(number, np.tile(np.arange(7), 8))
    np.testing.assert_allclose(np.rad2deg(mean), PITCH_DEG, atol=2.0 * jitter_deg + 1e-9)


@pytest.mark.parametrize("jitter_deg", JITTERS_DEG)
@pytest.mark.parametrize("turned_deg", [0.0, 22.5, 180.0])
def test_half_a_turn_is_one_index_from_either_side(jitter_deg: float, turned_deg: float) -> None:
    at_deg = np.tile(ROLL_DEG + turned_deg, 7)
    number, mean = index_around(_read_back(at_deg, jitter_deg))
    assert mean.size == ROLL_DEG.size
    assert np.all(number.reshape(7, 8) == number[:8])
    assert np.all(np.abs(mean) <= np.pi)
    off = np.exp(1j * mean[number]) / np.exp(1j * np.deg2rad(at_deg))
    assert np.abs(np.angle(off, deg=True)).max() <= 2.0 * jitter_deg + 1e-9


def test_a_grid_finer_than_what_is_read_back_keeps_its_indices() -> None:
    fine_deg = 0.05 * np.arange(9)
    for at_deg in (0.4 * fine_deg, fine_deg, np.append(fine_deg, [40.0, 80.0])):
        number, mean = index_of(np.deg2rad(np.tile(at_deg, 3)))
        assert mean.size == at_deg.size
        np.testing.assert_array_equal(number, np.tile(np.arange(at_deg.size), 3))


@pytest.mark.parametrize("jitter_deg", JITTERS_DEG)
def test_an_axis_moves_where_its_index_changes_and_by_a_whole_turn(jitter_deg: float) -> None:
    raster = np.repeat(PITCH_DEG, 8)
    np.testing.assert_array_equal(has_moved(_read_back(raster, jitter_deg)), np.diff(raster) != 0.0)
    assert has_moved(np.deg2rad([-180.0, 180.0])).all()


def test_an_axis_is_back_from_either_side_of_half_a_turn_but_not_a_step_away() -> None:
    before = np.deg2rad(np.append(PITCH_DEG, 179.99))
    assert is_back(np.deg2rad(np.append(PITCH_DEG + 0.05, -179.99)), before).all()
    assert not is_back(before + 1.01 * READ_BACK_RAD, before).any()
