"""A sensor's calibrations since its last step, and what shows in them: the scatter, a straight line, a step inside.

The scatter between runs is what the calibrations leave about a straight line over time, with n − 2 degrees of freedom,
and about two levels where a step is looked for: neither a steady drift nor a step is in the scatter that it is judged
by, however large it is. (Half the mean square of successive differences, s² + δ²/2, holds a drift of δ from one to the
next, and t of the slope is then bounded whatever δ is.) It is weighed with that of the kind
(:mod:`ams.surveillance.between_runs`) and never less than what each calibration's own uncertainty lets it scatter.

A line and a step compete: a step is one where two levels leave less than a line does.
"""

from dataclasses import dataclass, field

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.statistics.intervals import t_quantile
from ams.surveillance.between_runs import Scatter

STEP_LEVEL = 0.002
"""Chance of any false step alarm at one calibration: half of it for the newest, half for a step further back."""
DRIFT_LEVEL = 0.001
LEAST_DOF = 2.0
"""Below this a scatter is not known well enough to judge by."""
LEAST_POINTS_OF_DRIFT = 5
_LEAST_POINTS_OF_STEP = 3
_MOST_LEVERAGE = 4.0
"""Variance of a calibration that a line foretells, in that of one; beyond it the line is not followed."""


@dataclass(frozen=True)
class _Line:
    """The least-squares lines of m calibrations, p characteristics."""

    mean_year: float
    mean: FloatArray
    slope: FloatArray
    """(p,) a year."""
    spread: float
    """Sum of squares of the years about their mean; zero where all are of one moment, and the slope then."""
    squares: FloatArray
    """(p,) what is left."""
    dof: int

    @classmethod
    def through(cls, years: FloatArray, values: FloatArray) -> "_Line":
        mean_year, mean = float(years.mean()), values.mean(axis=0)
        centred = years - mean_year
        spread = float(centred @ centred)
        slope = centred @ (values - mean) / spread if spread > 0.0 else np.zeros_like(mean)
        left = values - mean - np.outer(centred, slope)
        dof = max(years.size - 1 - (spread > 0.0), 0)
        return cls(mean_year, mean, slope, spread, (left**2).sum(axis=0), dof)


@dataclass
class Regime:
    """The calibrations since the last step, mix-ups left out, as they come in."""

    coordinates: FloatArray
    """(n, p) of all the sensor's calibrations, as small angles, radians."""
    drawn_rad: FloatArray
    """(n, p) what each calibration's own uncertainty lets it scatter."""
    years: FloatArray
    prior: Scatter
    step_level: float = 0.5 * STEP_LEVEL
    """Chance of any false step further back, over all characteristics and places."""
    members: list[int] = field(default_factory=lambda: [0])
    _closed_squares: FloatArray = field(init=False)
    """(p,) what regimes before left about their lines."""
    _closed_dof: int = 0

    def __post_init__(self) -> None:
        self._closed_squares = np.zeros(self.coordinates.shape[1])

    @property
    def scatter(self) -> Scatter:
        """The scatter about straight lines, of the kind and of the sensor's own, in all its regimes."""
        line = self._line
        return self._weighed(line.squares, line.dof)

    @property
    def left(self) -> tuple[FloatArray, int]:
        """The (p,) squares that the sensor's own calibrations leave about their lines, and the degrees of freedom."""
        line = self._line
        return self._closed_squares + line.squares, self._closed_dof + line.dof

    @property
    def slopes(self) -> tuple[FloatArray, FloatArray]:
        """(p,) slopes a year and their standard uncertainties."""
        line = self._line
        variance = self._weighed(line.squares, line.dof).variance
        return line.slope, np.sqrt(variance / line.spread) if line.spread > 0.0 else np.full_like(variance, np.inf)

    @property
    def newest(self) -> FloatArray:
        """(p,) the last calibration."""
        return np.asarray(self.coordinates[self.members[-1]])

    def difference_variance(self, index: int) -> FloatArray:
        """Return the (p,) variance of a calibration less the last one.

        It is the scatter between runs, or what the two calibrations themselves cannot tell where that is more.
        """
        stated = self.drawn_rad[index] ** 2 + self.drawn_rad[self.members[-1]] ** 2
        return np.asarray(np.fmax(2.0 * self.scatter.variance, stated))

    def prediction(self, index: int) -> tuple[FloatArray, FloatArray]:
        """Return (p,) where the next calibration is to lie at least, and at most; NaN while too little is known.

        It lies where the last one did or goes on along the line: the interval holds both.
        """
        scatter, line, count = self.scatter, self._line, len(self.members)
        level = 1.0 - 0.5 * STEP_LEVEL / self.coordinates.shape[1]
        factor = np.where(scatter.dof >= LEAST_DOF, t_quantile(level, scatter.dof), np.nan)
        half = factor * np.sqrt(self.difference_variance(index))
        low, high = self.newest - half, self.newest + half
        ahead = self.years[index] - line.mean_year
        leverage = 1.0 + 1.0 / count + ahead**2 / line.spread if line.spread > 0.0 else np.inf
        if count < _LEAST_POINTS_OF_STEP or leverage > _MOST_LEVERAGE:
            return low, high
        half = factor * np.sqrt(leverage * np.fmax(scatter.variance, self.drawn_rad[index] ** 2))
        middle = line.mean + line.slope * ahead
        return np.minimum(low, middle - half), np.maximum(high, middle + half)

    def drifting(self) -> BoolArray:
        """Return (p,) which slopes are real."""
        scatter, (slope, spread) = self.scatter, self.slopes
        if len(self.members) < LEAST_POINTS_OF_DRIFT:
            return np.zeros(slope.size, dtype=bool)
        limit = t_quantile(1.0 - DRIFT_LEVEL / slope.size, scatter.dof)
        return np.asarray((scatter.dof >= LEAST_DOF) & (np.abs(slope) > limit * spread))

    def step_inside(self) -> tuple[int, BoolArray] | None:
        """Return with which of the members a new level begins, and (p,) of what; None where none is seen."""
        values, count = self.coordinates[self.members], len(self.members)
        width = values.shape[1]
        if count < _LEAST_POINTS_OF_STEP:
            return None
        cuts = np.arange(1, count)[:, None]
        centred = values - values.mean(axis=0)
        # means differ by m·Σ/(k(m − k)), Σ the sum of the first k about the mean: Σ²·m/(k(m − k)) of the squares
        explained = np.cumsum(centred, axis=0)[:-1] ** 2 * count / (cuts * (count - cuts))
        left = np.maximum((centred**2).sum(axis=0) - explained, 0.0)
        scatter = self._weighed(left, count - 2)
        limit = t_quantile(1.0 - self.step_level / (width * (count - 1)), scatter.dof)
        seen = (scatter.dof >= LEAST_DOF) & (explained > limit**2 * scatter.variance) & (left < self._line.squares)
        if not seen.any():
            return None
        begins = int(np.argmax(np.where(seen, explained / scatter.variance, 0.0).max(axis=1)))
        return begins + 1, np.asarray(seen[begins])

    def change_at(self, begins: int) -> FloatArray:
        """Return (p,) the mean from one of the members on less that of those before it."""
        values = self.coordinates[self.members]
        return np.asarray(values[begins:].mean(axis=0) - values[:begins].mean(axis=0))

    def begin_anew(self, members: list[int]) -> None:
        """Go on with these after a step; those before them remain in the scatter."""
        self.members = [index for index in self.members if index not in members]
        self._closed_squares, self._closed_dof = self.left
        self.members = members

    @property
    def _line(self) -> _Line:
        return _Line.through(self.years[self.members], self.coordinates[self.members])

    def _weighed(self, squares: FloatArray, dof: int) -> Scatter:
        """Return the scatter by what these calibrations leave, (…, p), never less than what they state."""
        found = self.prior.with_sensor(self._closed_squares + squares, self._closed_dof + dof)
        stated = (self.drawn_rad[self.members] ** 2).mean(axis=0)
        return Scatter(np.maximum(found.variance, stated), found.dof, found.prior_dof)
