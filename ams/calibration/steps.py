"""Whether something changed in the middle of a run, for good or for a while, and whose doing it is.

All outputs of a package that were seen at the same rows are looked at together: the likeliest slip of the table over
all of them, and the likeliest step of each by itself; each as one that stayed, and as one that came back. What is plain
enough to be convicted is named by the diagnosis that the engine makes of two visits
(:mod:`ams.surveillance.common_mode`), every attitude that was measured in it and outside being visited twice; it is
then taken out, and the search goes on.

A drift has a likeliest step, too. A change is told as one only where nothing else that the same pattern does, from
one part of a replication to the next, is of any size beside it, and where neither the recorded temperature nor, of two
or three replications, a level of each explains it as well.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL, SLIP, STEP, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.step_scan import (
    Change,
    Course,
    Scan,
    Watched,
    changes_of,
    force_along,
    located,
    scans_of_output,
    scans_of_table,
    slip_pattern,
)
from ams.analysis.diagnostics.temperature import explained, varies
from ams.analysis.diagnostics.tested_terms import linear_base
from ams.analysis.diagnostics.time_order import courses_of_drift, parts_of_replications
from ams.arrays import BoolArray, FloatArray
from ams.calibration import step_words
from ams.calibration.step_columns import LINEAR, Changed, moments_of, step_columns
from ams.calibration.steps_of_output import NO_STEPS, StepsOfOutput
from ams.findings import Finding, FindingKind
from ams.inputs.known_of_run import ProvedChange
from ams.solve.extension import angles_of_points
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_tail
from ams.surveillance.common_mode import judge_visits
from ams.surveillance.common_mode_columns import Visits, WatchedAxes
from ams.surveillance.common_mode_words import findings_of

_MOST: Final = 4
"""Changes looked for."""
_PARTS: Final = 4
"""Of a replication, each with a level of its own in what a change is held against."""
_PER_NUMBER: Final = 4.0
"""Of what a course explains, in variances of a dwell, for every number that it has to choose: the rest says which is
likelier. By Akaike (1974) 2, by Schwarz (1978) 7 for a thousand dwells."""
_FEW_REPLICATIONS: Final = 3
_FEW_OF_RETURN: Final = 5
"""Of so many, whose offsets are each what they are by chance, one stands by itself often enough."""
_CONTRADICTED: Final = 0.01
_LARGEST_REST: Final = 0.1
"""Of what a change explains: where the same pattern does more than this elsewhere, it is a drift."""
_KEPT: Final = 0.5
"""Of what a change explains: beside the recorded temperature, or a level of each of few replications."""
_TRIED: Final = 4.0
"""Changes for the table, and for each output: of two patterns, one that stayed and one that came back."""
_RETURNED: Final = 16.0
"""In variances of a dwell: what a return has to explain beyond a change that stayed; the likeliest of all places does
less by chance."""
_CLIPPED: Final = 5.0
_STRUCK: Final = 36.0
"""In squares of a standard deviation."""
_NOTHING: Final = 1e-9
_PACKAGE: Final = "the package"
_METER: Final = "the meter"


def judge_steps(
    seen: Sequence[tuple[Evidence, int]], family: int, changes: Sequence[ProvedChange] = ()
) -> list[StepsOfOutput]:
    """Return what changed between two dwells, for good or for a while, by the outputs of a package.

    They were seen at the same rows.

    ``family``: axes of the run. ``changes``: of table or meter, proved by others; what they do is taken out first.
    """
    scattering = [index for index, (evidence, at) in enumerate(seen) if evidence.precision_variance[at] > 0.0]
    found = [NO_STEPS] * len(seen)
    if not scattering:
        return found
    search = _Search(tuple(seen[index] for index in scattering))
    for change in changes if search.course.dof > 0 else ():
        search = search.beside(change)
    if not search.course.is_judged:
        for index in scattering:
            found[index] = StepsOfOutput(during=search.taken)
        return found
    for index, steps in zip(scattering, _found(search, LEVEL / family / MOST_TESTS), strict=True):
        found[index] = steps
    return found


def _found(search: "_Search", level: float) -> list[StepsOfOutput]:
    first = search.changes
    findings: list[tuple[Finding, int | None]] = []
    changed: list[Change] = []
    while len(changed) < _MOST and (found := search.plainest(level)) is not None:
        best, seen = found
        if not seen.is_step(best):
            break
        findings += seen.finding(best)
        changed.append(best)
        search = search.without(best)
    outputs = {test.output for test in changed}
    left = [change for change in search.changes if change.output not in outputs]
    of_changed = [test for test in (*first, *changed) if test.output in outputs]
    sharing = len(search.on_table)
    return [
        StepsOfOutput(
            tuple(_tests(index, (*left, *of_changed), sharing)),
            frozenset(name for name, output in ((SLIP, None), (STEP, index)) if output in outputs),
            tuple(finding for finding, whose in findings if whose in (None, index)),
            search.taken,
        )
        for index in range(len(search.seen))
    ]


def _tests(index: int, changes: Sequence[Change], sharing: int) -> Iterator[BeliefTest]:
    """Yield both tests of an output: of what is told as it was found, of the others beside it."""
    tests: tuple[tuple[str, FindingKind, int | None, int], ...] = (
        (SLIP, "table-rotation", None, sharing),
        (STEP, "sensor-change", index, 1),
    )
    for name, kind, output, axes in tests:
        chances = [_TRIED * change.p_value for change in changes if change.output == output]
        if chances:
            yield BeliefTest(name, kind, min(1.0, *chances), axes=axes)


@dataclass(frozen=True)
class _Search:
    seen: tuple[tuple[Evidence, int], ...]
    taken: tuple[Changed, ...] = ()
    """Changes that are told already."""
    is_clipped: bool = False
    """Whether single dwells that stand out are drawn in, so that no change is made of one that is wrong."""

    @property
    def evidence(self) -> Evidence:
        """What is the same for all outputs: rows and layout."""
        return self.seen[0][0]

    @cached_property
    def course(self) -> Course:
        layout, rows = self.evidence.layout, self.evidence.rows
        dof = layout.rows - layout.points
        return Course(layout.point, self.evidence.time_order, rows.pitch_rad, rows.roll_rad, dof)

    @cached_property
    def watched(self) -> tuple[Watched, ...]:
        return tuple(self._watched(evidence, index) for evidence, index in self.seen)

    def _watched(self, evidence: Evidence, index: int) -> Watched:
        base, rows = linear_base(evidence.models[index]), evidence.rows
        departures, variance = evidence.departures[:, index], float(evidence.precision_variance[index])
        if self.taken:
            columns = evidence.by_point(step_columns(evidence, index, self.taken))
            departures = departures - columns @ np.linalg.lstsq(columns, departures, rcond=_NOTHING)[0]
        if self.is_clipped:
            scatter = SD_PER_MEDIAN_DEVIATION * float(np.median(np.abs(departures)))
            departures = evidence.by_point(np.clip(departures, -_CLIPPED * scatter, _CLIPPED * scatter))
        # Drawn in, a coarse meter that reads most dwells alike has no departures left; it keeps its scatter.
        variance = float(departures @ departures) / self.course.dof or variance
        if base is None:
            return Watched(departures, variance, None, evidence.sensed[:, index])
        along = force_along(rows.pitch_rad, rows.roll_rad, base.nominal_axis)
        return Watched(departures, variance, evidence.primary[index][1:LINEAR], along)

    @cached_property
    def on_table(self) -> tuple[int, ...]:
        """Outputs that show how the table stands."""
        return tuple(index for index, watched in enumerate(self.watched) if watched.k is not None)

    @cached_property
    def scans(self) -> list[Scan]:
        by_output = [scans_of_output(self.course, watched, index) for index, watched in enumerate(self.watched)]
        return [*scans_of_table(self.course, self.watched), *(scan for each in by_output for scan in each)]

    @cached_property
    def changes(self) -> list[Change]:
        return changes_of(self.scans)

    def share(self, change: Change) -> int:
        return len(self.on_table) if change.output is None else 1

    def plainest(self, level: float) -> "tuple[Change, _Search] | None":
        """Return the change that explains most of those that are significant, and what it was found in.

        It has to be significant with dwells that stand out drawn in as well; where such dwells hide it, alone.
        """
        plain = [change for change in self.changes if _TRIED * change.p_value <= level * self.share(change)]
        if self.is_clipped or not (plain or self.is_struck):
            return (self._likeliest(plain), self) if plain else None
        clipped = replace(self, is_clipped=True).plainest(level)
        if clipped is None or not plain:
            return clipped
        same = [change for change in plain if change.output == clipped[0].output]
        return self._likeliest(same or plain), self

    def _likeliest(self, plain: Sequence[Change]) -> Change:
        """Return the change that explains most; one that came back has to explain plainly more than one that stayed."""
        stayed, returned = (
            max((change for change in plain if (change.end is None) is is_for_good), key=_square, default=None)
            for is_for_good in (True, False)
        )
        if returned is None or stayed is None:
            best = returned or stayed
            assert best is not None
        else:
            dof = self.course.dof * self.share(returned)
            variance = max(1.0 - returned.square / dof, _NOTHING)
            best = returned if returned.square - stayed.square > _RETURNED * variance else stayed
        scan = next(scan for scan in self.scans if (scan.what, scan.output) == (best.what, best.output))
        return located(scan, best)

    @property
    def is_struck(self) -> bool:
        """Whether a single dwell stands out."""
        return any(
            float(np.abs(watched.departures).max()) ** 2 > _STRUCK * watched.variance for watched in self.watched
        )

    def without(self, change: Change) -> "_Search":
        return replace(self, taken=(*self.taken, Changed(self.course.during(change))))

    def beside(self, change: ProvedChange) -> "_Search":
        """Return the search beside a change that is proved, at the likeliest of the moments that it may have been."""
        likeliest = max(moments_of(change, self.evidence), key=self._explained_by, default=None)
        return self if likeliest is None else replace(self, taken=(*self.taken, likeliest))

    def _explained_by(self, changed: Changed) -> float:
        """Return what a change explains of the outputs, in variances of a dwell."""
        return sum(
            explained(self.evidence.by_point(step_columns(evidence, at, (changed,))), watched.departures)[0]
            / watched.variance
            for (evidence, at), watched in zip(self.seen, self.watched, strict=True)
        )

    def is_step(self, change: Change) -> bool:
        """Return whether a change is one, and not the likeliest step of a drift or of the temperature."""
        is_of_output = change.output is not None
        outputs = self.on_table if change.output is None else (change.output,)
        pattern = np.concatenate([self._pattern(change, index) for index in outputs])
        y = np.concatenate([self.watched[index].departures / self._sd(index) for index in outputs])
        evidence, layout = self.evidence, self.evidence.layout
        step = self._left(pattern, self.course.during(change)[:, None])
        parts = parts_of_replications(evidence, _PARTS)
        levels = self._left(pattern, parts[:, None] == np.arange(parts.max() + 1))
        together, rank = explained(np.hstack([step, levels]), y)
        dof, by_parts = len(outputs) * self.course.dof - rank, rank - 1
        variance = max(float(y @ y) - together, _NOTHING * float(y @ y)) / dof
        by_step = explained(step, y)[0]
        likelier = by_step - _PER_NUMBER * change.numbers * variance
        drifts = ((self._left(pattern, columns), free) for columns, free in self._drifts(change))
        if any(explained(columns, y)[0] - _PER_NUMBER * free * variance > likelier for columns, free in drifts):
            return False
        rest = (together - by_step) / variance
        is_large = by_parts > 0 and rest > by_parts + _LARGEST_REST * by_step / variance
        if is_large and float(f_tail(rest / by_parts, float(by_parts), float(dof))) < _CONTRADICTED:
            return False
        if self._is_of_a_dwell(step, y, by_step):
            return False
        others = []
        if layout.replications <= (_FEW_OF_RETURN if is_of_output and change.end else _FEW_REPLICATIONS):
            others.append(self._left(pattern, self._by_replication))
        if varies(evidence) and evidence.rows.temperature_degc is not None:
            warmth = evidence.rows.temperature_degc - evidence.rows.temperature_degc.mean()
            powers = np.stack([warmth, warmth**2], axis=1)
            others += [self._left(pattern, powers), self._left(np.ones_like(pattern), powers)]
        if not others:
            return True
        beside = np.hstack(others)
        kept = explained(np.hstack([step, beside]), y)[0] - explained(beside, y)[0]
        return kept >= _KEPT * by_step

    def _is_of_a_dwell(self, step: FloatArray, y: FloatArray, by_step: float) -> bool:
        """Return whether a change is shown by one dwell alone, the others in it sensing next to nothing of it."""
        rows = self.course.point.size
        struck = np.zeros((rows, 1))
        struck[int(np.abs(y).argmax()) % rows] = 1.0
        beside = np.asarray(np.kron(np.eye(y.size // rows), self.evidence.by_point(struck)), dtype=np.float64)
        kept = explained(np.hstack([step, beside]), y)[0] - explained(beside, y)[0]
        return kept < _KEPT * by_step

    def _drifts(self, change: Change) -> Iterator[tuple[FloatArray | BoolArray, int]]:
        """Yield (N, c) courses of a drift, and how many numbers each has to choose: what a change is held against."""
        yield from courses_of_drift(self.course.time_order)
        if change.end is None or change.output is not None:
            # A table that stands differently in every replication is off by itself as well.
            yield self._by_replication, self.evidence.layout.replications - 1

    @property
    def _by_replication(self) -> BoolArray:
        """(N, n) the rows of each replication."""
        layout = self.evidence.layout
        return np.asarray(layout.replication[:, None] == np.arange(layout.replications))

    def _sd(self, index: int) -> float:
        return float(np.sqrt(self.watched[index].variance))

    def _pattern(self, change: Change, index: int) -> FloatArray:
        """Return (N,) what one output takes of a change, over its standard deviation."""
        watched = self.watched[index]
        if change.what == "offset":
            return np.full(watched.departures.size, 1.0 / self._sd(index))
        if change.what == "sensitivity" or watched.k is None:
            return np.asarray(watched.sensed / self._sd(index))
        course = self.course
        return np.asarray(slip_pattern(change.what, course.pitch_rad, course.roll_rad) @ watched.k / self._sd(index))

    def _left(self, pattern: FloatArray, columns: FloatArray | BoolArray) -> FloatArray:
        """Return pattern times columns of the rows, less the mean of each point, output after output."""
        by_output = pattern.reshape(-1, columns.shape[0])
        return np.concatenate([self.evidence.by_point(column[:, None] * columns) for column in by_output])

    def finding(self, change: Change) -> Iterator[tuple[Finding, int | None]]:
        """Yield what the diagnosis of two visits makes of the rows in a change and outside."""
        course, rows = self.course, self.evidence.rows
        between, steps = step_words.when(change, course, rows), step_words.doubted_steps(change, course, rows)
        doubt = step_words.doubt(change, course, rows)
        findings = self._diagnosed(change, between, steps) if change.output in (None, *self.on_table) else ()
        findings = findings or (self._undiagnosed(change, between, steps),)
        for finding in findings:
            is_of_sensor = finding.kind == "sensor-change" and change.output is not None and len(findings) == 1
            details = {**finding.details, "test": SLIP if change.output is None else STEP}
            yield (
                replace(
                    finding,
                    text=finding.text + doubt,
                    p_value=min(1.0, _TRIED * change.p_value),
                    details=details,
                    is_held=False,
                ),
                change.output if is_of_sensor else None,
            )

    def _diagnosed(self, change: Change, between: str, steps: tuple[int, ...]) -> tuple[Finding, ...]:
        evidence, layout = self.evidence, self.evidence.layout
        inside = self.course.during(change)
        variances = [self.without(change).watched[index].variance for index in self.on_table]
        pitch, roll = angles_of_points(evidence.rows, layout)
        axes = [self.seen[index][0].models[self.seen[index][1]].nominal_axis for index in self.on_table]
        size = len(axes)
        watched = WatchedAxes(
            (_PACKAGE,) * size, tuple(axes), (_METER,) * size,
            np.array([self.watched[index].k for index in self.on_table]),
        )  # fmt: skip
        left = np.stack([self.watched[index].departures for index in self.on_table], axis=1)
        reading = np.stack(
            [evidence.fitted[:, at] for evidence, at in (self.seen[index] for index in self.on_table)], axis=1
        )
        later, earlier = (layout.sum_by_point(np.where(kept, 1.0, 0.0)) for kept in (inside, ~inside))
        with np.errstate(invalid="ignore", divide="ignore"):
            changed = (
                layout.sum_by_point(np.where(inside[:, None], left, 0.0)) / later[:, None]
                - layout.sum_by_point(np.where(inside[:, None], 0.0, left)) / earlier[:, None]
            )
            variance = np.outer(1.0 / later + 1.0 / earlier, variances)
        visits = Visits(pitch, roll, changed, layout.mean_by_point(reading), variance, float(self.course.dof))
        found = judge_visits(watched, visits, _CONTRADICTED)
        return findings_of(found, watched.sensors, between, evidence.models[0].measured_unit, steps)

    def _undiagnosed(self, change: Change, between: str, steps: tuple[int, ...]) -> Finding:
        if change.output is None:
            text = f"{_PACKAGE} turned about {change.what} {between}: the table, its base or the common fixture"
            return Finding("table-rotation", text, True, None, steps)
        text = f"the {change.what} stepped {between}: the sensor, its channel or its supply"
        return Finding("sensor-change", text, True, None, steps)


def _square(change: Change) -> float:
    return change.square
