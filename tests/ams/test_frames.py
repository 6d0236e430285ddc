"""Axes and specific force against explicit rotations, not against the formulas of the module."""

import re

import numpy as np
import pytest
from example_files import ROOT

from ams.frames import (
    beside_axis,
    body_rates_rad_s,
    from_level_axes,
    specific_force,
    specific_force_by_base,
    specific_force_by_pitch,
    specific_force_by_roll,
    specific_force_by_turn,
    specific_force_by_yaw,
    wrap_deg,
    wrap_rad,
)


def rotated_specific_force(pitch_rad: float, roll_rad: float) -> np.ndarray:
    """At rest the specific force is 1 g upward; package axes are the earth's, pitched about y, then rolled about x."""
    cp, sp, cr, sr = np.cos(pitch_rad), np.sin(pitch_rad), np.cos(roll_rad), np.sin(roll_rad)
    pitched = np.array([[cp, 0.0, -sp], [0.0, 1.0, 0.0], [sp, 0.0, cp]])
    rolled = np.array([[1.0, 0.0, 0.0], [0.0, cr, sr], [0.0, -sr, cr]])
    return rolled @ pitched @ np.array([0.0, 0.0, -1.0])


@pytest.mark.parametrize("pitch_deg", [-180.0, -90.0, -37.0, 0.0, 12.5, 90.0, 144.0])
@pytest.mark.parametrize("roll_deg", [-180.0, -61.0, 0.0, 30.0, 90.0, 175.0])
def test_specific_force_is_gravity_turned_by_pitch_then_roll(pitch_deg: float, roll_deg: float) -> None:
    pitch, roll = np.deg2rad(pitch_deg), np.deg2rad(roll_deg)
    force = specific_force(np.array([pitch]), np.array([roll]))[0]
    np.testing.assert_allclose(force, rotated_specific_force(pitch, roll), atol=1e-15)


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "force"),
    [(90.0, 0.0, [1.0, 0.0, 0.0]), (0.0, 0.0, [0.0, 0.0, -1.0]), (0.0, 90.0, [0.0, -1.0, 0.0])],
)
def test_nose_up_is_plus_x_level_minus_z_right_wing_down_minus_y(pitch_deg, roll_deg, force) -> None:
    found = specific_force(np.deg2rad([pitch_deg]), np.deg2rad([roll_deg]))
    np.testing.assert_allclose(found[0], force, atol=1e-15)


def test_derivatives_agree_with_a_complex_step() -> None:
    rng = np.random.default_rng(3)
    pitch, roll = rng.uniform(-np.pi, np.pi, (2, 50))
    step = 1e-30
    np.testing.assert_allclose(
        specific_force_by_pitch(pitch, roll), specific_force(pitch + 1j * step, roll).imag / step, atol=1e-14
    )
    np.testing.assert_allclose(
        specific_force_by_roll(pitch, roll), specific_force(pitch, roll + 1j * step).imag / step, atol=1e-14
    )


ANGLES = np.random.default_rng(4).uniform(-np.pi, np.pi, (3, 50))
SMALL = 1e-6


def force_of_matrix(matrices: np.ndarray) -> np.ndarray:
    """At rest the specific force is 1 g upward."""
    return matrices @ np.array([0.0, 0.0, -1.0])


def test_with_yaw_it_is_gravity_turned_by_pitch_then_yaw_then_roll() -> None:
    pitch, yaw, roll = ANGLES
    force = specific_force(pitch, roll, yaw)
    np.testing.assert_allclose(force, force_of_matrix(from_level_axes(pitch, yaw, roll)), atol=1e-15)
    np.testing.assert_allclose(specific_force(pitch, roll, 0.0 * yaw), specific_force(pitch, roll), atol=1e-15)


def test_with_yaw_every_slope_agrees_with_a_complex_step() -> None:
    pitch, yaw, roll = ANGLES
    step = 1e-30
    slopes = {
        "pitch": (specific_force_by_pitch(pitch, roll, yaw), specific_force(pitch + 1j * step, roll, yaw)),
        "yaw": (specific_force_by_yaw(pitch, roll, yaw), specific_force(pitch, roll, yaw + 1j * step)),
        "roll": (specific_force_by_turn(pitch, roll, yaw)[0], specific_force(pitch, roll + 1j * step, yaw)),
    }
    for axis, (slope, moved) in slopes.items():
        np.testing.assert_allclose(slope, moved.imag / step, atol=1e-14, err_msg=axis)


def turned_about(axis: int, angle_rad: float) -> np.ndarray:
    """Components in axes that were turned about one of them, right-handed."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    first, second = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = c
    matrix[first, second], matrix[second, first] = s, -s
    return matrix


@pytest.mark.parametrize("has_yaw", [True, False])
def test_turns_of_base_and_package_are_those_of_small_rotations(has_yaw: bool) -> None:
    """A base that turns a little about its forward axis, left-handed, and a package on its mount."""
    pitch, yaw, roll = ANGLES
    given = yaw if has_yaw else None
    stood = from_level_axes(pitch, yaw if has_yaw else 0.0 * yaw, roll)
    force = force_of_matrix(stood)
    dipped = (force_of_matrix(stood @ turned_about(0, -SMALL)) - force) / SMALL
    np.testing.assert_allclose(specific_force_by_base(pitch, roll, given), dipped, atol=1e-5)
    for axis, slope in enumerate(specific_force_by_turn(pitch, roll, given)):
        turned = (force_of_matrix(turned_about(axis, SMALL) @ stood) - force) / SMALL
        np.testing.assert_allclose(slope, turned, atol=1e-5)


@pytest.mark.parametrize(("axis", "across"), [(0, (0, 2)), (1, (0, 1)), (2, (1, 2))])
def test_an_axis_leans_at_right_angles_and_the_same_way_in_what_carries_it(axis: int, across: tuple[int, ...]) -> None:
    """Turned back by the angles of what it carries, to where roll and yaw are zero, the directions are fixed."""
    chance = np.random.default_rng(5)
    euler = chance.uniform(-3.0, 3.0, (20, 3))
    about = body_rates_rad_s(euler, np.tile(np.eye(3)[axis], (20, 1)))
    beside = beside_axis(euler, axis)
    square = np.concatenate([about[:, None], beside], axis=1)
    assert square @ np.swapaxes(square, 1, 2) == pytest.approx(np.tile(np.eye(3), (20, 1, 1)), abs=1e-12)
    for (_, yaw, roll), leaning in zip(euler, beside, strict=True):
        inside = [turned_about(0, roll) @ turned_about(2, yaw), turned_about(0, roll), np.eye(3)][axis]
        assert leaning @ inside == pytest.approx(np.eye(3)[list(across)], abs=1e-12)


def test_wrapped_angles_include_plus_half_a_turn_and_exclude_minus() -> None:
    np.testing.assert_array_equal(wrap_deg(np.array([-180.0, 180.0, 190.0, -190.0, 720.0])), [180, 180, -170, 170, 0])
    assert [wrap_deg(angle) for angle in (-180.0, 180.0, 190.0, -190.0, 720.0)] == [180.0, 180.0, -170.0, 170.0, 0.0]
    assert wrap_rad(np.array([-np.pi]))[0] == np.pi


def test_an_angle_is_wrapped_in_one_place() -> None:
    copies = re.compile(r"% ?\(?360(\.0)?\)? - 180|360\.0\) - 180|180(\.0)? - (np\.mod)?\(180|np\.pi - np\.mod\(")
    sources = [path for package in ("ams", "rig", "procedures") for path in (ROOT / package).rglob("*.py")]
    found = [path.name for path in sources if copies.search(path.read_text(encoding="utf-8"))]
    assert found == ["frames.py"], "ams.frames.wrap_deg and wrap_rad do it, both ends alike"
