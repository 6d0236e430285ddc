"""What the outputs of a package have in common by its cause: told together where no axis tells it alone.

The heat of a motor after a move of its axis reaches every output, and sensors of one construction have one kind of
asymmetry and bend one way over temperature; of which size and sign is each sensor's own. The chances of the outputs,
independent of one another, are joined as Lancaster (1961) has it: each as the χ² of so many degrees of freedom that it
belongs to, whose sum is tested. What a single output shows by itself is told of it already, and is not joined.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import AFTER_MOVES, COLUMNS, CURVATURE, LAG, AxisTests, BeliefTest
from ams.analysis.diagnostics.replication_scatter import is_unsteady
from ams.analysis.diagnostics.size_words import Scale
from ams.statistics.distributions import chi_square_tail, chi_square_upper_quantile
from ams.statistics.intervals import t_quantile

_BENDS: Final = ("K3", "K0'")
"""So nearly collinear that the axes may show either of them for the other."""
_COMMON: Final[Mapping[str, tuple[str, ...]]] = {
    AFTER_MOVES: (AFTER_MOVES,), **dict.fromkeys(_BENDS, _BENDS), CURVATURE: (CURVATURE, LAG),
}  # fmt: skip
"""Tests of what has a common cause, to those that tell of it where one axis does."""
_OF_POINTS: Final = tuple(column.name for column in COLUMNS)
_DOF: Final = {CURVATURE: 2.0}
"""Numbers that a test asks of each axis, where it is not one: a curvature those of offset and sensitivity."""
_FEWEST: Final = 2
"""Outputs."""
_SHOWS: Final = 0.05
"""Chance of as much by itself: the axes below are told of, and their sizes are larger than their ±."""


@dataclass(frozen=True)
class AxisShown:
    """One output of a package, and what its tests show."""

    axis: str
    tests: AxisTests
    scale: Scale


class _Joined(NamedTuple):
    name: str
    p_value: float
    axes: int


def judge_common_cause(package: Sequence[AxisShown]) -> Sequence[BeliefTest | None]:
    """Return, of each output of a package, the test of what all show together; None of those that do not show it.

    Nothing is joined where an output shows the same by itself, or where its dwells plainly know of each other or drift:
    the means of the points scatter by more there than they seem to.
    """
    nothing = [None] * len(package)
    if len(package) < _FEWEST:
        return nothing
    best = min(_joined(tuple(_COMMON), package), key=lambda found: found.p_value, default=None)
    if best is None or not best.p_value <= best.axes * package[0].tests.level / MOST_TESTS:
        return nothing
    if any(shown.tests.is_significant.get(name) for name in _COMMON[best.name] for shown in package):
        return nothing
    if any(_is_unsteady(shown.tests) for shown in package):
        return nothing
    if best.name in _OF_POINTS and best.p_value > min(found.p_value for found in _joined(_OF_POINTS, package)):
        return nothing
    said = _of_each(best.name, package)
    return [
        test._replace(p_value=best.p_value, axes=best.axes, in_package=said)
        if (test := shown.tests.tests.get(best.name)) is not None and test.p_value <= _SHOWS
        else None
        for shown in package
    ]


def _joined(names: Sequence[str], package: Sequence[AxisShown]) -> list[_Joined]:
    """Return the chances of what the outputs show together, by name, where two of them or more tell anything."""
    tests = [[shown.tests.tests.get(name) for shown in package] for name in names]
    chances = np.array([[np.nan if test is None else test.p_value for test in of_name] for of_name in tests])
    dof, is_made = np.array([_DOF.get(name, 1.0) for name in names]), np.isfinite(chances)
    axes = is_made.sum(axis=1)
    squares = chi_square_upper_quantile(np.where(is_made, chances, 1.0), dof[:, None]).sum(axis=1)
    p_values = chi_square_tail(squares, dof * np.maximum(axes, 1))
    found = zip(names, p_values.tolist(), axes.tolist(), strict=True)
    return [_Joined(*each) for each in found if each[2] >= _FEWEST]


def _is_unsteady(tests: AxisTests) -> bool:
    """Return whether dwells know of each other or something drifts, beside what repeats in every replication."""
    others = (test for test in tests.tests.values() if test.name not in _OF_POINTS)
    return is_unsteady(others, tests.level / MOST_TESTS)


def _of_each(name: str, package: Sequence[AxisShown]) -> str:
    """Return how large it is of every axis, in words: first of those that show it."""
    made = [(shown, test) for shown in package if (test := shown.tests.tests.get(name)) is not None]
    by_whether = ([each for each in made if (each[1].p_value <= _SHOWS) is is_shown] for is_shown in (True, False))
    shown, others = (", ".join(f"{each.axis} {_size(test, each.scale)}" for each, test in part) for part in by_whether)
    return f"{shown}; not shown by {others}" if others else shown


def _size(test: BeliefTest, scale: Scale) -> str:
    if not isfinite(test.uncertainty):
        return scale.words(test.size)
    return scale.within(test.size, float(t_quantile(0.95, test.dof)) * test.uncertainty)
