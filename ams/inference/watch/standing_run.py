"""Rows in which an output of one or two accelerometers stands at its zero, and what they say of it."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.inference.watch.frozen_outputs import LEAST_ROWS

MOST_FOLLOWED: Final = 0.05
"""Of its share, which a package that is turned about the very axis of the sensor may take off by chance."""
LEAST_NOISE_G: Final = 2e-7
"""No output is taken to have less."""
_STANDS_SD: Final = 2.0
"""Root mean square about the zero: of an output that passes it there is more."""
_SURE_SD: Final = 3.0
_KNOWN_SD: Final = 12.0
"""By which the share is to be known from the calibration."""


@dataclass
class StandingRun:
    """Rows that follow one another in which one output lies at one of its zeros."""

    axis: int
    """Place among the columns of the package."""
    is_offset: bool
    """Else it lies at 0 V."""
    first: int
    noise_v: float
    sensitivity_v: float
    """A g."""
    share_variance_v2: FloatArray
    """(2, 2) of what the calibration leaves open of the sensitivities across the axis."""
    rows: int = 0
    flagged_from: int | None = None
    """The row from which on it was flagged as it was answered."""
    _sums: FloatArray = field(default_factory=lambda: np.zeros(5))
    _forces: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))

    @property
    def end(self) -> int:
        """The row after the last."""
        return self.first + self.rows

    def take(self, deviation_v: FloatArray, share_v: FloatArray, across_g: FloatArray) -> None:
        """Take further rows: (n,) outputs less their zero, (n,) what the other axes make of them, (2, n) those."""
        self.rows += deviation_v.size
        self._sums += [
            deviation_v.sum(), deviation_v @ deviation_v, share_v.sum(), share_v @ share_v, share_v @ deviation_v,
        ]  # fmt: skip
        padded = np.vstack([np.ones(deviation_v.size), across_g])
        self._forces += padded @ padded.T

    @property
    def stands(self) -> bool:
        """Whether so many rows lie about the zero, and do not pass it."""
        return self.rows >= LEAST_ROWS and bool(np.sqrt(self._sums[1] / self.rows) <= _STANDS_SD * self.noise_v)

    @property
    def is_dead(self) -> bool:
        """Whether nothing of its share is in the output, where it would be seen."""
        follows, sd = self._follows()
        variation = self._forces[1:, 1:] - np.outer(self._forces[0, 1:], self._forces[0, 1:]) / self.rows
        open_v2 = float(np.sum(variation * self.share_variance_v2))
        is_known = self._share_v2() >= _KNOWN_SD**2 * open_v2
        return self.stands and is_known and abs(follows) + _SURE_SD * sd <= MOST_FOLLOWED

    @property
    def is_level(self) -> bool:
        """Whether its share is in the output, so that it is alive."""
        follows, sd = self._follows()
        return follows - _SURE_SD * sd > MOST_FOLLOWED

    def _share_v2(self) -> float:
        """Return the sum of squares of the share about its mean."""
        return max(float(self._sums[3] - self._sums[2] ** 2 / self.rows), 0.0)

    def _follows(self) -> tuple[float, float]:
        """Return the slope of the output on its share, one of a sensor and zero of none, and its standard deviation."""
        square_v2 = self._share_v2()
        if not square_v2 > 0.0:
            return 0.0, np.inf
        left_v2 = max(float(self._sums[1] - self._sums[0] ** 2 / self.rows), 0.0) / max(self.rows - 1, 1)
        noise_v = max(np.sqrt(left_v2), LEAST_NOISE_G * self.sensitivity_v)
        slope = (self._sums[4] - self._sums[2] * self._sums[0] / self.rows) / square_v2
        return float(slope), float(noise_v / np.sqrt(square_v2))
