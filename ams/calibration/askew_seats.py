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
from ams.solve.seen_directions import seen_directions
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

ASKEW_SEATS: Final = "seats of the positions"
_COUNTED: Final = 0.1
"""The chance of residuals that follow the rates of a position as plainly by noise alone, below which they count."""
_LARGEST_RAD: Final = float(np.deg2rad(1.0))
"""Of a seat: what is clamped to a face does not sit askew by more; residuals that ask for it have another cause."""
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
    def is_of_seats(self) -> bool:
        """Whether a package can sit as far askew at all."""
        return self.sd_rad <= _LARGEST_RAD

    @property
    def counted(self) -> tuple[SharedError, ...]:
        """What is in the uncertainties: a seat of each position, as wide as few positions ask for; no more than one."""
        if not self.is_of_seats:
            return ()
        few = float(t_quantile(0.95, self.freedom) / t_quantile(0.95, np.inf))
        stated = f"u {in_arcsec(few * self.sd_rad):.3g}″ about each axis, {SHOWN_BY_ROWS}: all positions together"
        width_rad = few * self.sd_rad
        return (SharedError(ASKEW_SEATS, "seat", width_rad, stated=stated, columns=(0, 1, 2), is_weighed=False),)

    @property
    def finding(self) -> Finding:
        """What is said of it."""
        details: dict[str, float | str | None] = {"test": ASKEW_SEATS}
        follows = "what the outputs are off by follows the rates of a position, all outputs together"
        if not self.is_of_seats:
            fact = (
                f"{follows}, by more than a package can sit askew ({significant(np.rad2deg(self.sd_rad))}° about each "
                f"axis, largest {np.rad2deg(_LARGEST_RAD):g}°): rates or angles of a position are not those of the "
                "rows; it is in the uncertainties nowhere"
            )
            what_to_do = "look at signs and order of rates and angles, and at the rates that the table ran at"
            return Finding("table-rotation", fact, True, self.p_value, (), details, False, what_to_do=what_to_do)
        size = f"{significant(in_arcsec(self.sd_rad))}″"
        fact = (
            f"the package sat askew otherwise at every position in which it turned, by {size} (standard deviation "
            f"about each axis), or the axis that turned did: {follows}; as much is in the uncertainties, as one error "
            "of each position"
        )
        what_to_do = "look after the seats of the fixture and what clamps the package, and measure again"
        details["seats_arcsec"] = in_arcsec(self.sd_rad)
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
    scores, information, whole = (np.asarray(sum(each)) for each in list(zip(*shown, strict=True))[:3])
    directions = seen_directions(information, whole)
    if directions.shape[1] == 0:
        return None
    seats = directions.T @ information
    seen = np.linalg.eigvalsh(seats @ seats.T)
    square, number, dof = float(np.sum((directions.T @ scores) ** 2)), float(seen.size), sum(dof for *_, dof in shown)
    declared = [error.standard_uncertainty for error in shared if error.effect == "spin-direction"]
    expected = number + max(declared, default=0.0) ** 2 * float(seen.sum())
    p_value = float(f_tail(square / expected, number, dof))
    if not (p_value <= _COUNTED and square > number):
        return None
    sd_rad = float(np.sqrt((square - number) / seen.sum()))
    return AskewSeats(p_value, sd_rad, float(seen.sum() ** 2 / np.sum(seen**2)))


def _shown(solved: SolvedColumns, row: int, rows: Stimulus) -> tuple[FloatArray, FloatArray, FloatArray, float] | None:
    """Return what an output shows: (q) scores by radian of each seat, their (q, q) information, degrees of freedom.

    Third: (q) the information that each seat would have beside nothing.
    """
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
    pattern, residual, of_means = left[:, :-1], left[:, -1], variance / layout.typical_readings
    whole = (at_points[:, :-1] ** 2).sum(axis=0) / of_means
    information = pattern.T @ pattern / of_means
    return pattern.T @ residual / of_means, information, whole, float(solved.mixed.sums.dof_precision)
