"""Rotations and outputs against the formulas of MATH 1, written here a second time and by hand."""

import numpy as np
import pytest
from physics_scenes.gimbal_scenes import coned_axis, gravity_in_packages
from physics_scenes.rotations import (
    gimbal_matrix,
    pitch_matrix,
    roll_matrix,
    sensitive_axis,
    specific_force,
    turn_matrix,
    turned,
    yaw_matrix,
)

CHANCE = np.random.default_rng(11)
ALPHA, ROLL, YAW = CHANCE.uniform(-np.pi, np.pi, (3, 40))


def test_the_specific_force_is_tps_unit_vector():
    expected = [np.sin(ALPHA), -np.cos(ALPHA) * np.sin(ROLL), -np.cos(ALPHA) * np.cos(ROLL)]
    force = specific_force(ALPHA, ROLL)
    np.testing.assert_allclose(force, np.stack(expected, axis=1), atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 1.0, atol=1e-15)


def test_nose_up_gives_plus_x_level_minus_z_and_right_wing_down_minus_y():
    quarter = np.pi / 2
    np.testing.assert_allclose(specific_force(quarter, 0.0), [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(specific_force(0.0, 0.0), [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(specific_force(0.0, quarter), [0, -1, 0], atol=1e-15)


@pytest.mark.parametrize(("matrix", "axis"), [(roll_matrix, 0), (pitch_matrix, 1), (yaw_matrix, 2)])
def test_a_rotation_vector_along_an_axis_is_that_axis_matrix(matrix, axis):
    vectors = ALPHA[:, None] * np.eye(3)[axis]
    np.testing.assert_allclose(turn_matrix(vectors), matrix(ALPHA), atol=1e-14)


def test_turns_keep_lengths_and_angles_and_the_turn_of_nothing_is_exact():
    turns = turn_matrix(CHANCE.standard_normal((20, 3)))
    np.testing.assert_allclose(turns @ np.swapaxes(turns, 1, 2), np.tile(np.eye(3), (20, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(turns), 1.0)
    assert np.array_equal(turn_matrix(np.zeros(3)), np.eye(3))


@pytest.mark.parametrize("axis", "xyz")
def test_sensitive_axes_are_unit_vectors_coned_by_their_angle(axis):
    coning, azimuth = np.deg2rad(CHANCE.uniform(0.05, 80.0, 40)), YAW
    for units in (sensitive_axis(axis, coning, azimuth), coned_axis(axis, coning, azimuth)):
        np.testing.assert_allclose(np.linalg.norm(units, axis=1), 1.0)
        np.testing.assert_allclose(units[:, "xyz".index(axis)], np.cos(coning))


def test_x_reads_tps_formula():
    coning, azimuth = 0.3, -0.7
    read = specific_force(ALPHA, ROLL) @ sensitive_axis("x", coning, azimuth)
    expected = np.cos(coning) * np.sin(ALPHA) - np.sin(coning) * np.cos(ALPHA) * np.sin(ROLL + azimuth)
    np.testing.assert_allclose(read, expected, atol=1e-15)


def test_the_sting_x_reads_crs_formula():
    coning, azimuth = 0.3, -0.7
    euler = np.rad2deg(np.stack([ALPHA, YAW, ROLL], axis=1))
    read = gravity_in_packages(euler)[:, 0] @ coned_axis("x", np.float64(coning), np.float64(azimuth))
    expected = (
        -np.cos(coning) * np.sin(ALPHA) * np.cos(YAW)
        + np.sin(azimuth) * np.sin(coning) * np.sin(ALPHA) * np.sin(YAW)
        - np.cos(azimuth) * np.sin(coning) * np.cos(ALPHA)
    )
    np.testing.assert_allclose(read, expected, atol=1e-14)


def test_without_yaw_the_gimbal_sees_tps_force_reversed():
    gravity = turned(gimbal_matrix(ALPHA, 0.0, ROLL), np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(gravity, -specific_force(ALPHA, ROLL), atol=1e-14)


def test_tps_azimuth_is_crs_with_the_sign_of_s_turned_for_every_axis():
    for axis in "xyz":
        tp = specific_force(ALPHA, ROLL) @ sensitive_axis(axis, 0.2, YAW[0])
        gravity = turned(gimbal_matrix(ALPHA, 0.0, ROLL), np.array([0.0, 0.0, -1.0]))
        cr = gravity @ coned_axis(axis, np.float64(0.2), YAW[0] + np.pi / 2)
        np.testing.assert_allclose(-cr, tp, atol=1e-14)
