"""Whether a package of gyros sat askew otherwise at every position in which it turned, as its outputs show it together.

A seat that is wrong by an angle is one error of its position: at every rate there it adds to an output what turns with
the rate. Taken as an error of each point it would shrink with the number of rates. What the residuals of the points
have of it, across the axis that turned, is held against the scatter between replications, all outputs together; how
far the seats are off is one standard deviation of them all, and it widens the uncertainties by position, also of
positions whose own seat the sensitivities absorb. With few positions little is known of that standard deviation:
Student's factor at as many degrees of freedom as it rests on stands in it. Source: GUM G.3; MATH 5.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.arrays import FloatArray
from ams.calibration.output.diagnosis import Diagnosis
from ams.calibration.solving.columns import SolvedColumns
from ams.findings import Finding
from ams.inputs.shared_errors import SHOWN_BY_ROWS, SharedError, shared_columns
from ams.models.model import Stimulus
from ams.rounding import significant
from ams.solve.linear_form import orthogonal
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

ASKEW_SEATS: Final = "seats of the positions"
_COUNTED: Final = 0.1
"""The chance of residuals that follow the rates of a position as plainly by noise alone, below which they count."""
_ROUNDING: Final = 1e-9
"""Of the largest share: less is rounding."""
_ABSORBED: Final = 1e-6
"""Of a pattern: what sensitivities leave of a lone position is rounding, and no seat shows in it."""
_FEWEST: Final = 2
"""Replications: one has no scatter to hold against."""


@dataclass(frozen=True)
class AskewSeats:
    """How far the seats of a package are off, of all positions together."""

    p_value: float
    sd_rad: float
    """Standard deviation about each axis across the one that turned."""
    freedom: float
    """Degrees of freedom that it rests on."""

    @property
    def counted(self) -> SharedError:
        """What is in the uncertainties: a seat of each position, as wide as few positions ask for."""
        few = float(t_quantile(0.95, self.freedom) / t_quantile(0.95, np.inf))
        stated = f"u {in_arcsec(few * self.sd_rad):.3g}″ about each axis, {SHOWN_BY_ROWS}: all positions together"
        return SharedError(ASKEW_SEATS, "seat", few * self.sd_rad, stated=stated, columns=(0, 1, 2), is_weighed=False)

    @property
    def finding(self) -> Finding:
        """What is said of it."""
        size = f"{significant(in_arcsec(self.sd_rad))}″"
        fact = (
            f"the package sat askew otherwise at every position in which it turned, by {size} (standard deviation "
            "about each axis), or the axis that turned did: what the outputs are off by follows the rates of a "
            "position, all outputs together; as much is in the uncertainties, as one error of each position"
        )
        what_to_do = "look after the seats of the fixture and what clamps the package, and measure again"
        details: dict[str, float | str | None] = {"test": ASKEW_SEATS, "seats_arcsec": in_arcsec(self.sd_rad)}
        return Finding("table-rotation", fact, True, self.p_value, (), details, what_to_do=what_to_do)


def with_seats(found: Sequence[Sequence[Diagnosis]], seats: AskewSeats, family: int) -> list[list[Diagnosis]]:
    """Return the findings of the outputs of a package with what is said of its seats, where that is significant."""
    if seats.p_value > sum(map(len, found)) * LEVEL / family / MOST_TESTS:
        return [list(group) for group in found]
    return [[replace(axis, findings=(*axis.findings, seats.finding)) for axis in group] for group in found]


def judge_seats(
    outputs: Sequence[tuple[SolvedColumns, int]], rows: Stimulus, shared: Sequence[SharedError]
) -> AskewSeats | None:
    """Return how far the seats of a package of gyros are off; None where nothing shows it, or no seat can show.

    ``rows``: those of the solution. ``shared``: its errors; directions that are declared are no news.
    """
    shown = [found for solved, row in outputs if (found := _shown(solved, row, rows)) is not None]
    if not shown:
        return None
    scores = np.asarray(sum(score for score, _, _ in shown))
    values, vectors = np.linalg.eigh(np.asarray(sum(information for _, information, _ in shown)))
    is_seen = values > _ROUNDING * values[-1]
    if not values[-1] > 0.0:
        return None
    seen, along = values[is_seen], vectors[:, is_seen].T @ scores
    square, number, dof = float(np.sum(along**2 / seen)), float(seen.size), sum(dof for *_, dof in shown)
    declared = [error.standard_uncertainty for error in shared if error.effect == "spin-direction"]
    expected = number + max(declared, default=0.0) ** 2 * float(seen.sum())
    p_value = float(f_tail(square / expected, number, dof))
    if not (p_value <= _COUNTED and square > number):
        return None
    sd_rad = float(np.sqrt((square - number) / seen.sum()))
    return AskewSeats(p_value, sd_rad, float(seen.sum() ** 2 / np.sum(seen**2)))


def _shown(solved: SolvedColumns, row: int, rows: Stimulus) -> tuple[FloatArray, FloatArray, float] | None:
    """Return what an output shows: (q) scores by radian of each seat, their (q, q) information, degrees of freedom."""
    layout, model = solved.layout, solved.problem.models[row]
    variance = float(solved.mixed.precision_variance[row])
    if layout.replications < _FEWEST or solved.mixed.sums is None or not variance > 0.0:
        return None
    seat = SharedError(ASKEW_SEATS, "seat", 1.0, columns=(0, 1, 2))
    columns = shared_columns([seat], model, solved.primary[row], rows).get(ASKEW_SEATS)
    if columns is None:
        return None
    taken, _ = orthogonal(layout.mean_by_point(solved.problem.form.basis))
    at_points = layout.mean_by_point(np.column_stack([columns, solved.problem.outputs[:, row]]))
    left = at_points - taken @ (taken.T @ at_points)
    whole, kept = (np.linalg.norm(each[:, :-1], axis=0) for each in (at_points, left))
    pattern, residual = left[:, :-1] * (kept > _ABSORBED * whole), left[:, -1]
    of_means = variance / layout.typical_readings
    return pattern.T @ residual / of_means, pattern.T @ pattern / of_means, float(solved.mixed.sums.dof_precision)
