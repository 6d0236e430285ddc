"""H_E of TP appendix B: against the second derivative of the sum of squares, and where it vanishes."""

from typing import ClassVar

import numpy as np
import pytest
from pitch_roll_of_tp import primary_from_parameters, primary_from_parameters_jacobian

from ams.errors import SolveError
from ams.frames import Attitude
from ams.models.accelerometer import PitchRoll
from ams.solve.gauss_newton import gauss_newton
from ams.solve.residual_curvature import residual_curvature

TIME = np.linspace(0.0, 2.0, 15)


def decay(c: np.ndarray) -> np.ndarray:
    return c[0] * np.exp(-c[1] * TIME)


def decay_jacobian(c: np.ndarray) -> np.ndarray:
    return np.stack([np.exp(-c[1] * TIME), -c[0] * TIME * np.exp(-c[1] * TIME)], axis=1)


OBSERVED = decay(np.array([1.0, 0.8])) + 0.3 * np.sin(7.0 * TIME)


def test_h_e_is_the_residuals_against_the_second_derivatives() -> None:
    """f_aa = 0, f_ab = −t e^(−bt), f_bb = a t² e^(−bt), differentiated by hand."""
    found = gauss_newton(decay, decay_jacobian, np.ones(2), OBSERVED, ("a", "b"), residual_curvature=True)
    a, b = found.estimate
    off = found.residuals @ (-TIME * np.exp(-b * TIME))
    last = found.residuals @ (a * TIME**2 * np.exp(-b * TIME))
    np.testing.assert_allclose(found.residual_curvature, [[0.0, off], [off, last]], rtol=1e-7, atol=1e-9)


def test_the_covariance_with_h_e_is_the_inverse_of_the_second_derivative_of_the_sum_of_squares() -> None:
    found = gauss_newton(decay, decay_jacobian, np.ones(2), OBSERVED, ("a", "b"), residual_curvature=True)

    def half_square(c: np.ndarray) -> float:
        return 0.5 * float(np.sum((OBSERVED - decay(c)) ** 2))

    h, second = 1e-4, np.zeros((2, 2))
    for i in range(2):
        for j in range(2):
            signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
            terms = [s * t * half_square(found.estimate + h * (s * np.eye(2)[i] + t * np.eye(2)[j])) for s, t in signs]
            second[i, j] = sum(terms) / (4.0 * h * h)
    expected = found.standard_error**2 * np.linalg.inv(second)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-5)
    plain = gauss_newton(decay, decay_jacobian, np.ones(2), OBSERVED, ("a", "b"))
    assert plain.residual_curvature is None
    assert not np.allclose(plain.covariance, expected, rtol=1e-2)


class Decay:
    """As much of a model as H_E asks for."""

    primary_names = ("a", "b")
    fixed: ClassVar[dict[str, tuple[float, float]]] = {}
    basis_key = None

    def jacobian(self, primary: np.ndarray, _rows: Attitude) -> np.ndarray:
        return decay_jacobian(primary)


def test_the_ratio_that_is_stated_beside_h_e_is_that_of_the_two_covariances() -> None:
    """TP (44) with its sign: R = F_cᵀF_c − H_E, which bends where the residuals do."""
    plain = gauss_newton(decay, decay_jacobian, np.ones(2), OBSERVED, ("a", "b"))
    whole = gauss_newton(decay, decay_jacobian, np.ones(2), OBSERVED, ("a", "b"), residual_curvature=True)
    rows = Attitude(TIME, TIME)
    found = residual_curvature(Decay(), plain.estimate, rows, plain.residuals)  # type: ignore[arg-type]
    np.testing.assert_allclose(found.h_e, whole.residual_curvature, rtol=1e-5, atol=1e-8)
    expected = np.sqrt(np.diag(whole.covariance) / np.diag(plain.covariance))
    np.testing.assert_allclose(list(found.standard_uncertainty_ratio.values()), expected, rtol=1e-5)
    assert np.abs(expected - 1.0).max() > 0.01


def second_derivatives(alpha, roll, s, coning, azimuth) -> np.ndarray:
    """(K, 4, 4) as TP (117) to (122) print them for the pitch sensor."""
    f = np.zeros((alpha.size, 4, 4))
    sin_turn, cos_turn = np.cos(alpha) * np.sin(roll + azimuth), np.cos(alpha) * np.cos(roll + azimuth)
    f[:, 1, 2] = -np.sin(coning) * np.sin(alpha) - np.cos(coning) * sin_turn
    f[:, 1, 3] = -np.sin(coning) * cos_turn
    f[:, 2, 2] = -s * (np.cos(coning) * np.sin(alpha) - np.sin(coning) * sin_turn)
    f[:, 2, 3] = -s * np.cos(coning) * cos_turn
    f[:, 3, 3] = s * np.sin(coning) * sin_turn
    return f + np.transpose(np.triu(f, 1), (0, 2, 1))


@pytest.mark.parametrize("noise", [1e-3, 0.5])
def test_for_tps_own_model_h_e_vanishes_at_the_answer_however_large_the_residuals(noise) -> None:
    """TP found by simulation that H_E 'may be neglected': the model is linear in (b, S·u), so it is zero. Away from the
    answer it is what TP (117) to (124) print."""
    rng = np.random.default_rng(0)
    grid = np.meshgrid(np.deg2rad(np.arange(-90.0, 91.0, 30.0)), np.deg2rad(np.arange(0.0, 360.0, 45.0)))
    pitch, roll = (angle.ravel() for angle in grid)
    basis = PitchRoll("x").basis(Attitude(pitch, roll))
    truth = np.array([0.1, 2.5, 0.4, 0.6])
    observed = basis @ primary_from_parameters("x", truth) + noise * rng.standard_normal(pitch.size)
    found = gauss_newton(
        lambda c: basis @ primary_from_parameters("x", c),
        lambda c: basis @ primary_from_parameters_jacobian("x", c),
        truth, observed, ("b", "S", "coning", "azimuth"), residual_curvature=True,
    )  # fmt: skip
    assert found.residual_curvature is not None
    jacobian = basis @ primary_from_parameters_jacobian("x", found.estimate)
    assert np.abs(found.residual_curvature).max() < 1e-7 * np.abs(jacobian.T @ jacobian).max()
    printed = np.einsum("k,kij->ij", found.residuals, second_derivatives(pitch, roll, *found.estimate[1:]))
    assert np.abs(printed).max() < 1e-7 * np.abs(jacobian.T @ jacobian).max()


def test_printed_second_derivatives_are_those_of_the_model() -> None:
    pitch, roll, c = np.array([0.3, -1.0]), np.array([0.5, 2.0]), np.array([0.1, 2.5, 0.4, 0.6])
    basis = PitchRoll("x").basis(Attitude(pitch, roll))
    printed = second_derivatives(pitch, roll, *c[1:])
    for index in range(1, 4):
        slopes = []
        for sign in (1.0, -1.0):
            moved = c.copy()
            moved[index] += sign * 1e-6
            slopes.append(basis @ primary_from_parameters_jacobian("x", moved))
        np.testing.assert_allclose((slopes[0] - slopes[1]) / 2e-6, printed[:, :, index], atol=1e-9)


def test_an_answer_that_is_no_minimum_is_refused() -> None:
    """At c = 0 the slopes ±1e-3 are orthogonal to the residuals −2, −2, and those bend the sum of squares downwards."""

    def predict(c: np.ndarray) -> np.ndarray:
        return np.cos(c[0]) + np.array([1e-3, -1e-3]) * c[0]

    def jacobian(c: np.ndarray) -> np.ndarray:
        return (np.array([1e-3, -1e-3]) - np.sin(c[0]))[:, None]

    with pytest.raises(SolveError, match=r"no minimum: got a smallest eigenvalue of -\d"):
        gauss_newton(predict, jacobian, np.zeros(1), np.array([-1.0, -1.0]), ("c",), residual_curvature=True)
