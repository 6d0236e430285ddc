"""What all outputs of a package say of the table's declared limit, less what is told to have changed or drifted.

A change in mid-run is taken out, and so is a plain drift. Points that come in the same order in every replication have
a part of the drift in their means, the same in each: a gain that drifts while pitch goes from one end to the other is a
curve of pitch, which would pass for errors of the table. That part is nowhere among the differences between
replications, so how it went inside of them is taken from its course over the run. It may have gone otherwise, as where
it changed in the breaks alone: against the limit speaks only what stands with the drift in the outputs and without it.
Outputs that no index errors explain as they were read are judged without it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.drift_course import likeliest_course
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.time_order import hours, slope_between
from ams.arrays import FloatArray
from ams.calibration.output.believed import evidence_of
from ams.calibration.solving.columns import SolvedColumns
from ams.calibration.steps.step_columns import part_of
from ams.calibration.steps.steps_of_output import NO_STEPS, StepsOfOutput
from ams.calibration.together.table_limit import judge_table
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations

SolvedGroup = tuple[Sequence[str], SolvedColumns, FloatArray]
"""Labels of axes that were solved together, what was solved, and (N, m) their outputs."""
Solve = Callable[[Observations], Sequence[SolvedGroup]]


def limits_of_package(
    rows: Observations,
    groups: Sequence[SolvedGroup],
    judged: Sequence[Evidence | None],
    steps: Mapping[str, StepsOfOutput],
    table: TableUncertainty | None,
    family: int,
    solve: Solve,
) -> Sequence[TableLimit | None]:
    """Return what is said to each output, group by group, as ``judge_table`` has it.

    ``judged``: what the tests look at, of each group. ``steps``: by axis. ``family``: axes of the run. ``solve``: the
    same groups at other outputs.
    """
    if table is None:
        return judge_table(_indexed(groups), rows, table)
    changed = _changes(groups, judged, steps)
    if changed:
        rows = _less(rows, changed)
        groups = solve(rows)
    as_read = judge_table(_indexed(groups), rows, table)
    if not any(limit is not None and _is_in_doubt(limit) for limit in as_read):
        return as_read
    seen = [evidence_of(solved, rows) for _, solved, _ in groups] if changed else judged
    drifted = _drifts(groups, seen, LEVEL / family / MOST_TESTS)
    if not drifted:
        return as_read
    rows = _less(rows, drifted)
    without = judge_table(_indexed(solve(rows)), rows, table)
    return [_standing(*pair) for pair in zip(as_read, without, strict=True)]


def _is_in_doubt(limit: TableLimit) -> bool:
    return limit.p_value <= LEVEL or not limit.is_explained


def _standing(as_read: TableLimit | None, without: TableLimit | None) -> TableLimit | None:
    """Return what stands with the drift in the output and without it; without, where no table does what was read."""
    if as_read is None or without is None or not as_read.is_explained:
        return without
    return max(as_read, without, key=lambda limit: limit.p_value)


def _indexed(groups: Sequence[SolvedGroup]) -> list[tuple[SolvedColumns, Sequence[int]]]:
    return [(solved, range(len(group))) for group, solved, _ in groups]


def _less(rows: Observations, parts: Mapping[str, FloatArray]) -> Observations:
    return replace(rows, outputs={name: values - parts.get(name, 0.0) for name, values in rows.outputs.items()})


def _changes(
    groups: Sequence[SolvedGroup], judged: Sequence[Evidence | None], steps: Mapping[str, StepsOfOutput]
) -> Mapping[str, FloatArray]:
    """Return by axis (N,) what is told to have changed in mid-run."""
    return {
        label: part_of(evidence, index, found.during, found.drifting)
        for (group, *_), evidence in zip(groups, judged, strict=True)
        for index, label in enumerate(group)
        if evidence is not None and (found := steps.get(label, NO_STEPS)).during
    }


def _drifts(groups: Sequence[SolvedGroup], seen: Sequence[Evidence | None], level: float) -> Mapping[str, FloatArray]:
    """Return by axis (N,) the likeliest course, a drift's or the temperature's, of those that plainly drift."""
    drifting = [
        (label, evidence, index)
        for (group, *_), evidence in zip(groups, seen, strict=True)
        for index, label in enumerate(group)
        if evidence is not None and _drifts_plainly(evidence, index, level)
    ]
    courses = [(*output, likeliest_course(*output[1:])) for output in drifting]
    return {
        label: evidence.part_of(index, course.columns)
        for label, evidence, index, course in courses
        if course is not None
    }


def _drifts_plainly(evidence: Evidence, output: int, level: float) -> bool:
    """Return whether a parameter differs between the replications, or the output with time, whatever else does."""
    time = hours(evidence)
    chances = [] if time is None else [slope_between(evidence, time).p_value[output]]
    if evidence.replication is not None:
        chances += [test.p_value[output] for test in evidence.replication.drift.values()]
    return any(float(chance) <= level for chance in chances)
