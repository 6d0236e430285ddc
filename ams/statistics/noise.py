"""Allan deviation: how the mean of a resting sensor wanders with the time it is averaged over.

The overlapping estimator of IEEE Std 1139 / NIST SP 1065 on evenly sampled values: white noise falls as τ^−½ and reads
its random walk coefficient at τ = 1 s; a flat bottom is the bias instability; a rise as τ^½ is a walking bias.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError


@dataclass(frozen=True)
class AllanDeviation:
    """The overlapping Allan deviation and how well it is known."""

    tau_s: FloatArray
    deviation: FloatArray
    """In the unit of the values."""
    relative_uncertainty: FloatArray
    """1/√(2·dof) with the degrees of freedom of white noise: a guide, exact only where white noise prevails."""

    def from_tau(self, shortest_s: float) -> "AllanDeviation":
        """Return it without the averaging times below; the longest always stays."""
        kept = self.tau_s >= min(shortest_s, self.tau_s[-1])
        return AllanDeviation(self.tau_s[kept], self.deviation[kept], self.relative_uncertainty[kept])


def allan_deviation(values: FloatArray, interval_s: float, factors: Sequence[int] | None = None) -> AllanDeviation:
    """Return the overlapping Allan deviation of values (N,) at averaging times of ``factors`` sample intervals.

    ``factors`` defaults to powers of two up to N/4. Source: NIST SP 1065 (2008), eq. 11, for frequency-like data.
    Raises: ObservationsError for fewer than 3 values, values that are not finite, or a factor outside 1 to N/2.
    """
    y = np.asarray(values, dtype=float)
    if y.size < 3 or not np.all(np.isfinite(y)) or not interval_s > 0.0:
        raise ObservationsError(
            f"Allan deviation: got {y.size} values at {interval_s:g} s: three or more finite values at an interval "
            "above 0 s are needed"
        )
    chosen = _octaves(y.size) if factors is None else [int(m) for m in factors]
    if any(not 1 <= m <= y.size // 2 for m in chosen):
        raise ObservationsError(f"Allan deviation: got averaging factors {chosen}, allowed 1 to {y.size // 2}")
    sums = np.concatenate([[0.0], np.cumsum(y - y.mean())])
    deviation = np.array([_overlapping(sums, m) for m in chosen])
    dof = np.array([_white_dof(y.size, m) for m in chosen])
    return AllanDeviation(np.array(chosen) * interval_s, deviation, 1.0 / np.sqrt(2.0 * dof))


def _octaves(count: int) -> list[int]:
    return [2**j for j in range(int(np.log2(max(count // 4, 1))) + 1)]


def _overlapping(sums: FloatArray, m: int) -> float:
    """Return √(½ mean of squared differences of adjacent means over m values)."""
    second = sums[2 * m :] - 2.0 * sums[m:-m] + sums[: -2 * m]
    return float(np.sqrt(np.mean(second**2) / 2.0) / m)


def _white_dof(count: int, m: int) -> float:
    """Return the degrees of freedom for white frequency noise. Source: NIST SP 1065, table 5 (white FM)."""
    n = count + 1
    return max(1.0, (3.0 * (n - 1) / (2.0 * m) - 2.0 * (n - 2) / n) * 4.0 * m**2 / (4.0 * m**2 + 5.0))


@dataclass(frozen=True)
class NoiseCoefficients:
    """What the deviation says about a gyro or accelerometer at rest."""

    random_walk_per_sqrt_s: float
    """White noise: deviation × √τ on the white slope, unit·√s."""
    bias_instability: float
    """Lowest deviation divided by 0.664 (√(2 ln 2/π)), unit of the values."""
    bias_instability_tau_s: float
    is_bottom_reached: bool
    """False where the deviation still falls at the longest averaging time: the instability is then an upper limit."""


def read_coefficients(allan: AllanDeviation) -> NoiseCoefficients:
    """Read random walk and bias instability from an Allan deviation. Source: IEEE Std 952, annex C."""
    lowest = int(np.argmin(allan.deviation))
    white = allan.deviation * np.sqrt(allan.tau_s)
    until = max(1, (lowest + 1) // 2)
    weights = allan.relative_uncertainty[:until] ** -2
    return NoiseCoefficients(
        random_walk_per_sqrt_s=float(np.average(white[:until], weights=weights)),
        bias_instability=float(allan.deviation[lowest] / np.sqrt(2.0 * np.log(2.0) / np.pi)),
        bias_instability_tau_s=float(allan.tau_s[lowest]),
        is_bottom_reached=lowest < allan.deviation.size - 1,
    )
