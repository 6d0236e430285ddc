"""Linear calibrations: real = A·measured + B, from two levels or from many.

SR brings each sensor to two known states (axis up and down, two rates, field on and off) and solves the two equations.
With more than two levels the straight line is fitted by least squares, and it then has residuals, a standard error and
intervals. Source: SR 4.1 and 'Calibration and Conversion Equations'.
"""

from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError, ObservationsError
from ams.statistics.distributions import student_t_quantile


@dataclass(frozen=True)
class Line:
    """out = gain·in + offset."""

    gain: float
    offset: float

    def __call__(self, value: FloatArray) -> FloatArray:
        return self.gain * np.asarray(value, dtype=float) + self.offset


@dataclass(frozen=True)
class LineFit:
    """A line with what least squares knows about it."""

    line: Line
    covariance: FloatArray
    """(2, 2) of (gain, offset); NaN with two levels, where nothing is left over to estimate it from."""
    residuals: FloatArray
    """(N,) real minus fitted, in units of the real quantity."""
    standard_error: float | None
    """None with two levels."""
    degrees_of_freedom: int

    def standard_uncertainty(self, measured: FloatArray) -> FloatArray:
        """Return the standard uncertainty of the fitted line at the measured values, (N,)."""
        basis = np.column_stack([np.asarray(measured, dtype=float), np.ones(np.size(measured))])
        return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", basis, self.covariance, basis)), dtype=float)

    def half_width(self, measured: FloatArray, level: float = 0.95, new_reading_sd: float | None = None) -> FloatArray:
        """Return the half width of the confidence interval, or of the prediction interval for a new reading.

        ``new_reading_sd`` is the standard deviation of the new value in units of the real quantity; None leaves it out.
        Raises: DesignError with two levels, where there are no degrees of freedom.
        """
        if self.degrees_of_freedom == 0:
            raise DesignError("linear calibration: two levels leave no degrees of freedom: no interval can be stated")

        variance = self.standard_uncertainty(measured) ** 2
        if new_reading_sd is not None:
            variance = variance + new_reading_sd**2
        return np.asarray(student_t_quantile(0.5 + level / 2, self.degrees_of_freedom) * np.sqrt(variance), dtype=float)


def fit_line(measured: FloatArray, real: FloatArray) -> LineFit:
    """Fit real on measured by least squares; with two levels it is SR's two-point solution.

    The known quantity is regressed on the measured one, as SR uses it (real = A·measured + B).
    Raises: DesignError with fewer than two different levels.
    """
    x, y = np.asarray(measured, dtype=float), np.asarray(real, dtype=float)
    spread = x - x.mean() if x.size else x
    sxx = float(spread @ spread)
    if x.size < 2 or sxx == 0.0:
        raise DesignError(
            f"linear calibration: {x.size} level(s), all measured alike: gain and offset need two different levels"
        )
    gain = float(spread @ (y - y.mean()) / sxx)
    line = Line(gain, float(y.mean() - gain * x.mean()))
    residuals = y - line(x)
    dof = x.size - 2
    if dof == 0:
        return LineFit(line, np.full((2, 2), np.nan), residuals, None, 0)
    variance = float(residuals @ residuals) / dof
    return LineFit(line, _line_covariance(variance, x, sxx), residuals, float(np.sqrt(variance)), dof)


def _line_covariance(variance: float, x: FloatArray, sxx: float) -> FloatArray:
    mean = float(x.mean())
    return (variance / sxx) * np.array([[1.0, -mean], [-mean, sxx / x.size + mean**2]])


@dataclass(frozen=True)
class MagnetDifference:
    """SR's substitute for a coil: the field of a magnet by difference, and the levels it gives."""

    applied_field: float
    """Mean magnitude of the magnet's field along the axis, in the units of the readings."""
    real: tuple[float, float]
    measured: tuple[float, float]


def magnet_difference(*, with_magnet: tuple[float, float], without_magnet: tuple[float, float]) -> MagnetDifference:
    """Return levels for :func:`fit_line` from readings in the positive and the negative direction of one axis.

    The magnet's field is the mean of the two magnitudes of (with − without); the 'real' value of each direction is the
    reading with the magnet less that mean field, the measured one the reading without it. The field so found is in the
    sensor's own units: this calibrates symmetry and offset, not the absolute scale. Source: SR 4.1.3.
    """
    differences = (with_magnet[0] - without_magnet[0], with_magnet[1] - without_magnet[1])
    if differences[0] == 0.0 or differences[1] == 0.0 or (differences[0] > 0) == (differences[1] > 0):
        raise ObservationsError(
            f"magnetometer: the magnet changed the readings by {differences[0]:g} and {differences[1]:g}: the two "
            "directions of an axis must change in opposite senses; check which reading belongs to which direction"
        )
    applied = (abs(differences[0]) + abs(differences[1])) / 2
    sign = 1.0 if differences[0] > 0 else -1.0
    real = (with_magnet[0] - sign * applied, with_magnet[1] + sign * applied)
    return MagnetDifference(applied, real, without_magnet)
