"""Whether the outputs of a package remember the attitudes before, all of them together.

Sensors of one make creep alike, against their own sensitivity: what three outputs show together is told at half the
size that one of them needs, as the size that they have together. Outputs of which one remembers and another does not
have none.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ams.analysis.diagnostics.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LIKE_A_MEMORY, MEMORIES, AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.memories import with_those_that_fit_as_well
from ams.analysis.diagnostics.settling import Estimate, joined, of_estimate
from ams.calibration.columns import SolvedColumns
from ams.calibration.diagnosis import Circumstances, Diagnosis, diagnose, sensitivity_of
from ams.statistics.distributions import f_tail

Group = tuple[SolvedColumns, Circumstances, Evidence | None]
"""Axes that were solved as one, what they were solved under, and what the tests look at."""
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


def diagnose_together(groups: Sequence[Group]) -> list[list[Diagnosis]]:
    """Return the findings of every axis of the groups of one package; again, where they show a memory together."""
    found = [diagnose(*group) for group in groups]
    memory = judge_memory([_judged(axis) for group in found for axis in group])
    if memory is None:
        return found
    return [_again(group, axes, [memory] * len(axes)) for group, axes in zip(groups, found, strict=True)]


def diagnose_packages(axes: Sequence[Group]) -> list[list[Diagnosis]]:
    """Return the same of many packages that were measured at the same rows, axis by axis: one column a package."""
    found = [diagnose(*axis) for axis in axes]
    memories = [judge_memory([_judged(axis) for axis in package]) for package in zip(*found, strict=True)]
    if not any(memories):
        return found
    return [_again(axis, of_axis, memories) for axis, of_axis in zip(axes, found, strict=True)]


def _judged(axis: Diagnosis) -> tuple[AxisTests, float | None]:
    return axis.tests, sensitivity_of(axis)


def _again(group: Group, found: Sequence[Diagnosis], memories: Sequence[BeliefTest | None]) -> list[Diagnosis]:
    solved, under, evidence = group
    pairs = zip(found, memories, strict=True)
    of_outputs = [
        None if memory is None else _as_large_as(memory, sensitivity_of(axis) or 0.0) for axis, memory in pairs
    ]
    return diagnose(solved, replace(under, memories=of_outputs), evidence)


def _as_large_as(memory: BeliefTest, k: float) -> BeliefTest:
    """Return what is known per g of force as an output of k volts a g has it."""
    return replace(memory, size=k * memory.size, uncertainty=k * memory.uncertainty)
