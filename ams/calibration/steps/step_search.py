"""The search for changes in mid-run over the outputs of a package, beside what is told of them already."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.temperature import explained
from ams.analysis.diagnostics.sensed_force import along_force, is_rolled, sensed_along, turned_by
from ams.analysis.diagnostics.step_patterns import ON_MOUNT, Watched
from ams.analysis.diagnostics.steps.likeliest_step import changes_of, located
from ams.analysis.diagnostics.steps.step_outputs import scans_of_meter, scans_of_output, scans_of_table, together
from ams.analysis.diagnostics.steps.step_scan import Change, Course, Scan
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.analysis.diagnostics.time_order import even_course
from ams.arrays import BoolArray, FloatArray
from ams.calibration.steps.step_columns import Changed, Drifting, moments_of, step_columns
from ams.inputs.known_of_run import ProvedChange
from ams.statistics.distributions import SD_PER_MEDIAN_DEVIATION, f_tail

_OF_A_PATTERN: Final = 2.0
"""Changes of each pattern: one that stayed and one that came back."""
_OF_OUTPUT: Final = 2
"""Patterns of each output, and of the meter, which several together show: of offset and of sensitivity."""
NOTHING: Final = 1e-9
"""Of a column, or of the largest singular value: less is rounding."""
_RETURNED: Final = 16.0
"""In variances of a dwell: what a return has to explain beyond a change that stayed; the likeliest of all places does
less by chance."""
_CLIPPED: Final = 5.0
_STRUCK: Final = 36.0
"""In squares of a standard deviation."""


@dataclass(frozen=True)
class StepSearch:
    seen: tuple[tuple[Evidence, int], ...]
    taken: tuple[Changed, ...] = ()
    """Changes that are told already."""
    drifting: frozenset[int] = frozenset()
    """Outputs that drift evenly: their drift stands beside every change."""
    gaining: frozenset[int] = frozenset()
    """Outputs whose sensitivity drifts evenly, which is taken out of ``seen``."""
    holds_mount: bool = False
    """Whether the package is known to have stayed on its mount."""
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
        model = self.evidence.models[self.seen[0][1]]
        base = accelerometer_base(model)
        if base is None:
            return Course(layout, self.evidence.time_order, rows.pitch_rad, rows.roll_rad, dof)
        pitch, roll, yaw = turned_by(base, rows)
        return Course(layout, self.evidence.time_order, pitch, roll, dof, yaw, is_rolled(base))

    @cached_property
    def watched(self) -> tuple[Watched, ...]:
        return tuple(self._watched(at) for at in range(len(self.seen)))

    @cached_property
    def drift(self) -> FloatArray:
        """(N,) an even drift as replications differ by it, of unit length."""
        left = self.evidence.layout.about_points(even_course(self.course.time_order))
        return np.asarray(left / max(float(np.linalg.norm(left)), NOTHING))

    def _beside(self, at: int) -> tuple[FloatArray, FloatArray]:
        """Return (N, c) what changes that are told do to an output, and (N, 1) its drift, or (N, 0)."""
        evidence, index = self.seen[at]
        drifts = self.drift[:, None][:, : int(at in self.drifting)]
        if not self.taken:
            return np.zeros((self.course.layout.rows, 0)), drifts
        return evidence.layout.about_points(step_columns(evidence, index, self.taken)), drifts

    def _watched(self, at: int) -> Watched:
        evidence, index = self.seen[at]
        base = accelerometer_base(evidence.models[index])
        departures, variance = evidence.departures[:, index], float(evidence.precision_variance[index])
        drift = self.drift if at in self.drifting else None
        if self.taken or drift is not None:
            changed, drifts = self._beside(at)
            columns = np.hstack([changed, drifts])
            departures = departures - columns @ np.linalg.lstsq(columns, departures, rcond=NOTHING)[0]
        if self.is_clipped:
            scatter = SD_PER_MEDIAN_DEVIATION * float(np.median(np.abs(departures)))
            departures = evidence.layout.about_points(np.clip(departures, -_CLIPPED * scatter, _CLIPPED * scatter))
        # Drawn in, a coarse meter that reads most dwells alike has no departures left; it keeps its scatter.
        variance = float(departures @ departures) / (self.course.dof - (drift is not None)) or variance
        if base is None:
            return Watched(departures, variance, None, evidence.sensed[:, index], drift)
        along = sensed_along(base, evidence.rows)
        return Watched(departures, variance, along_force(base, evidence.primary[index]), along, drift)

    @cached_property
    def on_table(self) -> tuple[int, ...]:
        """Outputs that show how the table stands."""
        return tuple(index for index, watched in enumerate(self.watched) if watched.k is not None)

    @cached_property
    def scans(self) -> list[Scan]:
        of_all, by_output = together(self.course, self.watched), enumerate(self.watched)
        return [
            *(scan for scan in scans_of_table(of_all) if not self._rules_out(scan)),
            *scans_of_meter(of_all),
            *(scan for index, watched in by_output for scan in scans_of_output(self.course, watched, index)),
        ]

    def _rules_out(self, scan: Scan) -> bool:
        return self.holds_mount and scan.what in ON_MOUNT

    @cached_property
    def changes(self) -> list[Change]:
        return changes_of(self.scans)

    def share(self, change: Change) -> int:
        return len(self.on_table) if change.output is None else 1

    def chance(self, change: Change) -> float:
        """Return the p-value of a change over all that were tried: of what outputs show together, table to meter."""
        if change.output is not None:
            return _OF_A_PATTERN * _OF_OUTPUT * change.p_value
        patterns = len(self.course.turns) + (_OF_OUTPUT if self.share(change) > 1 else 0)
        return _OF_A_PATTERN * patterns * change.p_value

    def plainest(self, level: float) -> "tuple[Change, StepSearch] | None":
        """Return the change that explains most of those that are significant, and what it was found in.

        It has to be significant with dwells that stand out drawn in as well; where such dwells hide it, alone.
        """
        plain = [change for change in self.changes if self.chance(change) <= level * self.share(change)]
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
            variance = max(1.0 - returned.square / dof, NOTHING)
            best = returned if returned.square - stayed.square > _RETURNED * variance else stayed
        scan = next(scan for scan in self.scans if (scan.what, scan.output) == (best.what, best.output))
        return located(scan, best)

    @property
    def is_struck(self) -> bool:
        """Whether a single dwell stands out."""
        return any(
            float(np.abs(watched.departures).max()) ** 2 > _STRUCK * watched.variance for watched in self.watched
        )

    def drifting_beside(self, change: Change, level: float) -> frozenset[int]:
        """Return the outputs whose even drift is plain beside a change of them, and that are not known to drift.

        Of all that the diagnosis will look at: what one of them drifted by is no part of what another did.
        """
        outputs = self._diagnosed_with(change)
        found = frozenset(
            index
            for index in outputs
            if index not in self.drifting and self._chance_of(self.drift, index, change) <= level
        )
        return frozenset(outputs) - self.drifting if found and change.is_of_meter else found

    def gaining_beside(self, change: Change, level: float) -> frozenset[int]:
        """Return the same of an even drift of the sensitivities."""
        return frozenset(
            index
            for index in self._diagnosed_with(change)
            if index not in self.gaining and self._chance_of(self._gain_drift(index), index, change) <= level
        )

    def _diagnosed_with(self, change: Change) -> tuple[int, ...]:
        output = change.output
        return self.on_table if output is None or output in self.on_table else (output,)

    def _gain_drift(self, at: int) -> FloatArray:
        """Return (N,) an even drift of the sensitivity of an output as replications differ by it."""
        evidence, index = self.seen[at]
        return evidence.layout.about_points(even_course(self.course.time_order) * evidence.sensed[:, index])

    def passing_for(self, change: Change, what: Drifting) -> frozenset[int]:
        """Return the outputs of which a drift of something passes for a change of it, and is not known yet."""
        outputs = self.on_table if change.output is None else (change.output,)
        known = self.drifting if what == "offset" else self.gaining
        return frozenset(outputs if change.what == what else ()) - known

    def drifting_of(self, index: int) -> frozenset[Drifting]:
        """Return what of an output is known to drift."""
        known: Mapping[Drifting, frozenset[int]] = {"offset": self.drifting, "sensitivity": self.gaining}
        return frozenset(what for what, outputs in known.items() if index in outputs)

    def _chance_of(self, drift: FloatArray, index: int, change: Change) -> float:
        """Return that of a drift beside a change of an output."""
        watched = self.watched[index]
        step = self.left_of((index,), self.pattern(change, index), self.course.during(change)[:, None])
        y = watched.departures / self.sd(index)
        by_step, rank = explained(step, y)
        together, most = explained(np.column_stack([step, watched.beside(drift)]), y)
        dof = self.course.dof - most
        if most == rank or dof < 1:
            return 1.0
        left = max(float(y @ y) - together, NOTHING * float(y @ y))
        return float(f_tail((together - by_step) * dof / left, 1.0, float(dof)))

    def beside_drift_of(self, outputs: frozenset[int]) -> "StepSearch":
        """Return the search beside an even drift of some outputs."""
        return replace(self, drifting=self.drifting | outputs) if outputs else self

    def beside_gain_drift_of(self, outputs: frozenset[int]) -> "StepSearch":
        """Return the search in some outputs without an even drift of their sensitivities.

        A turn does to the force what is across it, and a gain what is along it: over all attitudes neither has a part
        of the other. A gain that drifts takes an offset with it, whose own drift stands beside every change then.
        """
        if not outputs:
            return self
        course, seen = even_course(self.course.time_order)[:, None], list(self.seen)
        for at in outputs:
            evidence, index = seen[at]
            beside = np.hstack([course, step_columns(evidence, index, self.taken)] if self.taken else [course])
            left = evidence.left.copy()
            left[:, index] -= evidence.part_of(index, course * evidence.sensed[:, [index]], beside)
            seen[at] = replace(evidence, left=left), index
        return replace(self, seen=tuple(seen), gaining=self.gaining | outputs, drifting=self.drifting | outputs)

    def with_mount_held(self) -> "StepSearch":
        """Return the search for what else it may be, until another change is told: no turn of the package is one."""
        return replace(self, holds_mount=True)

    def without(self, change: Change) -> "StepSearch":
        return replace(self, taken=(*self.taken, Changed(self.course.during(change))), holds_mount=False)

    def beside(self, change: ProvedChange) -> "StepSearch":
        """Return the search beside a change that is proved, at the likeliest of the moments that it may have been."""
        likeliest = max(moments_of(change, self.evidence), key=self._explained_by, default=None)
        return self if likeliest is None else replace(self, taken=(*self.taken, likeliest))

    def _explained_by(self, changed: Changed) -> float:
        """Return what a change explains of the outputs, in variances of a dwell."""
        return sum(
            explained(self.evidence.layout.about_points(step_columns(evidence, at, (changed,))), watched.departures)[0]
            / watched.variance
            for (evidence, at), watched in zip(self.seen, self.watched, strict=True)
        )

    def sd(self, index: int) -> float:
        return float(np.sqrt(self.watched[index].variance))

    def pattern(self, change: Change, index: int) -> FloatArray:
        """Return (N,) what one output takes of a change, over its standard deviation."""
        watched = self.watched[index]
        if watched.k is None or (change.what == "sensitivity" and change.output is not None):
            taken = watched.sensed if change.what != "offset" else np.ones(watched.departures.size)
        else:
            taken = self.course.taken_of(change.what, watched.k)
        return np.asarray(taken / self.sd(index))

    def left_of(self, outputs: Sequence[int], pattern: FloatArray, columns: FloatArray | BoolArray) -> FloatArray:
        """Return pattern times columns of the rows as far as replications differ by them, output after output."""
        by_output = pattern.reshape(-1, columns.shape[0])
        return np.concatenate(
            [
                self.watched[index].beside(self.evidence.layout.about_points(column[:, None] * columns))
                for index, column in zip(outputs, by_output, strict=True)
            ]
        )

    def undrifted(self, at: int) -> FloatArray:
        """Return (N,) the departures of an output without what is told already, a drift left in it."""
        departures = self.watched[at].departures
        if at not in self.drifting:
            return departures
        evidence, index = self.seen[at]
        columns = np.hstack(self._beside(at))
        sizes = np.linalg.lstsq(columns, evidence.departures[:, index], rcond=NOTHING)[0]
        return np.asarray(departures + sizes[-1] * self.drift)


def _square(change: Change) -> float:
    return change.square
