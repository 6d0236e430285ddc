"""Gauss-Newton against outside answers: NIST StRD, scipy, the linear form, explicit generalised least squares."""

import numpy as np
import pytest
from pitch_roll_of_tp import primary_from_parameters, solve_pitch_roll
from scipy.optimize import curve_fit

from ams.errors import DesignError, SolveError
from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.solve.gauss_newton import gauss_newton

# NIST StRD Misra1a: y = b1 (1 − exp(−b2 x)); certified values and standard deviations from www.itl.nist.gov/div898/strd
MISRA_Y = np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78])
MISRA_X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])
MISRA_CERTIFIED = np.array([2.3894212918e02, 5.5015643181e-04])
MISRA_DEVIATION = np.array([2.7070075241e00, 7.2668688436e-06])


def misra(b):
    return b[0] * (1.0 - np.exp(-b[1] * MISRA_X))


def misra_jacobian(b):
    return np.stack([1.0 - np.exp(-b[1] * MISRA_X), b[0] * MISRA_X * np.exp(-b[1] * MISRA_X)], axis=1)


@pytest.mark.parametrize("start", [[500.0, 1e-4], [250.0, 5e-4]])
def test_certified_values_of_nist_misra1a(start: list[float]) -> None:
    result = gauss_newton(misra, misra_jacobian, np.array(start), MISRA_Y, ("b1", "b2"))
    np.testing.assert_allclose(result.estimate, MISRA_CERTIFIED, rtol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.diag(result.covariance)), MISRA_DEVIATION, rtol=1e-8)
    assert result.convergence.reason in ("step", "rounding")


def noisy_axis(axis: str, seed: int = 1, noise_v: float = 1e-3) -> tuple[Attitude, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    pitch, roll = (a.ravel() for a in np.meshgrid(np.linspace(-1.5, 1.5, 9), np.linspace(-3, 3, 8), indexing="ij"))
    attitude = Attitude(pitch, roll)
    truth = np.array([0.02, -2.5, 0.05, 2.0])
    model = PitchRoll(axis)
    clean = model.predict(primary_from_parameters(axis, truth), attitude)
    return attitude, clean + noise_v * rng.standard_normal(72), truth


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_the_linear_form_and_gauss_newton_agree(axis: str) -> None:
    attitude, output, _ = noisy_axis(axis)
    model = PitchRoll(axis)
    linear = model.parameters(model.start(attitude, output))
    iterated = solve_pitch_roll(axis, attitude, output, start=np.array([0.0, -2.0, 0.2, 1.0]))
    np.testing.assert_allclose([*iterated.estimate[:2], *np.rad2deg(iterated.estimate[2:])], linear, rtol=1e-9)


def test_scipy_agrees_with_estimate_and_covariance_under_a_full_output_covariance() -> None:
    attitude, output, truth = noisy_axis("x")
    rng = np.random.default_rng(2)
    root = rng.standard_normal((72, 72)) * 2e-4 + 1e-3 * np.eye(72)
    u_y = root @ root.T

    def printed(_, b, s, o, a):  # TP (2)
        pitch, roll = attitude.pitch_rad, attitude.roll_rad
        return b + s * (np.cos(o) * np.sin(pitch) - np.sin(o) * np.cos(pitch) * np.sin(roll + a))

    expected, covariance = curve_fit(
        printed, np.zeros(72), output, p0=truth, sigma=u_y, absolute_sigma=True, xtol=1e-15, ftol=1e-15
    )
    found = solve_pitch_roll("x", attitude, output, u_y, absolute_covariance=True)
    np.testing.assert_allclose(found.estimate, expected, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-4, atol=1e-12)


def test_noise_free_data_end_at_the_truth() -> None:
    attitude, output, truth = noisy_axis("z", noise_v=0.0)
    found = solve_pitch_roll("z", attitude, output, start=np.array([0.1, -1.0, 0.3, 1.5]))
    np.testing.assert_allclose(found.estimate, truth, atol=1e-13)


def test_too_few_iterations_are_said_to_be_so() -> None:
    result = gauss_newton(misra, misra_jacobian, np.array([500.0, 1e-4]), MISRA_Y, ("b1", "b2"), iterations=2)
    assert result.convergence.reason == "iterations"


def test_a_parameter_without_effect_is_named() -> None:
    with pytest.raises(DesignError, match="do not depend on idle"):
        gauss_newton(
            lambda p: p[0] * np.ones(5), lambda p: np.stack([np.ones(5), np.zeros(5)], 1), np.ones(2), np.arange(5.0),
            ("mean", "idle"),
        )  # fmt: skip


def test_two_parameters_that_cannot_be_told_apart_are_named() -> None:
    ones = np.ones((6, 2))
    with pytest.raises(DesignError, match="cannot tell left and right apart"):
        gauss_newton(lambda p: ones @ p, lambda p: ones, np.zeros(2), np.arange(6.0), ("left", "right"))


def test_an_output_covariance_that_is_none_is_refused() -> None:
    attitude, output, _ = noisy_axis("x")
    with pytest.raises(SolveError, match="not positive definite"):
        solve_pitch_roll("x", attitude, output, np.ones((72, 72)) - 2.0 * np.eye(72))
    with pytest.raises(SolveError, match="variance is not positive: got 0"):
        solve_pitch_roll("x", attitude, output, np.zeros(72))


def test_a_start_without_finite_outputs_is_refused() -> None:
    with pytest.raises(SolveError, match="no finite outputs at the start"):
        gauss_newton(misra, misra_jacobian, np.array([np.inf, 1.0]), MISRA_Y, ("b1", "b2"))


def test_as_many_parameters_as_observations_are_refused() -> None:
    with pytest.raises(DesignError, match="2 observations cannot determine 2 parameters"):
        gauss_newton(lambda p: p, lambda p: np.eye(2), np.zeros(2), np.ones(2), ("a", "b"))
