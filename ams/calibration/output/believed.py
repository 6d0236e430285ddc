"""One output as its tests look at it: solved anew at the rows that are believed, less what is told already."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import SharedTests, axis_tests, shared_tests
from ams.analysis.diagnostics.beliefs import AxisTests, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.drift_course import LikeliestCourse
from ams.analysis.diagnostics.over_time.wander import beside_wander
from ams.analysis.diagnostics.sensed_force import Accelerometer
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import BoolArray, FloatArray
from ams.calibration.solving.columns import SolvedColumns, plots_of, solve_linearised
from ams.inputs.request import select_rows
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.solve.layout import layout_of
from ams.solve.linearised import linearise
from ams.solve.replicated import replicated_sums


@dataclass(frozen=True)
class Believed:
    """One output as the tests look at it, of which what is convicted is taken out."""

    evidence: Evidence
    shared: SharedTests
    solved: SolvedColumns
    index: int
    """Of the output in all of these."""
    outputs: FloatArray
    """(N, m)"""
    rows: Observations
    table: TableUncertainty | None
    errors: Sequence[SharedError]
    """Of certificates, that all rows share."""
    taken: FloatArray
    """(N, c) columns that the departures said how much to take of, which counts as known where the points are judged.
    """
    course: FloatArray
    """(N,) what of the output was taken out as a drift or the temperature's: the result itself is told with it."""
    readings: FloatArray
    """(N,) the output as it was read, nothing taken out."""

    def without(self, columns: FloatArray, beside: FloatArray | None = None) -> "Believed":
        """Return the output less what (N, c) columns explain of it, beside the effects of points; solved anew.

        ``beside``: (N, d) others that stay in it.
        """
        without = replace(self, taken=np.hstack([self.taken, columns]))
        return without.less(self.part_of(columns, beside))

    def part_of(self, columns: FloatArray, beside: FloatArray | None = None) -> FloatArray:
        """Return (N,) what (N, c) columns explain of the output, beside the effects of points and (N, d) others."""
        return self.evidence.part_of(self.index, columns, beside)

    def without_course(self, course: LikeliestCourse) -> "Believed":
        """Return the same of a course through the run, which :meth:`with_course` puts back."""
        taken = self.part_of(course.columns)
        followed = replace(self, course=self.course + taken)
        if course.is_of_temperature:  # the points are asked for it by itself
            return followed.less(taken)
        return followed.without(course.columns)

    def with_course(self) -> "Believed":
        """Return the output with the course that it has."""
        return self.less(-self.course) if self.course.any() else self

    def beside(self, columns: FloatArray, sizes: FloatArray) -> "Believed":
        """Return the output less (N, c) columns of (c,) estimated sizes, beside which the points are judged."""
        return replace(self, taken=np.hstack([self.taken, columns])).less(columns @ sizes)

    def less(self, taken: FloatArray) -> "Believed":
        """Return the output less (N,) something."""
        return self.of(np.ones(self.rows.rows, dtype=bool), taken)

    @property
    def accelerometer(self) -> Accelerometer | None:
        """What the model is built on; None where that is another sensor."""
        return accelerometer_base(self.solved.problem.models[self.index])

    def of(self, kept: BoolArray, less: FloatArray | float) -> "Believed":
        """Return one output at some rows, and less something, solved as the whole was."""
        rows, output = select_rows(self.rows, kept), (self.outputs[:, self.index] - less)[kept]
        model, layout = self.solved.problem.models[self.index], layout_of(rows)
        sampled = self.solved.problem.sampled[self.index : self.index + 1]
        problem = linearise([model], rows, layout, output[:, None], None, sampled)
        plots = plots_of(model, rows, layout)
        solved = solve_linearised(problem, layout, plots, self.table, self.errors)
        evidence = evidence_of(solved, rows)
        taken, course, readings = self.taken[kept], self.course[kept], self.readings[kept]
        seen = replace(self, evidence=evidence, shared=shared_tests(evidence), solved=solved, index=0)
        return replace(seen, outputs=output[:, None], rows=rows, taken=taken, course=course, readings=readings)

    def tested(self, made: Mapping[str, BeliefTest], limit: TableLimit | None, family: int) -> AxisTests:
        """Return all tests, those of what is taken out as they were ``made``."""
        given = self._taken_from_points()
        tests = axis_tests(self.evidence, self.shared, self.index, self.readings, made, limit, family, given)
        return beside_wander(self.evidence, self.index, tests, frozenset(made))

    def _taken_from_points(self) -> FloatArray:
        """Return (K, c) what the points have of what is taken out, the drift of the replications apart as theirs is."""
        layout, sums = self.evidence.layout, self.evidence.sums
        if self.taken.shape[1] == 0 or sums is None or sums.is_balanced:
            return layout.mean_by_point(self.taken)
        form = self.solved.problem.form
        taken = replicated_sums(form, layout, self.taken)
        return taken.point_effects + layout.mean_by_point(form.fitted(taken.pooled))


def evidence_of(solved: SolvedColumns, rows: Observations) -> Evidence:
    """Return what the tests look at."""
    problem, layout = solved.problem, solved.layout
    form, alone, ordinary = problem.form, problem.alone, solved.mixed.ordinary
    fitted = form.fitted(ordinary)
    return Evidence(
        rows=rows,
        layout=layout,
        models=problem.models,
        basis=problem.basis_at_points(layout),
        left=problem.outputs - fitted,
        fitted=fitted,
        primary=solved.primary,
        alone=ordinary[: alone.basis.shape[1]],
        common=[solved.at_points(blocks) for blocks in solved.common],
        sums=solved.mixed.sums,
        replication=solved.replication,
    )
