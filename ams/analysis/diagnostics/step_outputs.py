"""The scans for a change in mid-run that outputs are looked at with: all of a package together, and each by itself."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ams.analysis.diagnostics.step_paths import PatternInTime
from ams.analysis.diagnostics.step_patterns import EACH_WITH_EACH, SLIPS, Watched, What, force
from ams.analysis.diagnostics.step_scan import Course, Scan, since
from ams.arrays import BoolArray, FloatArray


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
        return sum(float(output.departures @ output.departures) / output.variance for output in self.outputs)

    @cached_property
    def drifting(self) -> BoolArray | None:
        """(A,) which outputs drift; None where none does."""
        found = np.array([output.drift is not None for output in self.outputs])
        return found if found.any() else None

    @cached_property
    def force(self) -> FloatArray:
        """(3, N) what a change of the specific force is shown by at each dwell."""
        return np.asarray((self.k.T * self.weights) @ self.departures)

    def of_force(self, what: What, pattern: PatternInTime) -> Scan:
        """Return the scan of a change of the specific force, of three columns."""
        return self.scan(what, pattern, self.k, (pattern.columns * self.force).sum(axis=0))

    def scan(self, what: What, pattern: PatternInTime, taken: FloatArray, along: FloatArray) -> Scan:
        """Return the scan of a pattern of p columns.

        ``taken`` (A, p): what each output takes of them; ``along`` (N,): what each dwell adds, in the order of time.
        """
        weights, dof = pattern.weights_of(taken, self.weights), len(self.outputs) * self.course.dof
        found = Scan(what, None, self.course, pattern, weights, since(along), self.squares, dof)
        if self.drifting is None:
            return found
        return replace(
            found,
            dof=dof - int(self.drifting.sum()),
            drift=next(output.drift for output in self.outputs if output.drift is not None),
            drifting=pattern.weights_of(taken[self.drifting], self.weights[self.drifting]),
        )


def together(course: Course, outputs: Iterable[Watched]) -> Together:
    """Return the outputs that sense attitude, as one."""
    return Together(course, tuple(output for output in outputs if output.k is not None))


def scans_of_table(seen: Together) -> Iterator[Scan]:
    """Yield the scans for a turn of the table, or of the package on its mount, that all outputs show together."""
    course = seen.course
    if not course.is_judged or not seen.outputs:
        return
    for what, pattern in zip(SLIPS, course.slips, strict=True):
        yield seen.of_force(what, pattern)


def scans_of_meter(seen: Together) -> Iterator[Scan]:
    """Yield the scans for a step of the meter's gain and of its offset, that all outputs of a package show together.

    Of one output alone they are those of the output.
    """
    course, outputs = seen.course, len(seen.outputs)
    if not course.is_judged or outputs < 2:
        return
    yield seen.of_force("sensitivity", course.pattern(force(course.pitch_rad, course.roll_rad), EACH_WITH_EACH))
    yield seen.scan("offset", course.offset, np.ones((outputs, 1)), seen.weights @ seen.departures)


def scans_of_output(course: Course, watched: Watched, output: int) -> Iterator[Scan]:
    """Yield the scans for a step of one output's offset, and of its sensitivity."""
    if not course.is_judged:
        return
    squares, departures = float(watched.departures @ watched.departures), course.in_time(watched.departures)
    dof, variance, drift = course.dof - (watched.drift is not None), watched.variance, watched.drift
    offset, gain = course.offset, course.pattern(watched.sensed)
    if offset.is_seen:
        yield Scan("offset", output, course, offset, None, since(departures), squares, dof, variance, drift)
    if gain.is_seen:
        along = since(departures * gain.columns[0])
        yield Scan("sensitivity", output, course, gain, None, along, squares, dof, variance, drift)
