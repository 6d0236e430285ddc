import numpy as np
import pytest
from attitudes import attitude_from_degrees

from ams.errors import DesignError
from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.solve.linear_form import factor

MODEL = PitchRoll("x")


def grid(pitch_deg: object, roll_deg: object) -> Attitude:
    pitch, roll = np.meshgrid(np.atleast_1d(pitch_deg), np.atleast_1d(roll_deg), indexing="ij")
    return attitude_from_degrees(pitch.ravel(), roll.ravel())


def test_weighted_solution_is_that_of_the_normal_equations() -> None:
    rng = np.random.default_rng(5)
    attitude = grid(np.arange(-90, 91, 30), np.arange(-180, 180, 60))
    basis, weights = MODEL.basis(attitude), rng.uniform(0.2, 3.0, 42)
    output = rng.standard_normal(42)
    form = factor(basis, MODEL.primary_names, attitude, weights)
    moments = basis.T @ (weights[:, None] * basis)
    np.testing.assert_allclose(form.solve(output), np.linalg.solve(moments, basis.T @ (weights * output)), rtol=1e-11)
    np.testing.assert_allclose(form.unscaled_covariance, np.linalg.inv(moments), rtol=1e-11, atol=1e-14)


def test_a_narrow_range_keeps_ten_digits() -> None:
    """Pitch within ±2° and roll within ±5° tells offset from sensitivity badly; rounding must not add to it."""
    attitude = grid(np.linspace(-2, 2, 9), np.linspace(-5, 5, 7))
    truth = np.array([0.005, 2.4998, 0.0178, 0.0125])
    form = factor(MODEL.basis(attitude), MODEL.primary_names, attitude)
    assert form.condition_number == pytest.approx(np.linalg.cond(form.basis / np.linalg.norm(form.basis, axis=0)))
    assert form.condition_number > 500
    np.testing.assert_allclose(form.solve(form.basis @ truth), truth, atol=1e-10)


def test_one_roll_angle_is_refused_with_what_is_missing() -> None:
    attitude = grid(np.arange(-90, 91, 10), 0.0)
    with pytest.raises(
        DesignError, match=r"rank 3 of 4.*k_y_v_per_g.*roll has one value only \(0°\).*azimuth.*pitch-only"
    ):
        factor(MODEL.basis(attitude), MODEL.primary_names, attitude)


def test_one_pitch_angle_is_refused_with_what_is_missing() -> None:
    attitude = grid(30.0, np.arange(-180, 180, 30))
    with pytest.raises(
        DesignError, match=r"offset_v and k_x_v_per_g: pitch has one value only \(30°\).*add pitch angles"
    ):
        factor(MODEL.basis(attitude), MODEL.primary_names, attitude)


def test_fewer_points_than_parameters_are_refused_with_both_counts() -> None:
    attitude = attitude_from_degrees([0.0, 90.0, -90.0], [0.0, 0.0, 90.0])
    with pytest.raises(DesignError, match=r"3 observations cannot determine 4 parameters \(offset_v, k_x"):
        factor(MODEL.basis(attitude), MODEL.primary_names, attitude)
