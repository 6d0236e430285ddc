"""The Monte Carlo check of a budget: distributions propagated through the measurement function (GUM supplement 1).

Inputs are drawn from the distributions that their kind implies, correlated normal inputs together; the result is held
against the first-order budget to the digits that are to be stated (S1, 8).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SolveError
from ams.statistics.budget import Budget, Function, Input, correlation_matrix


@dataclass(frozen=True)
class MonteCarlo:
    """What the trials say of each of m results."""

    mean: FloatArray
    standard_uncertainty: FloatArray
    covariance: FloatArray
    interval: FloatArray
    """(m, 2) shortest interval that holds the level's share of the trials."""
    symmetric_interval: FloatArray
    """(m, 2) with equal tails."""
    trials: int


def propagate(
    function: Function,
    inputs: Sequence[Input],
    rng: np.random.Generator,
    *,
    trials: int = 200_000,
    level: float = 0.95,
    correlations: Mapping[tuple[str, str], float] | None = None,
) -> MonteCarlo:
    """Propagate distributions; ``function`` takes (n, M) and returns (M,) or (m, M).

    Raises: SolveError where a trial is not finite, or a correlation concerns inputs that are not normal.
    """
    drawn = draw(inputs, rng, trials, correlations or {})
    results = np.atleast_2d(np.asarray(function(drawn), dtype=float))
    if not np.all(np.isfinite(results)):
        bad = int(np.sum(~np.all(np.isfinite(results), axis=0)))
        raise SolveError(
            f"Monte Carlo: {bad} of {trials} trials gave no finite result: an input's distribution reaches "
            "where the measurement function has no value; narrow it or change the function"
        )
    return summarise(results, level)


def summarise(results: FloatArray, level: float = 0.95) -> MonteCarlo:
    """Return what (m, M) trials of m results say. Source: S1 7.5 to 7.7."""
    ordered = np.sort(results, axis=1)
    tails = np.quantile(ordered, [0.5 - level / 2, 0.5 + level / 2], axis=1).T
    shortest = np.stack([_shortest(row, level) for row in ordered])
    return MonteCarlo(
        results.mean(axis=1),
        results.std(axis=1, ddof=1),
        np.atleast_2d(np.cov(results)),
        shortest,
        tails,
        results.shape[1],
    )


def draw(
    inputs: Sequence[Input], rng: np.random.Generator, trials: int, correlations: Mapping[tuple[str, str], float]
) -> FloatArray:
    """Draw (n, trials) values of the inputs. Source: S1 6.4."""
    together = {name for pair in correlations for name in pair}
    unfit = [i.name for i in inputs if i.name in together and not _is_normal(i)]
    if unfit:
        raise SolveError(
            f"Monte Carlo: {', '.join(unfit)}: correlated inputs must be normal with infinite degrees of freedom"
        )
    drawn = np.stack([_draw_input(i, rng, trials) for i in inputs])
    joint = [n for n, i in enumerate(inputs) if i.name in together]
    if joint:
        r = correlation_matrix([i.name for i in inputs], correlations)[np.ix_(joint, joint)]
        values, vectors = np.linalg.eigh(r)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        scale = np.array([inputs[n].standard_uncertainty for n in joint])[:, None]
        centre = np.array([inputs[n].value for n in joint])[:, None]
        drawn[joint] = centre + scale * (root @ rng.standard_normal((len(joint), trials)))
    return drawn


def _is_normal(i: Input) -> bool:
    return i.kind in ("standard", "expanded") and not np.isfinite(i.degrees_of_freedom)


def _draw_input(i: Input, rng: np.random.Generator, trials: int) -> FloatArray:
    if i.kind == "limit":
        shape = rng.uniform(-(3**0.5), 3**0.5, trials)
    elif i.kind == "triangular":
        shape = rng.triangular(-(6**0.5), 0.0, 6**0.5, trials)
    elif i.kind == "arcsine":
        shape = 2**0.5 * np.sin(rng.uniform(-np.pi, np.pi, trials))
    elif np.isfinite(i.degrees_of_freedom):
        shape = rng.standard_t(i.degrees_of_freedom, trials)
    else:
        shape = rng.standard_normal(trials)
    return np.asarray(i.value + i.standard_uncertainty * shape)


def _shortest(ordered: FloatArray, level: float) -> FloatArray:
    held = round(level * ordered.size)
    widths = ordered[held:] - ordered[: ordered.size - held]
    start = int(np.argmin(widths))
    return np.array([ordered[start], ordered[start + held]])


@dataclass(frozen=True)
class Agreement:
    """Whether the first-order budget may be used."""

    is_confirmed: bool
    tolerance: FloatArray
    """(m,) half a unit of the last significant digit of the standard uncertainty."""


def confirm(budget: Budget, monte_carlo: MonteCarlo, level: float = 0.95, digits: int = 2) -> Agreement:
    """Hold the budget's interval against the trials' equal-tailed one. Source: S1 8.1.

    For users of the library: calrig's own reports print both intervals.
    """
    half = budget.expanded(level)
    exponent = np.floor(np.log10(budget.standard_uncertainties)) - (digits - 1)
    tolerance = 0.5 * 10.0**exponent
    lower = np.abs(budget.values - half - monte_carlo.symmetric_interval[:, 0])
    upper = np.abs(budget.values + half - monte_carlo.symmetric_interval[:, 1])
    return Agreement(bool(np.all(lower <= tolerance) and np.all(upper <= tolerance)), tolerance)
