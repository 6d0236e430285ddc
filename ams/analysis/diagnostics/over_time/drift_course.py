"""Which course through the run explains best what differs between the replications: a drift's, or the temperature's.

What is plain of either repeats in part in every replication, as the order of the points has it, and then looks like a
bend or a memory, and the one like the other. They are held against each other, and against a transient and memories
where the order differs, by their likelihood; the other tests are made on the output without the likeliest.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import log
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BY_REPLICATION, DRIFT_OF, OVER_TIME, AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.over_time.temperature import explained
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.analysis.diagnostics.time_order import LEAST_DOF, courses_of_drift, settling
from ams.arrays import FloatArray

PER_NUMBER: Final = 4.0
"""In twice the log likelihood, for every number that a course has to choose. By Akaike (1974) 2, by Schwarz (1978) 7
for a thousand dwells."""
_LEAST_REPLICATIONS: Final = 2
_LEVELS_COST: Final = 2
"""In numbers, at least: two levels have no more of them than an even drift, and are one with it where every replication
goes through the points alike."""
_NOTHING: Final = 1e-12
"""Of a share of the squares, so that its logarithm is finite."""


@dataclass(frozen=True)
class LikeliestCourse:
    """Of one output."""

    columns: FloatArray
    """(N, c)"""
    is_of_temperature: bool


def plain_courses(tests: AxisTests) -> dict[str, BeliefTest]:
    """Return by name the tests of a drift through the run, and of the temperature, convicted whatever others say."""
    level = tests.conviction_level
    return {
        name: test
        for name, test in tests.tests.items()
        if test.p_value <= level and (name in (OVER_TIME, BY_REPLICATION) or name.startswith(DRIFT_OF))
    }


def likeliest_course(evidence: Evidence, output: int) -> LikeliestCourse | None:
    """Return the likeliest course of a drift or of the temperature; None where something else is as likely."""
    if evidence.sums is None or evidence.grid.dof < LEAST_DOF or by_temperature.has_plateaus(evidence):
        return None
    unlikely = _unlikely(evidence, output)
    nothing = LikeliestCourse(np.zeros((evidence.layout.rows, 0)), is_of_temperature=False)
    tried = [(unlikely(columns, columns.shape[1]), nothing) for columns in _transients(evidence, output)]
    tried += [
        (unlikely(columns, columns.shape[1]), LikeliestCourse(columns, is_of_temperature=True))
        for columns in _of_temperature(evidence, output)
    ]
    tried += [
        (unlikely(columns, numbers), LikeliestCourse(columns, is_of_temperature=False))
        for columns, numbers in _of_drift(evidence, output)
    ]
    least, likeliest = min(tried, key=lambda course: course[0])
    return likeliest if least < 0.0 and likeliest.columns.shape[1] > 0 else None


def changes_between(evidence: Evidence, output: int) -> bool:
    """Return whether an output changed from one replication to the next and in none: no course through all is likelier.

    What it did so is in none of the replications, whatever the order of their points.
    """
    if evidence.layout.replications < _LEAST_REPLICATIONS or not evidence.precision_variance[output] > 0.0:
        return False
    unlikely = _unlikely(evidence, output)
    levels = unlikely(_levels(evidence), max(evidence.layout.replications - 1, _LEVELS_COST))
    return all(levels < unlikely(*course) for course in courses_of_drift(evidence.time_order))


def _unlikely(evidence: Evidence, output: int) -> Callable[[FloatArray, int], float]:
    """Return minus twice the log likelihood of (N, c) columns with so many numbers to choose, and what these cost."""
    y = evidence.departures[:, output]
    dof, whole = float(evidence.layout.rows - evidence.layout.points), float(y @ y)

    def unlikely(columns: FloatArray, numbers: int) -> float:
        left = 1.0 - explained(evidence.layout.about_points(columns), y)[0] / whole
        return dof * log(max(left, _NOTHING)) + PER_NUMBER * numbers

    return unlikely


def _levels(evidence: Evidence) -> FloatArray:
    """(N, n − 1) the rows of each replication but the first."""
    layout = evidence.layout
    return np.asarray(layout.replication[:, None] == np.arange(1, layout.replications), dtype=np.float64)


def _of_drift(evidence: Evidence, output: int) -> Iterator[tuple[FloatArray, int]]:
    """Yield (N, c) courses of the offset, and of offset and sensitivity, with how many numbers each has to choose."""
    layout, along = evidence.layout, evidence.sensed[:, [output]]
    for columns, numbers in (*courses_of_drift(evidence.time_order), (_levels(evidence), layout.replications - 1)):
        yield columns, numbers
        yield np.hstack([columns, columns * along]), 2 * numbers


def _of_temperature(evidence: Evidence, output: int) -> Iterator[FloatArray]:
    warmth = by_temperature.departure_degc(evidence)
    if warmth is not None:
        column = warmth[:, None]
        yield from (column, np.hstack([column, column * evidence.sensed[:, [output]]]))


def _transients(evidence: Evidence, output: int) -> Iterator[FloatArray]:
    """Yield what every replication does alike, as far as the order of the points tells it from them."""
    base = accelerometer_base(evidence.models[output])
    if evidence.order_repeats:
        return
    yield settling(evidence)[:, None]
    if base is not None:
        yield from previous_attitude.memories(evidence, base).T[:, :, None]
