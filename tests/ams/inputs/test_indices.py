"""Indices of an axis from angles as they are read back: those of the design, as long as that is coarser."""

import numpy as np
import pytest

from ams.inputs.indices import are_back, has_moved, index_around, index_of

PITCH_DEG, ROLL_DEG = np.arange(-75.0, 76.0, 25.0), np.arange(-180.0, 180.0, 45.0)
SCATTERS_DEG = (0.0, 1e-6, 5e-4, 2e-3, 5e-3, 0.02, 0.05)
STRAYS_DEG = (0.0, 1e-3, 0.02, 0.1, 0.15, 0.2, 0.3, 0.4, 1.0)
GRIDS = [(1.0, 21), (2.0, 9), (5.0, 37), (25.0, 7), (90.0, 3)]
NIGHTS = 25


def _read_back(at_deg: np.ndarray, scatter_deg: float, seed: int = 5) -> np.ndarray:
    return np.deg2rad(at_deg + scatter_deg * np.random.default_rng(seed).standard_normal(at_deg.shape))


def _same_partition(number: np.ndarray, at_deg: np.ndarray) -> bool:
    pairs = np.unique(np.stack([number, at_deg]), axis=1).shape[1]
    return bool(pairs == np.unique(number).size == np.unique(at_deg).size)


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize(("step_deg", "count"), GRIDS)
@pytest.mark.parametrize("dwells", [4, 8, 32])
def test_indices_are_those_of_the_design_whatever_is_read_back(
    dwells: int, step_deg: float, count: int, scatter_deg: float
) -> None:
    at_deg = np.tile(step_deg * (np.arange(count) - count // 2), dwells)
    for night in range(NIGHTS):
        number, mean = index_of(_read_back(at_deg, scatter_deg, night))
        np.testing.assert_array_equal(number, np.tile(np.arange(count), dwells))
        np.testing.assert_allclose(np.rad2deg(mean), at_deg[:count], atol=5.0 * scatter_deg / dwells**0.5 + 1e-9)


@pytest.mark.parametrize("scatter_counts", [0.0, 0.1, 0.4, 0.8])
@pytest.mark.parametrize("count_deg", [0.001, 0.005, 0.01, 0.02, 0.025, 0.05, 360.0 / 2**13])
@pytest.mark.parametrize(("step_deg", "count"), [(1.0, 21), (5.0, 37), (90.0, 3)])
def test_an_angle_that_is_read_as_the_next_count_is_the_same_index(
    step_deg: float, count: int, count_deg: float, scatter_counts: float
) -> None:
    """Encoders of 13 bits, servos of 0.25 µs, displays of 0.01°: an axis between two counts reads either."""
    chance = np.random.default_rng(8)
    for night in range(NIGHTS):
        at_deg = step_deg * (np.arange(count) - count // 2) + chance.uniform(-0.5, 0.5, count) * count_deg
        stood = np.tile(at_deg, 6) + scatter_counts * count_deg * chance.standard_normal(6 * count)
        number, _ = index_of(np.deg2rad(np.rint(stood / count_deg) * count_deg))
        np.testing.assert_array_equal(number, np.tile(np.arange(count), 6), err_msg=f"night {night}")


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize("stray_deg", STRAYS_DEG)
@pytest.mark.parametrize("step_deg", [2.0, 25.0])
def test_a_dwell_that_was_off_changes_no_other(step_deg: float, stray_deg: float, scatter_deg: float) -> None:
    count = PITCH_DEG.size
    raster = np.tile(np.repeat(step_deg * np.arange(count), ROLL_DEG.size), 2)
    others = np.arange(raster.size) != 17
    for night in range(NIGHTS):
        angle = _read_back(raster, scatter_deg, night)
        angle[17] += np.deg2rad(stray_deg) * (-1) ** night
        number, _ = index_of(angle)
        assert _same_partition(number[others], raster[others])
        assert np.unique(number).size <= count + 1
        moved, is_known = has_moved(angle), others[1:] & others[:-1]
        np.testing.assert_array_equal(moved[is_known], (np.diff(raster) != 0.0)[is_known])


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize("turned_deg", [0.0, 22.5, 180.0])
def test_half_a_turn_is_one_index_from_either_side(scatter_deg: float, turned_deg: float) -> None:
    at_deg = np.tile(ROLL_DEG + turned_deg, 7)
    number, mean = index_around(_read_back(at_deg, scatter_deg))
    assert mean.size == ROLL_DEG.size
    assert np.all(number.reshape(7, 8) == number[:8])
    assert np.all(np.abs(mean) <= np.pi)
    off = np.exp(1j * mean[number]) / np.exp(1j * np.deg2rad(at_deg))
    assert np.abs(np.angle(off, deg=True)).max() <= 2.0 * scatter_deg + 1e-9


def test_a_grid_finer_than_what_is_read_back_keeps_its_indices() -> None:
    fine_deg = 0.05 * np.arange(9)
    for at_deg in (0.4 * fine_deg, fine_deg, np.append(fine_deg, [40.0, 80.0])):
        number, mean = index_of(np.deg2rad(np.tile(at_deg, 3)))
        assert mean.size == at_deg.size
        np.testing.assert_array_equal(number, np.tile(np.arange(at_deg.size), 3))


@pytest.mark.parametrize("replications", [1, 4])
def test_angles_that_follow_no_grid_are_an_index_each(replications: int) -> None:
    angle = np.deg2rad(np.linspace(-1.0, 1.0, 56) ** 3 * 85.0)
    number, _ = index_of(np.tile(angle[np.diff(angle, append=2.0) > 1e-3], replications))
    assert np.unique(number).size == number.size / replications


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
def test_an_axis_moves_where_its_index_changes_and_by_a_whole_turn(scatter_deg: float) -> None:
    raster = np.repeat(PITCH_DEG, 8)
    np.testing.assert_array_equal(has_moved(_read_back(raster, scatter_deg)), np.diff(raster) != 0.0)
    assert has_moved(np.deg2rad([-180.0, 180.0])).all()
    turns = np.tile(np.repeat([-180.0, 0.0, 180.0], 8), 2)
    np.testing.assert_array_equal(has_moved(_read_back(turns, scatter_deg)), np.diff(turns) != 0.0)


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize("begin_deg", [-180.0, 0.0])
def test_an_axis_that_stands_where_its_encoder_begins_has_not_moved(begin_deg: float, scatter_deg: float) -> None:
    raster = np.repeat(ROLL_DEG, 7)
    wrapped = (_read_back(raster, scatter_deg) - np.deg2rad(begin_deg)) % (2.0 * np.pi) + np.deg2rad(begin_deg)
    np.testing.assert_array_equal(has_moved(wrapped), np.diff(raster) != 0.0)


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize(("points", "replications"), [(6, 2), (56, 4), (156, 6)])
def test_an_axis_that_scatters_is_back_in_every_replication(points: int, replications: int, scatter_deg: float) -> None:
    at_deg = np.tile(np.linspace(-180.0, 179.0, points), (replications, 1))
    for night in range(8 * NIGHTS):
        angle = _read_back(at_deg, scatter_deg, night)
        assert are_back((angle + np.pi) % (2.0 * np.pi) - np.pi)
        angle[night % replications, 3] += np.deg2rad(0.2) * (-1) ** night  # one dwell was off
        assert are_back(angle)


@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
@pytest.mark.parametrize("points", [6, 56])
def test_an_axis_is_not_back_a_step_away_or_where_a_replication_stands_elsewhere(
    points: int, scatter_deg: float
) -> None:
    at_deg = np.tile(np.linspace(-75.0, 75.0, points), (3, 1))
    at_deg[1, 4] += 1.0
    assert not are_back(_read_back(at_deg, scatter_deg))
    at_deg[1] = at_deg[0] + max(0.2, 10.0 * scatter_deg)
    assert not are_back(_read_back(at_deg, scatter_deg))
    at_deg[1] = at_deg[0, ::-1]
    assert not are_back(_read_back(at_deg, scatter_deg))
