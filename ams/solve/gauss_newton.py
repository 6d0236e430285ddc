"""Weighted Gauss-Newton, TP (43) to (50) and CR (IV-A.1) to (IV-A.6), with a full output covariance U_Y.

A step solves F_cᵀ U_Y⁻¹ F_c δ = F_cᵀ U_Y⁻¹ (v − f). Where the full step does not lower the sum of squares by a fair
part of what the linear model promises, Marquardt's damping is raised until it does, and lowered again afterwards; an
answer is only ever declared on an undamped step that is small against every parameter's standard uncertainty, or at
rounding.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError, SolveError

CONVERGED = 1e-6
"""Standard uncertainties that a last step may have."""
STEP_IN_STANDARD_UNCERTAINTIES = 1e-9
"""The iteration goes on to here, so that problems that converge slowly have their digits too."""
ROUNDING_FLOOR = 4.0 * float(np.finfo(float).eps)
"""A step that moves the outputs by less than this part of them is rounding."""
TOO_LITTLE_TO_MEASURE = 1e-12
"""Of the sum of squares: below this a gain drowns in rounding and the full step is taken on trust."""
SMALLEST_GAIN = 1e-2
FIRST_DAMPING = 1e-3
LARGEST_DAMPING = 1e16
DIFFERENCE_STEP = 1e-5
"""Of a parameter, for second derivatives by central differences."""
EFFECT_LOST = 1e-12
"""A parameter whose slope has fallen to this part of its largest has no effect any more: the iteration ran away."""

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
    residual_curvature: FloatArray | None = None
    """(L, L) H_E, where it was asked for."""


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
    residual_curvature: bool = False,
) -> GaussNewtonResult:
    """Find the least squares from a start.

    ``covariance`` is U_Y: None, (N,) variances, or (N, N); relative (rescaled by S_E²) unless absolute.
    ``residual_curvature`` puts H_E of TP (45) into the covariance of the estimate: R = F_cᵀ U_Y⁻¹ F_c − H_E. It counts
    where residuals are large *and* the model curves within its uncertainty; for a model that is linear in its primary
    parameters H_E vanishes at the answer, because the residuals are orthogonal to every second derivative.

    Raises:
        DesignError: fewer rows than parameters, or a Jacobian of deficient rank at the answer.
        SolveError: the model returned no finite numbers at the start, the iteration stalled away from a minimum,
            U_Y is not positive definite, or with H_E the answer is no minimum.
    """
    if observed.size <= len(start):
        raise DesignError(
            f"design: {observed.size} observations cannot determine {len(start)} parameters ({', '.join(names)}) "
            f"and an error: allowed {len(start) + 1} or more; nothing was solved; add points"
        )
    problem = _Problem(predict, jacobian, observed, whitening(covariance), tuple(names))
    estimate, largest, convergence = _iterate(problem, np.asarray(start, dtype=float), iterations)
    residuals = observed - predict(estimate)
    dof = observed.size - estimate.size
    standard_error = float(np.sqrt(np.sum(problem.whiten(residuals) ** 2) / dof))
    unscaled = problem.unscaled_covariance(estimate, largest)
    scale = 1.0 if absolute_covariance else standard_error**2
    curvature = None
    if residual_curvature:
        curvature = _residual_curvature(problem, estimate, np.sqrt(np.diag(unscaled)) * standard_error)
        unscaled = _with_curvature(unscaled, curvature, names)
    return GaussNewtonResult(estimate, scale * unscaled, standard_error, residuals, convergence, curvature)


def _residual_curvature(problem: "_Problem", estimate: FloatArray, uncertainty: FloatArray) -> FloatArray:
    """Return H_E of TP (45): the residuals against the second derivatives.

    These are central differences of the Jacobian.
    """
    residuals = problem.residuals(estimate)
    columns = []
    for index, size in enumerate(np.maximum(np.abs(estimate), uncertainty)):
        step = np.zeros(estimate.size)
        step[index] = DIFFERENCE_STEP * (size or 1.0)
        ahead, behind = (problem.gradient(estimate + sign * step).T @ residuals for sign in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * step[index]))
    curvature = np.stack(columns, axis=1)
    return np.asarray(0.5 * (curvature + curvature.T))


def _with_curvature(unscaled: FloatArray, curvature: FloatArray, names: Sequence[str]) -> FloatArray:
    """Return R⁻¹ with R = F_cᵀ U_Y⁻¹ F_c − H_E, the second derivative of half the sum of squares.

    Print has R = F_cᵀ U_Y⁻¹ F_c + H_E in TP (44), with the H_E of (45): the sign of the residuals is lost there.
    """
    root = np.linalg.cholesky(unscaled)
    whole = np.eye(len(names)) - root.T @ curvature @ root
    smallest = float(np.linalg.eigvalsh(whole)[0])
    if smallest <= 0.0:
        raise SolveError(
            f"Gauss-Newton: {', '.join(names)}: with the curvature of the residuals (H_E) the answer is no minimum: "
            f"got a smallest eigenvalue of {smallest:.2g}, allowed above 0; nothing is reported; look for wrong rows"
        )
    return np.asarray(root @ np.linalg.solve(whole, root.T))


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

    def unscaled_covariance(self, parameters: FloatArray, largest: FloatArray) -> FloatArray:
        """Return R⁻¹ of TP (50).

        ``largest`` holds the largest slope that each parameter has had on the way.
        """
        gradient = self.gradient(parameters)
        length = np.linalg.norm(gradient, axis=0)
        flat = [
            name for name, size, most in zip(self.names, length, largest, strict=True) if not size > EFFECT_LOST * most
        ]
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


def _iterate(problem: _Problem, start: FloatArray, limit: int) -> tuple[FloatArray, FloatArray, Convergence]:
    """Return the answer, the largest slope that each parameter has had on the way, and how it ended."""
    estimate, damping, damped_steps, relative = start, 0.0, 0, np.inf
    length = np.zeros(start.size)
    residuals = problem.residuals(estimate)
    if not np.all(np.isfinite(residuals)):
        raise SolveError(
            f"Gauss-Newton: the model gives no finite outputs at the start {start.tolist()}; "
            "nothing was solved; start elsewhere"
        )
    floor = ROUNDING_FLOOR * float(np.linalg.norm(problem.whiten(problem.observed)))
    for iteration in range(1, limit + 1):
        gradient = problem.gradient(estimate)
        length = np.maximum(length, np.linalg.norm(gradient, axis=0))
        step, undamped, damping, tried = _descend(problem, estimate, residuals, gradient, length, damping)
        damped_steps += tried
        if step is None:
            relative = _refuse_stall(problem, estimate, residuals, gradient, length)
            return estimate, length, Convergence("rounding", iteration, damped_steps, relative)
        estimate = estimate + step
        residuals = problem.residuals(estimate)
        relative = _step_in_uncertainties(gradient, residuals, step)
        if undamped and relative < STEP_IN_STANDARD_UNCERTAINTIES:
            return estimate, length, Convergence("step", iteration, damped_steps, relative)
        if undamped and float(np.linalg.norm(gradient @ step)) <= floor:
            return estimate, length, Convergence("rounding", iteration, damped_steps, relative)
    return estimate, length, Convergence("iterations", limit, damped_steps, relative)


def _refuse_stall(
    problem: _Problem, estimate: FloatArray, residuals: FloatArray, gradient: FloatArray, length: FloatArray
) -> float:
    """Return the step that is left over where none lowers the sum of squares.

    Raises: SolveError unless that step is negligible.
    """
    step = _damped_step(gradient, residuals, length, 0.0)
    relative = _step_in_uncertainties(gradient, residuals, step)
    floor = ROUNDING_FLOOR * float(np.linalg.norm(problem.whiten(problem.observed)))
    if relative > CONVERGED and float(np.linalg.norm(gradient @ step)) > 1e3 * floor:
        raise SolveError(
            f"Gauss-Newton: stalled at {estimate.tolist()}: no step lowers the sum of squares, yet one of "
            f"{relative:.2g} standard uncertainties is left, allowed {CONVERGED:g}; nothing is reported; "
            "start elsewhere, or add points"
        )
    return relative


def _descend(
    problem: _Problem,
    estimate: FloatArray,
    residuals: FloatArray,
    gradient: FloatArray,
    length: FloatArray,
    damping: float,
) -> tuple[FloatArray | None, bool, float, int]:
    """Return a step that earns a fair part of the reduction it promises.

    With it: whether it is undamped, the damping to go on with, and how many steps were tried in vain. No step at all:
    nothing more is to be gained in double precision.
    """
    cost, tried = float(residuals @ residuals), 0
    while damping <= LARGEST_DAMPING:
        step = _damped_step(gradient, residuals, length, damping)
        left = residuals - gradient @ step
        promised = cost - float(left @ left)
        reached = problem.residuals(estimate + step)
        earned = cost - _square(reached)
        if promised <= TOO_LITTLE_TO_MEASURE * cost:
            return _step_on_trust(problem, estimate, residuals, gradient, length), True, 0.0, tried
        if earned >= SMALLEST_GAIN * promised:
            return step, damping == 0.0, _next_damping(damping, earned / promised), tried
        damping, tried = max(10.0 * damping, FIRST_DAMPING), tried + 1
    return None, False, damping, tried


def _square(residuals: FloatArray) -> float:
    """Sum of squares; infinite where the model overflowed."""
    with np.errstate(over="ignore"):
        square = float(residuals @ residuals)
    return square if np.isfinite(square) else float("inf")


def _step_on_trust(
    problem: _Problem, estimate: FloatArray, residuals: FloatArray, gradient: FloatArray, length: FloatArray
) -> FloatArray | None:
    """Return the full step, unless it makes the fit visibly worse."""
    step = _damped_step(gradient, residuals, length, 0.0)
    size, reached = np.linalg.norm(residuals), np.linalg.norm(problem.residuals(estimate + step))
    floor = ROUNDING_FLOOR * float(np.linalg.norm(problem.whiten(problem.observed)))
    return step if reached <= size * (1.0 + 1e-9) + floor else None


def _next_damping(damping: float, gain: float) -> float:
    if gain < 0.25:
        return max(10.0 * damping, FIRST_DAMPING)
    if gain > 0.75:
        return damping / 10.0 if damping > 1e-8 else 0.0
    return damping


def _damped_step(gradient: FloatArray, residuals: FloatArray, length: FloatArray, damping: float) -> FloatArray:
    """Return Marquardt's step, every parameter scaled by the largest slope it has had."""
    length = np.where(length > 0.0, length, 1.0)
    scaled, right = gradient / length, residuals
    if damping > 0.0:
        size = scaled.shape[1]
        scaled = np.vstack([scaled, np.sqrt(damping) * np.eye(size)])
        right = np.concatenate([residuals, np.zeros(size)])
    return np.asarray(np.linalg.lstsq(scaled, right, rcond=1e-14)[0]) / length


def _step_in_uncertainties(gradient: FloatArray, residuals: FloatArray, step: FloatArray) -> float:
    """Return the largest step over its parameter's standard uncertainty; infinite where that is not defined."""
    dof = residuals.size - step.size
    length = np.linalg.norm(gradient, axis=0)
    if not np.all(length > 0.0):
        return float("inf")
    scaled = gradient / length
    uncertainty = np.sqrt(np.diag(np.linalg.pinv(scaled.T @ scaled)).clip(min=0.0) * float(residuals @ residuals) / dof)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(step == 0.0, 0.0, np.abs(step) * length / uncertainty)
    return float(np.max(ratio)) if np.all(np.isfinite(ratio)) else float("inf")
