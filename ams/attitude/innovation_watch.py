"""Whether what gravity says against gyros keeps a mean of zero: innovations of a sound filter are white.

A zero of a gyro that is not as stated turns the estimate away, gravity pulls it back, and row by row the difference is
far below the noise of one force: the gate of a row sees nothing of it. Summed over seconds it stands out. Across the
vertical the innovations are added up, each row weighing less by a share the older it is, and so are their covariances;
where the assumptions hold the normalised sum has a chi-square of two degrees of freedom.
"""

from dataclasses import dataclass
from math import exp, hypot, log
from typing import Final

from ams.attitude.kalman import Weighed

CHANCE: Final = 1e-7
"""Of so large a sum where the assumptions hold; about one time constant of rows is one trial."""
_LIMIT: Final = -2.0 * log(CHANCE)


@dataclass
class InnovationWatch:
    """Sums of innovations across the vertical, the reference axes x and y, that forget."""

    kept: float
    """Share of the sums that the next row keeps."""
    _x: float = 0.0
    _y: float = 0.0
    _xx: float = 0.0
    _xy: float = 0.0
    _yy: float = 0.0
    _rows: float = 0.0

    def contradicts(self, seen: Weighed, variance: float) -> bool:
        """Take a row, ``variance`` that of one component of the measurement; return whether the mean is not zero."""
        kept, squared, (x, y, _) = self.kept, self.kept**2, seen.innovation
        (xx, xy, _), (_, yy, _), _ = seen.spread
        self._x, self._y, self._rows = kept * self._x + x, kept * self._y + y, kept * self._rows + 1.0
        self._xx = squared * self._xx + xx + variance
        self._yy = squared * self._yy + yy + variance
        self._xy = squared * self._xy + xy
        x, y, xx, xy, yy = self._x, self._y, self._xx, self._xy, self._yy
        return x * x * yy - 2.0 * x * y * xy + y * y * xx > _LIMIT * (xx * yy - xy * xy)

    @property
    def mean(self) -> float:
        """Size of the mean innovation across the vertical, in the measurement's unit; 0 without a row."""
        return hypot(self._x, self._y) / self._rows if self._rows else 0.0

    def forget(self) -> None:
        """Begin anew."""
        self._x = self._y = self._xx = self._xy = self._yy = self._rows = 0.0


def watch_over(time_s: float, interval_s: float) -> InnovationWatch:
    """Return a watch whose rows lose a factor e of their weight in ``time_s``."""
    return InnovationWatch(exp(-interval_s / time_s))
