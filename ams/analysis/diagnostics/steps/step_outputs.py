"""The scans for a change in mid-run that outputs are looked at with: all of a package together, and each by itself."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ams.analysis.diagnostics.step_patterns import EACH_WITH_EACH, Watched, What, force
from ams.analysis.diagnostics.steps.step_paths import PatternInTime
from ams.analysis.diagnostics.steps.step_scan import Course, Scan, since
from ams.arrays import FloatArray


@dataclass(frozen=True)
class Together:
    """The outputs of a package that sense attitude, A of them, in which a change of table or meter is one."""

    course: Course
    outputs: tuple[Watched, ...]

    @cached_property
    def k(self) -> FloatArray:
        """(A, 3) sensitivities, per g."""
        return np.array([output.k for output in self.outputs])

    @cached_property
    def weights(self) -> FloatArray:
        """(A,) of what each output shows, one over the variance of its dwells."""
        return 1.0 / np.array([output.variance for output in self.outputs])

    @cached_property
    def departures(self) -> FloatArray:
        """(A, N) in the order of time."""
        return self.course.in_time(np.array([output.departures for output in self.outputs]))

    @cached_property
    def squares(self) -> float:
        """Of the departures, in variances."""
        return sum(output.squares / output.variance for output in self.outputs)

    @property
    def drift(self) -> FloatArray | None:
        """(N,) of those that drift; None where none does."""
        return next((output.drift for output in self.outputs if output.drift is not None), None)

    @cached_property
    def force(self) -> FloatArray:
        """(3, N) what a change of the specific force is shown by at each dwell."""
        return np.asarray((self.k.T * self.weights).dot(self.departures))

    def scans(self, taken: FloatArray, *patterns: tuple[What, PatternInTime, FloatArray]) -> Iterator[Scan]:
        """Yield the scans of patterns of p columns, of which the outputs take (A, p).

        Each with the (N + 1,) sums from every place on of what dwells add, in the order of time.
        """
        form, dof = (taken.T * self.weights).dot(taken), len(self.outputs) * self.course.dof
        for what, pattern, sums in patterns:
            found = Scan(what, None, self.course, pattern, pattern.weights_of(form), sums, self.squares, dof)
            yield found if self.drift is None else self._beside_drift(found, taken)

    def _beside_drift(self, scan: Scan, taken: FloatArray) -> Scan:
        drifts = np.array([output.drift is not None for output in self.outputs])
        form = (taken[drifts].T * self.weights[drifts]).dot(taken[drifts])
        drifting = scan.pattern.weights_of(form)
        return replace(scan, dof=scan.dof - int(drifts.sum()), drift=self.drift, drifting=drifting)


def together(course: Course, outputs: Iterable[Watched]) -> Together:
    """Return the outputs that sense attitude, as one."""
    return Together(course, tuple(output for output in outputs if output.k is not None))


def scans_of_table(seen: Together) -> Iterator[Scan]:
    """Yield the scans for a turn of the table, or of the package on its mount, that all outputs show together."""
    course = seen.course
    if not course.is_judged or not seen.outputs:
        return
    slips = course.slips
    sums = since(np.einsum("scn,cn->sn", slips.columns, seen.force))
    yield from seen.scans(seen.k, *zip(course.turns, slips.patterns, sums, strict=True))


def scans_of_meter(seen: Together) -> Iterator[Scan]:
    """Yield the scans for a step of the meter's gain and of its offset, that all outputs of a package show together.

    Of one output alone they are those of the output.
    """
    course, outputs = seen.course, len(seen.outputs)
    if not course.is_judged or outputs < 2:
        return
    gain = course.pattern(force(*course.angles_rad), EACH_WITH_EACH)
    yield from seen.scans(seen.k, ("sensitivity", gain, since(np.einsum("cn,cn->n", gain.columns, seen.force))))
    yield from seen.scans(np.ones((outputs, 1)), ("offset", course.offset, since(seen.weights @ seen.departures)))


def scans_of_output(course: Course, watched: Watched, output: int) -> Iterator[Scan]:
    """Yield the scans for a step of one output's offset, and of its sensitivity."""
    if not course.is_judged:
        return
    squares, departures = watched.squares, course.in_time(watched.departures)
    dof, variance, drift = course.dof - (watched.drift is not None), watched.variance, watched.drift
    offset, gain = course.offset, course.pattern(watched.sensed)
    if offset.is_seen:
        yield Scan("offset", output, course, offset, None, since(departures), squares, dof, variance, drift)
    if gain.is_seen:
        along = since(departures * gain.columns[0])
        yield Scan("sensitivity", output, course, gain, None, along, squares, dof, variance, drift)
