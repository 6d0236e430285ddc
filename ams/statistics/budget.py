"""An uncertainty budget by the GUM: inputs of type A and type B joined into one result or several.

Each input has an estimate, a standard uncertainty and degrees of freedom; inputs may be correlated. Sensitivities are
the derivatives of the measurement function, taken by central differences of fourth order. The combined uncertainty is
GUM (13) and (16), its degrees of freedom Welch-Satterthwaite (G.2b), several results from the same inputs get their
full covariance (H.2). The Monte Carlo check is :mod:`ams.statistics.monte_carlo`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.errors import SolveError
from ams.statistics.distributions import normal_quantile, student_t_quantile

Function = Callable[[NDArray[np.generic]], NDArray[np.generic]]
"""(n,) inputs, or (n, M) for M trials, to (m,) results, or (m, M)."""
NEGLIGIBLE = 1e-3
"""Of the combined uncertainty: a source that puts less than this into a result is told as negligible."""
Kind = Literal["standard", "expanded", "limit", "triangular", "arcsine"]


@dataclass(frozen=True)
class Input:
    """One quantity that goes into the result."""

    name: str
    value: float
    standard_uncertainty: float
    degrees_of_freedom: float = float("inf")
    kind: Kind = "standard"
    """Distribution for the Monte Carlo check: normal or t, rectangular (``limit``), triangular, arcsine."""
    origin: Literal["A", "B"] = "B"


def type_b(
    name: str, value: float, stated: float, kind: Kind, coverage_factor: float = 2.0, degrees_of_freedom: float = np.inf
) -> Input:
    """Return an input as a certificate states it.

    ``stated`` is the half-width of a limit, or an expanded uncertainty.

    Source: GUM 4.3.3 to 4.3.9.
    """
    divisor = {"standard": 1.0, "expanded": coverage_factor, "limit": 3**0.5, "triangular": 6**0.5, "arcsine": 2**0.5}
    return Input(name, value, stated / divisor[kind], degrees_of_freedom, kind, "B")


def type_a(name: str, readings: Sequence[float]) -> Input:
    """Return the mean of repeated readings. Source: GUM 4.2.3. Raises: SolveError for a single reading."""
    values = np.asarray(readings, dtype=float)
    if values.size < 2:
        raise SolveError(
            f"budget: {name}: {values.size} reading(s) have no scatter; take two or more, or state a type B"
        )
    return Input(
        name, float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size)), values.size - 1, "standard", "A"
    )


@dataclass(frozen=True)
class Budget:
    """Results with their covariance and what each input contributes."""

    inputs: tuple[Input, ...]
    values: FloatArray
    """(m,)"""
    sensitivities: FloatArray
    """(m, n)"""
    covariance: FloatArray
    """(m, m)"""
    degrees_of_freedom: FloatArray
    """(m,) effective."""
    correlated: bool = field(default=False)
    """Welch-Satterthwaite takes the inputs as independent; with correlated ones it is a guide."""

    @property
    def standard_uncertainties(self) -> FloatArray:
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def contributions(self) -> FloatArray:
        """(m, n) |c_i| u_i, in the units of the results."""
        return np.asarray(np.abs(self.sensitivities) * np.array([i.standard_uncertainty for i in self.inputs]))

    def correlation(self) -> FloatArray:
        u = self.standard_uncertainties
        return np.asarray(self.covariance / np.outer(u, u))

    def expanded(self, level: float = 0.95) -> FloatArray:
        """Return the (m,) expanded uncertainties t_p(ν_eff)·u_c.

        ν_eff is truncated to the integer below as GUM G.4.1 has it.
        """
        tail = 0.5 + level / 2.0
        floor = np.maximum(np.floor(np.where(np.isfinite(self.degrees_of_freedom), self.degrees_of_freedom, 1.0)), 1.0)
        factors = np.where(np.isfinite(self.degrees_of_freedom), student_t_quantile(tail, floor), normal_quantile(tail))
        return np.asarray(factors * self.standard_uncertainties)


def combine(
    function: Function, inputs: Sequence[Input], correlations: Mapping[tuple[str, str], float] | None = None
) -> Budget:
    """Propagate the inputs through the measurement function to first order.

    Raises: SolveError for a correlation outside ±1, of an unknown input, or of a matrix that no inputs can have, and
    where the function is not finite at the estimates.
    """
    x = np.array([i.value for i in inputs])
    u = np.array([i.standard_uncertainty for i in inputs])
    r = correlation_matrix([i.name for i in inputs], correlations or {})
    values = np.atleast_1d(np.asarray(function(x), dtype=float))
    columns = [_derivative(function, x, i, float(u[i])) for i in range(x.size)]
    sensitivities = np.stack(columns, axis=1)
    if not (np.all(np.isfinite(values)) and np.all(np.isfinite(sensitivities))):
        raise SolveError("budget: the measurement function or a derivative is not finite at the estimates")
    scaled = sensitivities * u
    covariance = scaled @ r @ scaled.T
    dof = _welch_satterthwaite(scaled, np.diag(covariance), np.array([i.degrees_of_freedom for i in inputs]))
    return Budget(tuple(inputs), values, sensitivities, covariance, dof, bool(correlations))


def correlation_matrix(names: Sequence[str], correlations: Mapping[tuple[str, str], float]) -> FloatArray:
    """Return the (n, n) correlations from pairs of names. Raises: SolveError where it is not possible."""
    r = np.eye(len(names))
    for (first, second), value in correlations.items():
        if first not in names or second not in names or first == second or not -1.0 <= value <= 1.0:
            raise SolveError(
                f"budget: correlation of {first!r} and {second!r} is {value:g}: allowed −1 to 1 between two "
                f"different inputs of {', '.join(names)}"
            )
        i, j = names.index(first), names.index(second)
        r[i, j] = r[j, i] = value
    if np.linalg.eigvalsh(r)[0] < -1e-9:
        raise SolveError("budget: these correlations contradict each other (the matrix has a negative eigenvalue)")
    return r


def _welch_satterthwaite(scaled: FloatArray, variances: FloatArray, dof: FloatArray) -> FloatArray:
    """Return (G.2b) as the GUM prints it, so that a budget can be laid beside anybody else's.

    Intervals of a solution take :func:`ams.statistics.intervals.combined_dof`, which is not too generous where an
    input has one or two degrees of freedom.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sum(np.where(np.isfinite(dof), scaled**4 / dof, 0.0), axis=1)
        return np.where(spread > 0.0, variances**2 / spread, np.inf)


def _derivative(function: Function, x: FloatArray, i: int, u: float) -> FloatArray:
    """Return the central difference of fourth order over a fifth of the standard uncertainty to either side."""
    h = 0.1 * u if u > 0.0 else 1e-4 * max(abs(float(x[i])), 1.0)
    move = np.zeros_like(x)
    move[i] = h
    near, far = (
        np.atleast_1d(np.asarray(function(x + n * move), dtype=float))
        - np.atleast_1d(np.asarray(function(x - n * move), dtype=float))
        for n in (1, 2)
    )
    return np.asarray((8.0 * near - far) / (12.0 * h))
