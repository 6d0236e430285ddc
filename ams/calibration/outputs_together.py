"""The findings of all outputs of a package: each by itself, and again where they show something together.

Play of the table, which turns all of them, is looked for first, and is in no test of a sensor.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import AT_A_LOCATION, LEVEL, AxisTests, BeliefTest
from ams.analysis.diagnostics.facts import CONTAINED
from ams.calibration.output.diagnosis import Diagnosis, diagnose, scale_of, sensitivity_of
from ams.calibration.package_play import Group, outputs_of, shown_by_package, with_evidence, with_shown
from ams.calibration.together.common_cause import AxisShown, judge_common_cause
from ams.calibration.together.common_gain import OutputOfPackage, gain_finding
from ams.calibration.together.memory import judge_memory
from ams.calibration.together.package_wide import PackageWide
from ams.calibration.together.tilting_base import BaseTilt, judge_base, tilt_finding
from ams.finding_kinds import FindingKind
from ams.findings import Finding

_LIKE_A_GAIN: Final[frozenset[FindingKind]] = frozenset(
    {
        "table-rotation",
        "meter-gain",
        "meter-offset",
        "sensor-change",
        "drift",
        "temperature-residual",
        "autocorrelation",
    }
)
"""Of what is told as a gain already, or passes for one."""

_AS_THE_TILT: Final = "a base that tilts does that, and what of it the stated uncertainties hold is said of the tilt"
_BESIDE_IT: Final[frozenset[FindingKind]] = frozenset({"lack-of-fit", "quadratic", "cross-coupling", "cubic"})
"""Of what the points show by the force, or the table at its indices: what a package shows is shown beside it."""


def diagnose_together(groups: Sequence[Group]) -> list[list[Diagnosis]]:
    """Return the findings of every axis of the groups of one package; again, where they show something together."""
    groups = [with_evidence(group) for group in groups]
    plays, wide = shown_by_package([output for group in groups for output in outputs_of(group)])
    groups = [with_shown(group, plays, None) for group in groups]
    found = [diagnose(*group) for group in groups]
    if wide is not None and _is_plainest(wide, [axis for group in found for axis in group]):
        groups = [with_shown(group, (), wide) for group in groups]
        found = [diagnose(*group) for group in groups]
    shown = iter(_shown_together([axis for group in found for axis in group]))
    found = [_again(group, axes, [next(shown) for _ in axes]) for group, axes in zip(groups, found, strict=True)]
    with_gain = iter(_with_gain([axis for group in found for axis in group]))
    return [[next(with_gain) for _ in axes] for axes in found]


def tilt_of_base(groups: Sequence[Group], found: Sequence[Sequence[Diagnosis]]) -> BaseTilt | None:
    """Return how the base tilted between the replications of a package.

    None where another turn is told already, or something changed in mid-run.
    """
    every = (said for axes in found for axis in axes for said in axis.findings)
    if any(said.kind == "table-rotation" and said.is_significant for said in every):
        return None
    outputs = [output for group in groups for output in outputs_of(group)]
    if any(under.steps_of(index).during for _, under, _, index in outputs):
        return None
    return judge_base([(evidence, index) for _, _, evidence, index in outputs if evidence is not None])


def with_tilt(
    found: Sequence[Sequence[Diagnosis]], tilt: BaseTilt, family: int, *, is_counted: bool
) -> list[list[Diagnosis]]:
    """Return the findings of the outputs of a package with what is said of the base, where that is significant."""
    axes = sum(map(len, found))
    if not tilt.is_of_several or tilt.p_value > axes * LEVEL / family / MOST_TESTS:
        return [list(group) for group in found]
    finding = tilt_finding(tilt, is_counted=is_counted)
    return [[replace(axis, findings=(*map(_of_the_tilt, axis.findings), finding)) for axis in group] for group in found]


def _of_the_tilt(said: Finding) -> Finding:
    """Return a change between the replications as the tilt's doing: what holds of the tilt is said once, with it."""
    if said.kind != "drift" or not said.fact.endswith(CONTAINED):
        return said
    return replace(said, fact=f"{said.fact.removesuffix(CONTAINED)}{_AS_THE_TILT}")


def _is_plainest(wide: PackageWide, package: Sequence[Diagnosis]) -> bool:
    """Return whether nothing else that is told, but what it is tested beside, is as plain.

    A memory as it is beside no other: where one was taken out that is none, another makes up for it.
    """
    others = (
        memory_of.get(name, test).p_value
        for axis in package
        for memory_of in ({memory.name: memory for memory in axis.tests.memories},)
        for name, test in axis.tests.tests.items()
        if axis.tests.is_significant.get(name) and (test.kind not in _BESIDE_IT or name == AT_A_LOCATION)
    )
    return wide.test.p_value < min(others, default=1.0)


def _shown_together(package: Sequence[Diagnosis]) -> list[BeliefTest | None]:
    """Return of each output of a package what they show together, as large as it is of this one; None: it does not."""
    memory = judge_memory([_judged(axis) for axis in package])
    if memory is not None:
        return [_as_large_as(memory, sensitivity_of(axis) or 0.0) for axis in package]
    return list(judge_common_cause([_shown(axis) for axis in package]))


def _with_gain(package: Sequence[Diagnosis]) -> list[Diagnosis]:
    """Return the findings of the outputs of a package with what is said of a gain that all of them show."""
    outputs = [OutputOfPackage(_axis_of(axis), axis.solved, axis.row) for axis in package]
    finding = gain_finding(outputs, len(outputs) * package[0].tests.level / MOST_TESTS)
    if finding is None or any(_is_like_a_gain(said) for axis in package for said in axis.findings):
        return list(package)
    return [replace(axis, findings=(*axis.findings, finding)) for axis in package]


def _is_like_a_gain(said: Finding) -> bool:
    return said.is_significant and said.kind in _LIKE_A_GAIN


def _axis_of(axis: Diagnosis) -> str:
    return axis.solved.problem.models[axis.row].nominal_axis


def _judged(axis: Diagnosis) -> tuple[AxisTests, float | None]:
    return axis.tests, sensitivity_of(axis)


def _shown(axis: Diagnosis) -> AxisShown:
    return AxisShown(_axis_of(axis), axis.tests, scale_of(axis.solved, axis.row))


def _again(group: Group, found: list[Diagnosis], shown: Sequence[BeliefTest | None]) -> list[Diagnosis]:
    solved, under, evidence = group
    return diagnose(solved, replace(under, together=shown), evidence) if any(shown) else found


def _as_large_as(memory: BeliefTest, k: float) -> BeliefTest:
    """Return what is known per g of force as an output of k volts a g has it."""
    return memory._replace(size=k * memory.size, uncertainty=k * memory.uncertainty)
