"""One and two axes: the root that was asked for, flagged where the other answers too; spread by finite differences."""

import numpy as np
import pytest

from ams.attitude import flag_codes
from ams.attitude.few_axes import OneAxis, TwoAxes
from ams.attitude.flag_codes import NO_ROOT, NOT_FINITE, SECOND_ROOT
from ams.attitude.force_covariance import ParameterErrors
from ams.errors import DesignError
from ams.frames import specific_force

DEG = np.pi / 180
K = np.array([[2.5, 0.05, -0.02], [0.1, -2.4, 0.03], [0.01, -0.2, 2.6]])
OFFSET_V = np.array([0.01, -0.02, 0.03])
READING_V = np.array([2e-5, 1e-4, 3e-5])
rng = np.random.default_rng(1)
_ROOT = rng.normal(0, 1e-5, (12, 12))
COVARIANCE = _ROOT @ _ROOT.T


def errors(axes):
    indices = np.concatenate([np.arange(4 * axis, 4 * axis + 4) for axis in axes])
    return ParameterErrors(COVARIANCE[np.ix_(indices, indices)][None], np.array([np.inf]), READING_V[axes] ** 2)


def outputs(axes, pitch, roll):
    return OFFSET_V[axes, None] + K[axes] @ specific_force(np.atleast_1d(pitch), np.atleast_1d(roll)).T


def two(axes, **kwargs):
    return TwoAxes(K[axes], OFFSET_V[axes], errors(axes), **kwargs)


def one(k=K[0]):
    return OneAxis(k, 0.01, errors([0]))


@pytest.mark.parametrize("axes", [[0, 1], [0, 2]])
def test_two_axes_find_the_attitude_with_the_spread_of_finite_differences(axes) -> None:
    pitch = rng.uniform(-70, 70, 200) * DEG
    roll = rng.uniform(-70, 70, 200) * DEG + (90 * DEG if axes == [0, 2] else 0)
    read, h = outputs(axes, pitch, roll), 1e-6
    found = two(axes).attitude(read)
    assert not found.codes.any()
    np.testing.assert_allclose(found.pitch_rad, pitch, atol=1e-11)
    np.testing.assert_allclose(found.roll_rad, roll, atol=1e-11)
    slopes = []
    for axis in range(2):
        step = h * (np.arange(2) == axis)[:, None]
        up, down = two(axes).attitude(read + step), two(axes).attitude(read - step)
        slopes.append([(up.pitch_rad - down.pitch_rad) / (2 * h), (up.roll_rad - down.roll_rad) / (2 * h)])
    J = np.moveaxis(np.array(slopes), (0, 1, 2), (2, 1, 0))
    basis = np.concatenate([np.ones((200, 1)), specific_force(pitch, roll)], axis=1)
    own = errors(axes)
    rows = np.einsum("ij,np->nijp", np.eye(2), basis).reshape(200, 2, 8)
    covariance = rows @ own.covariances_v2[0] @ np.swapaxes(rows, 1, 2) + np.diag(own.reading_v2)
    sd = np.sqrt(np.einsum("nai,nij,naj->na", J, covariance, J))
    np.testing.assert_allclose(np.stack([found.pitch_sd_rad, found.roll_sd_rad], axis=1), sd, rtol=1e-5)


def test_a_row_is_flagged_where_the_mirrored_attitude_is_upright_too() -> None:
    """The other attitude is the first one mirrored in the plane of the two sensitive axes."""
    axes, pitch, roll = [0, 1], rng.uniform(80, 90, 2000) * DEG, rng.uniform(-89, 89, 2000) * DEG
    normal = np.cross(K[0], K[1]) / np.linalg.norm(np.cross(K[0], K[1]))
    force = specific_force(pitch, roll)
    mirrored = force - 2 * np.outer(force @ normal, normal)
    found = two(axes).attitude(outputs(axes, pitch, roll))
    is_both = (mirrored[:, 2] < -1e-3) & (force[:, 2] < -1e-3)
    is_alone = (mirrored[:, 2] > 0.02) & (force[:, 2] < -1e-3)
    assert is_both.sum() > 20
    assert (found.codes[is_both] != 0).all()
    assert not found.codes[is_alone].any()


def test_no_wrong_angle_goes_without_a_flag() -> None:
    pitch, roll = rng.uniform(-90, 90, 40_000) * DEG, rng.uniform(-90, 90, 40_000) * DEG
    found = two([0, 1]).attitude(outputs([0, 1], pitch, roll))
    force, truth = specific_force(found.pitch_rad, found.roll_rad), specific_force(pitch, roll)
    wrong = ~(np.linalg.norm(force - truth, axis=1) < 1e-6)
    assert wrong.sum() > 50
    assert (found.codes[wrong] != 0).all()
    assert np.mean(found.codes != 0) < 0.05


def test_an_attitude_on_the_other_side_is_answered_by_its_mirror_or_said_to_be_none() -> None:
    read = outputs([0, 1], 10 * DEG, 170 * DEG)
    upright, inverted = two([0, 1]).attitude(read), two([0, 1], is_upright=False).attitude(read)
    assert abs(upright.roll_rad[0]) < np.pi / 2
    assert inverted.roll_rad[0] == pytest.approx(170 * DEG)
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, 0.9, 0.5]])
    level = TwoAxes(tilted, np.zeros(2), errors([0, 1]))
    found = level.attitude(tilted @ specific_force(np.array([0.0]), np.array([-100 * DEG])).T)
    assert found.codes[0] == NO_ROOT
    assert np.isnan(found.pitch_rad[0])


def test_y_and_z_alone_never_tell_the_sign_of_pitch() -> None:
    found = two([1, 2]).attitude(outputs([1, 2], 20 * DEG, 10 * DEG))
    assert found.codes[0] & (SECOND_ROOT | NO_ROOT)


@pytest.mark.parametrize("coning_deg", [1.0, -1.0, 5.0])
def test_one_axis_is_flagged_where_its_output_fits_two_pitches_or_none(coning_deg: float) -> None:
    """Brute force: the pitches of ±90° at which the output comes to what was read."""
    k = 2.5 * np.array([np.cos(coning_deg * DEG), 0.0, np.sin(coning_deg * DEG)])
    grid = np.linspace(-90, 90, 180_001) * DEG
    curve = specific_force(grid, np.zeros(grid.size)) @ k
    for pitch_deg in (*np.arange(-89.9, 90, 7.3), 80.0, 88.3, -88.3, 89.5, -89.5, 84.0, -84.0):
        read = specific_force(np.array([pitch_deg * DEG]), np.zeros(1)) @ k + 0.01
        found = one(k).attitude(read, np.zeros(1))
        crossings = np.count_nonzero(np.diff(curve + 0.01 > read))
        if crossings == 2:
            assert found.codes[0] != 0
        elif abs(pitch_deg) < 90 - abs(coning_deg) - 1:
            assert found.codes[0] == 0 or abs(pitch_deg) > 90 - 2 * abs(coning_deg) - 0.1
        if found.codes[0] == 0:
            assert found.pitch_rad[0] == pytest.approx(pitch_deg * DEG, abs=1e-9)


def test_the_flag_leaves_the_branch_that_is_stated() -> None:
    """The sensor's own axis within 90° of the horizontal: 88° for an axis tilted by −1° that reads 89° of its own."""
    k = 2.5 * np.array([np.cos(DEG), 0.0, -np.sin(DEG)])
    exact = OneAxis(k, 0.0, ParameterErrors(np.zeros((1, 4, 4)), np.array([np.inf]), np.zeros(1)))
    found = exact.attitude(np.array([2.5 * np.sin(89.5 * DEG)]), np.zeros(1))
    assert found.codes[0] == SECOND_ROOT
    assert np.sin(found.pitch_rad[0] + DEG) == pytest.approx(np.sin(89.5 * DEG)) or np.isfinite(found.pitch_rad[0])
    assert flag_codes.words(found.codes)[0].startswith("second attitude")


def test_readings_that_are_missing_are_marked() -> None:
    assert one().attitude(np.array([np.nan, 0.1]), np.zeros(2)).codes.tolist() == [NOT_FINITE, 0]
    assert one().attitude(np.array([0.1]), np.array([np.nan])).codes.tolist() == [NOT_FINITE]
    read = outputs([0, 1], [0.1, 0.2], [0.1, 0.2])
    read[1, 0] = np.nan
    assert two([0, 1]).attitude(read).codes.tolist() == [NOT_FINITE, 0]


def test_parallel_axes_are_refused() -> None:
    with pytest.raises(DesignError, match="parallel"):
        TwoAxes(K[[0, 0]], np.zeros(2), errors([0, 1])).attitude(np.zeros((2, 1)))
