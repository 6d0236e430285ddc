"""Weighted Gauss-Newton, TP (43) to (50) and CR (IV-A.1) to (IV-A.6), with a full output covariance U_Y.

A step solves F_cᵀ U_Y⁻¹ F_c δ = F_cᵀ U_Y⁻¹ (v − f). Where the full step makes the sum of squares worse, Marquardt's
damping is raised until it does not, and lowered again afterwards; an answer is only ever declared on an undamped step
below 1e-6 of every parameter's standard uncertainty (or at the rounding floor of the parameter itself).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ams.errors import DesignError, SolveError

FloatArray = NDArray[np.float64]

STEP_IN_STANDARD_UNCERTAINTIES = 1e-6
ROUNDING_FLOOR = 4.0 * float(np.finfo(float).eps)
LARGEST_DAMPING = 1e16

StopReason = Literal["step", "rounding", "iterations"]


@dataclass(frozen=True)
class Convergence:
    """How the iteration ended."""

    reason: StopReason
    """``step``: below 1e-6 standard uncertainties; ``rounding``: no better to be had in double precision;
    ``iterations``: the limit was reached before either."""
    iterations: int
    damped_steps: int
    last_step_in_standard_uncertainties: float


@dataclass(frozen=True)
class GaussNewtonResult:
    """Estimate with its covariance."""

    estimate: FloatArray
    """(L,)"""
    covariance: FloatArray
    """(L, L) TP (50): S_E² R⁻¹, or R⁻¹ where U_Y was absolute."""
    standard_error: float
    """S_E of TP (48): of a row of unit variance in U_Y; dimension of the outputs where U_Y is relative."""
    residuals: FloatArray
    """(N,) observed minus predicted."""
    convergence: Convergence


@dataclass(frozen=True)
class Whitening:
    """Turns rows with covariance U_Y into rows of unit variance."""

    factor: FloatArray | None
    """None: equal weights; (N,): standard deviations; (N, N): lower Cholesky factor of U_Y."""

    def __call__(self, rows: FloatArray) -> FloatArray:
        if self.factor is None:
            return rows
        if self.factor.ndim == 1:
            return np.asarray((rows.T / self.factor).T)
        from scipy.linalg import solve_triangular

        return np.asarray(solve_triangular(self.factor, rows, lower=True))


def whitening(covariance: FloatArray | None) -> Whitening:
    """Factor U_Y, given as None (identity), (N,) variances or a full (N, N) covariance.

    Raises:
        SolveError: U_Y is not positive definite.
    """
    if covariance is None:
        return Whitening(None)
    if covariance.ndim == 1:
        if not np.all(covariance > 0.0):
            raise SolveError(
                "U_Y: a variance is not positive: got "
                f"{float(covariance.min()):g}, allowed above 0; nothing was solved; correct the weights"
            )
        return Whitening(np.sqrt(covariance))
    try:
        return Whitening(np.asarray(np.linalg.cholesky(covariance), dtype=np.float64))
    except np.linalg.LinAlgError as failure:
        raise SolveError(
            "U_Y: the output covariance is not positive definite; nothing was solved; "
            "give every row some variance of its own"
        ) from failure


def gauss_newton(
    predict: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    observed: FloatArray,
    names: Sequence[str],
    covariance: FloatArray | None = None,
    absolute_covariance: bool = False,
    iterations: int = 50,
) -> GaussNewtonResult:
    """Least squares from a start.

    ``covariance`` is U_Y: None, (N,) variances, or (N, N); relative (rescaled by S_E²) unless absolute.

    Raises:
        DesignError: fewer rows than parameters, or a Jacobian of deficient rank at the answer.
        SolveError: the model returned no finite numbers at the start, or U_Y is not positive definite.
    """
    if observed.size <= len(start):
        raise DesignError(
            f"design: {observed.size} observations cannot determine {len(start)} parameters ({', '.join(names)}) "
            f"and an error: allowed {len(start) + 1} or more; nothing was solved; add points"
        )
    problem = _Problem(predict, jacobian, observed, whitening(covariance), tuple(names))
    estimate, convergence = _iterate(problem, np.asarray(start, dtype=float), iterations)
    residuals = observed - predict(estimate)
    dof = observed.size - estimate.size
    standard_error = float(np.sqrt(np.sum(problem.whiten(residuals) ** 2) / dof))
    unscaled = problem.unscaled_covariance(estimate)
    scale = 1.0 if absolute_covariance else standard_error**2
    return GaussNewtonResult(estimate, scale * unscaled, standard_error, residuals, convergence)


@dataclass(frozen=True)
class _Problem:
    predict: Callable[[FloatArray], FloatArray]
    jacobian: Callable[[FloatArray], FloatArray]
    observed: FloatArray
    whiten: Whitening
    names: tuple[str, ...]

    def residuals(self, parameters: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            return self.whiten(self.observed - self.predict(parameters))

    def gradient(self, parameters: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            return self.whiten(self.jacobian(parameters))

    def unscaled_covariance(self, parameters: FloatArray) -> FloatArray:
        gradient = self.gradient(parameters)
        length = np.linalg.norm(gradient, axis=0)
        flat = [name for name, size in zip(self.names, length, strict=True) if not size > 0.0]
        if flat:
            raise DesignError(
                f"design: the observations do not depend on {' and '.join(flat)} at the answer; "
                "nothing is reported; add points that do, or leave it out"
            )
        r = np.linalg.qr(gradient / length, mode="r")
        _, singular, directions = np.linalg.svd(r)
        if singular[-1] <= 1e-13 * singular[0]:
            worst = [self.names[i] for i in np.flatnonzero(np.abs(directions[-1]) > 0.05)]
            raise DesignError(
                f"design: the observations cannot tell {' and '.join(worst)} apart; nothing is reported; "
                "add points or fix one of them"
            )
        inverse = np.linalg.inv(r) / length[:, None]
        return np.asarray(inverse @ inverse.T)


def _iterate(problem: _Problem, start: FloatArray, limit: int) -> tuple[FloatArray, Convergence]:
    estimate, damping, damped_steps, relative = start, 0.0, 0, np.inf
    residuals = problem.residuals(estimate)
    if not np.all(np.isfinite(residuals)):
        raise SolveError(
            f"Gauss-Newton: the model gives no finite outputs at the start {start.tolist()}; "
            "nothing was solved; start elsewhere"
        )
    for iteration in range(1, limit + 1):
        gradient = problem.gradient(estimate)
        step, damping, tried = _descend(problem, estimate, residuals, gradient, damping)
        damped_steps += tried
        if step is None:
            return estimate, Convergence("rounding", iteration, damped_steps, 0.0)
        estimate = estimate + step
        residuals = problem.residuals(estimate)
        relative = _step_in_uncertainties(gradient, residuals, step)
        if damping == 0.0 and relative < STEP_IN_STANDARD_UNCERTAINTIES:
            return estimate, Convergence("step", iteration, damped_steps, relative)
        if damping == 0.0 and np.all(np.abs(step) <= ROUNDING_FLOOR * np.abs(estimate)):
            return estimate, Convergence("rounding", iteration, damped_steps, relative)
    return estimate, Convergence("iterations", limit, damped_steps, relative)


def _descend(
    problem: _Problem, estimate: FloatArray, residuals: FloatArray, gradient: FloatArray, damping: float
) -> tuple[FloatArray | None, float, int]:
    """A step that does not raise the sum of squares, the damping to go on with, and how many damped steps were
    tried."""
    cost, tried = float(residuals @ residuals), 0
    noise = 1e-13 * cost
    while damping <= LARGEST_DAMPING:
        step = _damped_step(gradient, residuals, damping)
        reached = problem.residuals(estimate + step)
        if np.all(np.isfinite(reached)) and float(reached @ reached) <= cost + noise:
            return step, (damping / 10.0 if damping > 1e-8 else 0.0), tried
        damping, tried = (10.0 * damping if damping > 0.0 else 1e-6), tried + 1
    return None, damping, tried


def _damped_step(gradient: FloatArray, residuals: FloatArray, damping: float) -> FloatArray:
    length = np.linalg.norm(gradient, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    scaled, right = gradient / length, residuals
    if damping > 0.0:
        size = scaled.shape[1]
        scaled = np.vstack([scaled, np.sqrt(damping) * np.eye(size)])
        right = np.concatenate([residuals, np.zeros(size)])
    return np.asarray(np.linalg.lstsq(scaled, right, rcond=1e-14)[0]) / length


def _step_in_uncertainties(gradient: FloatArray, residuals: FloatArray, step: FloatArray) -> float:
    """The largest step over its parameter's standard uncertainty; infinite where that is not defined."""
    dof = residuals.size - step.size
    unscaled = np.linalg.pinv(gradient.T @ gradient)
    uncertainty = np.sqrt(np.diag(unscaled).clip(min=0.0) * float(residuals @ residuals) / dof)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(step == 0.0, 0.0, np.abs(step) / uncertainty)
    return float(np.max(ratio)) if np.all(np.isfinite(ratio)) else float("inf")
