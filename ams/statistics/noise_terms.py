"""The five terms of a sensor's noise at rest, each with its interval, from an Allan variance.

σ²(τ) = 3Q²/τ² + N²/τ + (2 ln 2/π) B² + K²τ/3 + R²τ²/2: quantisation, random walk of the integral (white noise), bias
instability, walk of the bias, and ramp. The variance is linear in the squares, so they are found by weighted least
squares; a square may come out below zero, and its interval says then that the record does not tell it. The weights are
those of the fitted variance: an estimate with ν degrees of freedom scatters by √(2/ν) of itself, ν by the kind of noise
that prevails. Source: IEEE Std 952, annex C; NIST SP 1065, table 5.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError
from ams.statistics.intervals import t_quantile
from ams.statistics.noise import AllanDeviation

TERMS: Final = ("quantisation", "white", "instability", "walk", "ramp")
WORDS: Final = {
    "quantisation": "quantisation Q",
    "white": "random walk N",
    "instability": "bias instability B",
    "walk": "walk of the bias K",
    "ramp": "ramp R",
}
POWER_OF_TIME: Final = {"quantisation": 1.0, "white": 0.5, "instability": 0.0, "walk": -0.5, "ramp": -1.0}
"""The unit of a term is the unit of the values times seconds to this power."""
_ROUNDS: Final = 12
_LEAST_SHARE: Final = 1e-6


@dataclass(frozen=True)
class NoiseTerm:
    """One coefficient; None where the record does not tell it from zero, and then ``high`` is all that is known."""

    name: str
    value: float | None
    low: float
    """Of the 95 % interval."""
    high: float


def noise_terms(allan: AllanDeviation, count: int, interval_s: float, level: float = 0.95) -> tuple[NoiseTerm, ...]:
    """Return the five terms of the Allan deviation of ``count`` values.

    Raises: ObservationsError with fewer than six averaging times.
    """
    if allan.tau_s.size < len(TERMS) + 1:
        raise ObservationsError(
            f"noise: got {allan.tau_s.size} averaging times, needed {len(TERMS) + 1} for five terms: rest for longer"
        )
    columns, variance = columns_of(allan.tau_s), allan.deviation**2
    dof = _dof(np.rint(allan.tau_s / interval_s), count)
    fitted = variance
    for _ in range(_ROUNDS):
        # 1/√ν of a sum: what kinds of noise go together is at most the sum of their own.
        scatter = fitted * np.sqrt(2.0) * np.asarray(np.sum(_shares(columns, variance, fitted) / np.sqrt(dof), axis=1))
        weighed = columns / scatter[:, None]
        size = np.linalg.norm(weighed, axis=0)
        squares = np.linalg.lstsq(weighed / size, variance / scatter, rcond=None)[0] / size
        before, fitted = fitted, np.maximum(columns @ np.maximum(squares, 0.0), _LEAST_SHARE * variance)
        if np.all(np.abs(fitted / before - 1.0) < 1e-6):
            break
    inverse = np.linalg.inv((weighed / size).T @ (weighed / size))
    spread = np.sqrt(np.diag(inverse)) / size
    half = float(t_quantile(level, float(allan.tau_s.size - len(TERMS)))) * spread
    found = zip(TERMS, squares.tolist(), half.tolist(), strict=True)
    return tuple(_term(name, square, width) for name, square, width in found)


def columns_of(tau_s: FloatArray) -> FloatArray:
    """Return what the squares of the five coefficients are multiplied by, (n, 5)."""
    flat = np.full_like(tau_s, 2.0 * np.log(2.0) / np.pi)
    return np.stack([3.0 / tau_s**2, 1.0 / tau_s, flat, tau_s / 3.0, tau_s**2 / 2.0], axis=-1)


def _term(name: str, square: float, half: float) -> NoiseTerm:
    low, high = max(square - half, 0.0), max(square + half, 0.0)
    return NoiseTerm(name, float(np.sqrt(square)) if low > 0.0 else None, float(np.sqrt(low)), float(np.sqrt(high)))


def _shares(columns: FloatArray, variance: FloatArray, fitted: FloatArray) -> FloatArray:
    """Return which part of the variance each kind of noise is, by the slopes that prevail about every time, (n, 5)."""
    scale = columns / np.linalg.norm(columns / variance[:, None], axis=0)
    squares = np.maximum(np.linalg.lstsq(scale / fitted[:, None], variance / fitted, rcond=None)[0], 0.0)
    parts = scale * squares + _LEAST_SHARE * variance[:, None]
    return np.asarray(parts / parts.sum(axis=1, keepdims=True))


def _dof(m: FloatArray, count: int) -> FloatArray:
    """Return the degrees of freedom of the overlapping estimator for each kind of noise, (n, 5); a ramp as the walk."""
    n = float(count + 1)
    phase = (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m))
    white = (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m**2 / (4.0 * m**2 + 5.0)
    flicker = np.where(m < 1.5, 2.0 * (n - 2.0) ** 2 / (2.3 * n - 4.9), 5.0 * n**2 / (4.0 * m * (n + 3.0 * m)))
    walk = (n - 2.0) / m * ((n - 1.0) ** 2 - 3.0 * m * (n - 1.0) + 4.0 * m**2) / (n - 3.0) ** 2
    return np.asarray(np.maximum(np.stack([phase, white, flicker, walk, walk], axis=-1), 1.0))
