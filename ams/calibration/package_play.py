"""The play of the table as the outputs of a package show it, what changed in mid-run taken out of each of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS, shared_tests
from ams.analysis.diagnostics.beliefs import LEVEL
from ams.analysis.diagnostics.evidence import Evidence
from ams.calibration.output.believed import Believed, evidence_of
from ams.calibration.output.circumstances import Circumstances
from ams.calibration.solving.columns import SolvedColumns
from ams.calibration.steps.step_columns import beside_of, step_columns
from ams.calibration.together.attitude_turn import judge_attitude_turn
from ams.calibration.together.backlash import judge_play
from ams.calibration.together.backlash_found import Play
from ams.calibration.together.in_step import judge_in_step
from ams.calibration.together.package_wide import PackageWide
from ams.calibration.together.roll_turn import judge_roll_turn

Group = tuple[SolvedColumns, Circumstances, Evidence | None]
"""Axes that were solved as one, what they were solved under, and what the tests look at."""
OutputOfGroup = tuple[SolvedColumns, Circumstances, Evidence | None, int]
"""One of them."""


def with_evidence(group: Group) -> Group:
    """Return a group with what the tests look at; without it where rows are weighted, of which nothing is tested."""
    solved, under, evidence = group
    if evidence is not None or solved.problem.form.weights is not None:
        return group
    return solved, under, evidence_of(solved, under.rows)


def outputs_of(group: Group) -> list[OutputOfGroup]:
    """Return the outputs of a group."""
    return [(*group, index) for index in range(len(group[0].problem.models))]


def shown_by_package(package: Sequence[OutputOfGroup]) -> tuple[Sequence[Play], PackageWide | None]:
    """Return the play of the table, and what else the outputs of a package show together: the plainest of it.

    Each at the share of a test of every output, and neither beside the other.
    """
    _, under, evidence, _ = package[0]
    if evidence is None:
        return (), None
    level = len(package) * LEVEL / under.family / MOST_TESTS
    outputs = [_without_steps(*output) for output in package]
    turn = judge_roll_turn(outputs, level) or judge_attitude_turn(outputs, level)
    judged = (turn, judge_in_step(outputs, level))
    wide = min((found for found in judged if found is not None), key=lambda found: found.p_value, default=None)
    return judge_play(outputs, level, under.single_approach), wide


def with_shown(group: Group, plays: Sequence[Play], wide: PackageWide | None) -> Group:
    """Return a group of which is known what its package shows together."""
    solved, under, evidence = group
    if not plays and not under.plays and wide is None:
        return group
    return solved, replace(under, plays=[plays] * len(solved.problem.models), package_wide=wide), evidence


def _without_steps(
    solved: SolvedColumns, under: Circumstances, evidence: Evidence | None, index: int
) -> tuple[Evidence, int]:
    """Return what the tests look at without what changed in mid-run, and where the output is in it."""
    assert evidence is not None, "rows of a package are weighted all or none"
    steps = under.steps_of(index)
    if not steps.during:
        return evidence, index
    nothing, still = np.zeros((under.rows.rows, 0)), np.zeros(under.rows.rows)
    given = (under.outputs, under.rows, under.table, under.shared)
    seen = Believed(evidence, shared_tests(evidence), solved, index, *given, nothing, still, under.outputs[:, index])
    columns, beside = step_columns(evidence, index, steps.during), beside_of(evidence, index, steps.drifting)
    return seen.without(columns, beside).evidence, 0
