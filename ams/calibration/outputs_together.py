"""The findings of all outputs of a package: each by itself, and again where they show something together."""

from collections.abc import Sequence
from dataclasses import replace

from ams.analysis.diagnostics.beliefs import AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.calibration.columns import SolvedColumns
from ams.calibration.common_cause import AxisShown, judge_common_cause
from ams.calibration.diagnosis import Circumstances, Diagnosis, diagnose, scale_of, sensitivity_of
from ams.calibration.memory import judge_memory

Group = tuple[SolvedColumns, Circumstances, Evidence | None]
"""Axes that were solved as one, what they were solved under, and what the tests look at."""


def diagnose_together(groups: Sequence[Group]) -> list[list[Diagnosis]]:
    """Return the findings of every axis of the groups of one package; again, where they show something together."""
    found = [diagnose(*group) for group in groups]
    shown = _shown_together([axis for group in found for axis in group])
    if not any(shown):
        return found
    of_axes = iter(shown)
    return [
        _again(group, axes, [next(of_axes) for _ in axes]) for group, axes in zip(groups, found, strict=True)
    ]  # fmt: skip


def diagnose_packages(axes: Sequence[Group]) -> list[list[Diagnosis]]:
    """Return the same of many packages that were measured at the same rows, axis by axis: one column a package."""
    found = [diagnose(*axis) for axis in axes]
    by_package = [_shown_together(package) for package in zip(*found, strict=True)]
    by_axis = list(zip(*by_package, strict=True))
    return [_again(axis, of_axis, shown) for axis, of_axis, shown in zip(axes, found, by_axis, strict=True)]


def _shown_together(package: Sequence[Diagnosis]) -> list[BeliefTest | None]:
    """Return of each output of a package what they show together, as large as it is of this one; None: it does not."""
    memory = judge_memory([_judged(axis) for axis in package])
    if memory is not None:
        return [_as_large_as(memory, sensitivity_of(axis) or 0.0) for axis in package]
    return list(judge_common_cause([_shown(axis) for axis in package]))


def _judged(axis: Diagnosis) -> tuple[AxisTests, float | None]:
    return axis.tests, sensitivity_of(axis)


def _shown(axis: Diagnosis) -> AxisShown:
    return AxisShown(axis.solved.problem.models[axis.row].nominal_axis, axis.tests, scale_of(axis.solved, axis.row))


def _again(group: Group, found: list[Diagnosis], shown: Sequence[BeliefTest | None]) -> list[Diagnosis]:
    solved, under, evidence = group
    return diagnose(solved, replace(under, together=shown), evidence) if any(shown) else found


def _as_large_as(memory: BeliefTest, k: float) -> BeliefTest:
    """Return what is known per g of force as an output of k volts a g has it."""
    return replace(memory, size=k * memory.size, uncertainty=k * memory.uncertainty)
