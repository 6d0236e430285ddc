"""Outputs that repeat one number though noise is to be seen: taken as missing, and told.

So are a temperature that no sensor stands and an output that none gives, before a filter or an average has it.

A digitiser that hangs goes on sending its last number. Where the noise of a reading is no less than the step of the
output, one reading in four repeats the one before at most, moving or not, and a run of repeats is none of chance. A
meter whose step is wider than the noise repeats itself at rest: nothing is told of it. The step is seen between all
readings, not between neighbours: between those lies what the package moved.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.inference import Package
from ams.inference.rows.angle_stream import CARRIED_CODES, OF_STREAMS, AngleStream, Answer
from ams.inference.rows.possible_rows import OutputColumns, overload_codes, possible_readings, unit_by_column
from ams.inference.watch.clipped_outputs import NO_RAILS, ClippedOutputs, Rails
from ams.inference.watch.impossible_outputs import ImpossibleOutputs
from ams.inference.watch.seen_output import SeenOutput
from ams.models.possible_temperature import (
    COLUMN,
    POSSIBLE,
    impossible_temperature,
    likely_unit,
    possible_temperatures,
)
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import table

LEAST_ROWS: Final = 20
"""Fewer say nothing of an output that does not change."""
_WORDS: Final = {
    **flag_codes.FROZEN_WORDS,
    **flag_codes.CLIPPED_WORDS,
    **flag_codes.OVERLOAD_WORDS,
    **flag_codes.TEMPERATURE_WORDS,
}


def noise_by_column(packages: Sequence[Package | GyroPackage], reading_sd_v: float | None) -> dict[str, float]:
    """Return the standard deviation of one reading by column, in the unit of its output, where it is stated."""
    found = {}
    for package in packages:
        sections = table(package.coefficients.document["axes"])
        for axis, column in package.columns.items():
            stated = standard_error_of(table(sections[axis]), package.coefficients.axes[axis])
            stated = stated if reading_sd_v is None else reading_sd_v
            if stated:
                found[column] = stated
    return found


class FrozenOutputs:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` before another one.

    ``noise`` is the standard deviation of one reading by column, in the unit of its output; others do not freeze.
    ``packages``: those that the columns are outputs of.
    Where the answers are not one for each row (``is_by_row`` false) what is missing is theirs to tell. ``untested``:
    columns that no other output tests: told where they are the same number in all rows, and taken as missing where they
    are clipped. ``rails``: levels at which they are, known from the same rows being read before.
    """

    def __init__(
        self,
        inner: AngleStream,
        noise: Mapping[str, float],
        *,
        packages: Sequence[OutputColumns] = (),
        is_by_row: bool = True,
        untested: Sequence[str] = (),
        rails: Rails = NO_RAILS,
    ) -> None:
        self.inner, self.noise = inner, noise
        units = unit_by_column(packages)
        self._packages, self._impossible = packages, ImpossibleOutputs(units)
        self.clipped = ClippedOutputs({name: sd for name, sd in noise.items() if name in untested}, rails, units)
        self._is_by_row = is_by_row
        self.frozen = dict.fromkeys(noise, 0)
        """Rows by column that were taken as missing."""
        self.impossible_rows = 0
        """Rows whose temperature no sensor stands."""
        self.rows_without_temperature = 0
        self._impossible_degc = (np.inf, -np.inf)
        self._outputs = {name: SeenOutput() for name in noise}
        self.rows = 0
        self._ends = dict.fromkeys(untested, (np.inf, -np.inf))
        self._codes: flag_codes.AnswerCodes = np.empty(0, dtype=np.uint64)
        """Of rows that were handed on and are not answered yet."""

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(name for name in self.inner.optional if name not in OF_STREAMS)

    @property
    def answers(self) -> tuple[str, ...]:
        return self.inner.answers

    @property
    def answers_at_once(self) -> bool:
        return self.inner.answers_at_once

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles that further rows settle, frozen outputs among them taken as missing."""
        rows = next(iter(readings.values())).size
        if not rows:
            return self._answered(self.inner.answer(readings))
        self.rows += rows
        as_read, readings = readings, possible_readings(readings, self._packages)
        codes = overload_codes(as_read, readings)
        self._impossible.take(as_read, readings)
        for name, (least, most) in self._ends.items():
            finite = readings[name][np.isfinite(readings[name])]
            self._ends[name] = (finite.min(initial=least), finite.max(initial=most))
        with_temperature = np.count_nonzero(np.isfinite(readings[COLUMN])) if COLUMN in readings else 0
        self.rows_without_temperature += rows - int(with_temperature)
        changed = dict(readings)
        beyond = impossible_temperature(readings)
        if beyond is not None:
            changed[COLUMN] = possible_temperatures(readings[COLUMN])
            codes[beyond] |= np.uint64(flag_codes.IMPOSSIBLE_TEMPERATURE)
            read, (least, most) = readings[COLUMN][beyond], self._impossible_degc
            self._impossible_degc = (float(read.min(initial=least)), float(read.max(initial=most)))
            self.impossible_rows += read.size
        runs = {name: output.runs(readings[name]) for name, output in self._outputs.items()}
        for name, in_run in runs.items():
            self._outputs[name].look(np.where(in_run, np.nan, readings[name]) if in_run.any() else readings[name])
        is_clipped = dict(self.clipped.take(readings, runs, self._outputs))
        for name, at_rail in is_clipped.items():
            changed[name] = np.where(at_rail, np.nan, readings[name])
            codes[at_rail] |= np.uint64(flag_codes.CLIPPED)
        for name, in_run in runs.items():
            if not in_run.any() or not self._is_frozen(name):
                continue
            is_frozen = in_run & self._outputs[name].is_resolved(readings[name], self.noise[name])
            is_frozen &= ~is_clipped.get(name, np.False_)
            changed[name] = np.where(is_frozen, np.nan, changed[name])
            codes[is_frozen] |= np.uint64(flag_codes.FROZEN)
            self.frozen[name] += int(np.count_nonzero(is_frozen))
        if CARRIED_CODES in self.inner.optional:
            return self._answered(self.inner.answer({**changed, CARRIED_CODES: codes.astype(float)}))
        if self._is_by_row:
            self._codes = np.concatenate([self._codes, codes])
        return self._answered(self.inner.answer(changed))

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        self.clipped.finish(self._outputs)
        return self._answered(self.inner.finish())

    def doubts(self) -> tuple[str, ...]:
        """Say which outputs were clipped or frozen, and in how many rows, and which are one number in all."""
        frozen = [
            f"{name} repeats one number in {count} rows, which its noise does not: they are taken as missing"
            for name, count in self.frozen.items()
            if count
        ]
        constant = [
            f"{name} is the same number in all {self.rows} rows: a dead axis, a broken wire or an input that reads "
            "nothing looks like that, and so does a package that never moved; look before the angles are used"
            for name, (least, most) in self._ends.items()
            if least == most and self.rows >= LEAST_ROWS and not self.frozen.get(name)
        ]
        return (
            *self._impossible.doubts(),
            *self.clipped.doubts(self._outputs, self.frozen),
            *frozen,
            *constant,
            *self._doubts_of_temperature(),
        )

    def _doubts_of_temperature(self) -> Iterator[str]:
        if self.impossible_rows:
            extremes = np.array(self._impossible_degc)
            read = " to ".join(dict.fromkeys(f"{extreme:.4g}" for extreme in extremes))
            rows = "1 row has" if self.impossible_rows == 1 else f"{self.impossible_rows} rows have"
            yield (
                f"{COLUMN}: {rows} one that no sensor stands ({read} °C, allowed "
                f"{POSSIBLE}): taken as missing; {likely_unit(extremes)}"
            )

    def _is_frozen(self, name: str) -> bool:
        """Return whether a run of repeats is none of chance: by the output itself, else by all others."""
        output = self._outputs[name]
        if output.pieces:
            return output.shows_noise(self.noise[name])
        others = [other for other in self._outputs if other != name]
        return bool(others) and all(self._outputs[other].shows_noise(self.noise[other]) for other in others)

    def _answered(self, found: Answer) -> Answer:
        reasons = {**found.reasons, **_WORDS}
        if CARRIED_CODES in self.inner.optional or not self._is_by_row:
            return Answer(found.columns, found.codes, reasons)
        answered, self._codes = self._codes[: found.codes.size], self._codes[found.codes.size :]
        return Answer(found.columns, found.codes | answered, reasons)
