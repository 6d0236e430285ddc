"""Whether the outputs of a package remember the attitudes before, all of them together.

Sensors of one make creep alike, against their own sensitivity: what three outputs show together is told at half the
size that one of them needs, as the size that they have together. Outputs of which one remembers and another does not
have none.
"""

from collections.abc import Sequence
from typing import Final

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LIKE_A_MEMORY, MEMORIES, AxisTests, BeliefTest
from ams.analysis.diagnostics.over_time.memories import with_those_that_fit_as_well
from ams.analysis.diagnostics.over_time.settling import Estimate, joined, of_estimate
from ams.statistics.distributions import f_tail

_FEWEST: Final = 2
"""Outputs."""
_UNLIKE: Final = 1e-3
"""Chance of outputs that differ as much and have one size together."""


def judge_memory(axes: Sequence[tuple[AxisTests, float | None]]) -> BeliefTest | None:
    """Return the memory that the outputs of a package show together; None where none is plain, or all are told by it.

    ``axes``: the tests of each, and its sensitivity, V/g.
    """
    seen = [(tests, k) for tests, k in axes if k is not None and tests.grid is not None and MEMORIES[0] in tests.tests]
    if len(seen) < _FEWEST:
        return None
    together = [test for name in MEMORIES if (test := _together(name, seen)) is not None]
    if not together:
        return None
    best = min(together, key=lambda test: test.p_value)
    if not best.p_value <= best.axes * seen[0][0].level / MOST_TESTS:
        return None
    others = [
        test.p_value for tests, _ in seen for test in tests.tests.values()
        if test.name in LIKE_A_MEMORY and test.name not in MEMORIES
    ]  # fmt: skip
    is_said = all(any(tests.is_significant.get(name) for name in MEMORIES) for tests, _ in seen)
    is_plainest = best.p_value <= min(others, default=1.0)
    return with_those_that_fit_as_well(best, together) if is_plainest and not is_said else None


def _together(name: str, seen: Sequence[tuple[AxisTests, float]]) -> BeliefTest | None:
    found = [(test, k) for tests, k in seen for test in tests.memories if test.name == name and test.uncertainty > 0.0]
    if len(found) < _FEWEST:
        return None
    estimates = [Estimate(each.size / k, each.uncertainty / k, each.dof) for each, k in found]
    whole, freedom = joined(estimates), len(found) - 1
    apart = sum(((each.size - whole.size) / each.uncertainty) ** 2 for each in estimates)
    if float(f_tail(apart / freedom, float(freedom), min(each.dof for each in estimates))) < _UNLIKE:
        return None
    return of_estimate(BeliefTest(name, "autocorrelation", 1.0, unit="V/g", axes=len(found), is_held=False), whole)
