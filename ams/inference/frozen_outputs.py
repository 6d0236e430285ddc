"""Outputs that repeat one number though noise is to be seen: taken as missing, and told.

A digitiser that hangs goes on sending its last number. Where the noise of a reading is no less than the step of the
output, one reading in four repeats the one before at most, and a run of repeats is none of chance. A meter whose step
is wider than the noise repeats itself at rest: nothing is told of it.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.inference.angle_stream import CARRIED_CODES, AngleStream, Answer
from ams.inference.gyro_package import GyroPackage
from ams.inference.inference import Package
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import table

LEAST_REPEATS: Final = 25
"""Of a run: a quarter to this power is 10⁻¹⁵."""
_PIECE: Final = 16
_LEAST_PIECES: Final = 4
_LOOKED_AT: Final = 4096
"""Rows of a block from which step and noise are taken."""


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


class _Output:
    """One output: its step, its noise where it is quietest, and how long it stands at its last number."""

    def __init__(self) -> None:
        self.step = np.inf
        self.noise = np.inf
        self.pieces = 0
        self._rest = np.empty(0)
        self._last = np.nan
        self._repeats = 0

    def runs(self, values: FloatArray) -> BoolArray:
        """Return which of (n,) further values repeat the one before in a run that is long enough."""
        equal = values == np.concatenate([[self._last], values[:-1]])
        self._last = float(values[-1])
        in_run = np.zeros(values.size, dtype=bool)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], equal, [False]])))
        starts, ends = edges[::2], edges[1::2]
        lengths = ends - starts + np.where(starts == 0, self._repeats, 0)
        is_long = lengths >= LEAST_REPEATS
        for start, end in zip(starts[is_long].tolist(), ends[is_long].tolist(), strict=True):
            in_run[start:end] = True
        self._repeats = int(lengths[-1]) if equal[-1] else 0
        return in_run

    def look(self, values: FloatArray) -> None:
        """Take the step and the noise of further values, of many the first ones."""
        is_whole = values.size <= _LOOKED_AT
        values = np.concatenate([self._rest, values[:_LOOKED_AT]])
        self._rest = values[values.size // _PIECE * _PIECE :] if is_whole else np.empty(0)
        steps = np.abs(np.diff(values))
        steps = steps[steps > 0.0]
        if steps.size:
            self.step = min(self.step, float(steps.min()))
        pieces = values[: values.size // _PIECE * _PIECE].reshape(-1, _PIECE)
        with np.errstate(invalid="ignore"):
            pieces = pieces[np.isfinite(pieces).all(axis=1) & (np.ptp(pieces, axis=1) > 0.0)]
        if len(pieces):
            bends = np.diff(pieces, n=2, axis=1)
            self.noise = min(self.noise, float(np.sqrt(np.mean(bends**2, axis=1) / 6.0).min()))
            self.pieces += len(pieces)

    def shows_noise(self, stated: float) -> bool:
        """Return whether noise is to be seen at its step, by what it showed and what is stated."""
        return self.pieces >= _LEAST_PIECES and self.step <= min(self.noise, stated)


class FrozenOutputs:
    """An :class:`ams.inference.angle_stream.AngleStream` before another one.

    ``noise`` is the standard deviation of one reading by column, in the unit of its output; others are not looked at.
    Where the answers are not one for each row (``is_by_row`` false) what is missing is theirs to tell.
    """

    def __init__(self, inner: AngleStream, noise: Mapping[str, float], *, is_by_row: bool = True) -> None:
        self.inner, self.noise = inner, noise
        self._is_by_row = is_by_row
        self.frozen = dict.fromkeys(noise, 0)
        """Rows by column that were taken as missing."""
        self._outputs = {name: _Output() for name in noise}
        self._codes: flag_codes.AnswerCodes = np.empty(0, dtype=np.uint64)
        """Of rows that were handed on and are not answered yet."""

    @property
    def needed(self) -> tuple[str, ...]:
        return self.inner.needed

    @property
    def optional(self) -> tuple[str, ...]:
        return tuple(name for name in self.inner.optional if name != CARRIED_CODES)

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
        codes, changed = np.zeros(rows, dtype=np.uint64), dict(readings)
        runs = {name: output.runs(readings[name]) for name, output in self._outputs.items()}
        for name, in_run in runs.items():
            self._outputs[name].look(np.where(in_run, np.nan, readings[name]) if in_run.any() else readings[name])
        for name, in_run in runs.items():
            if in_run.any() and self._is_frozen(name):
                changed[name] = np.where(in_run, np.nan, readings[name])
                codes[in_run] = flag_codes.FROZEN
                self.frozen[name] += int(np.count_nonzero(in_run))
        if CARRIED_CODES in self.inner.optional:
            return self._answered(self.inner.answer({**changed, CARRIED_CODES: codes.astype(float)}))
        if self._is_by_row:
            self._codes = np.concatenate([self._codes, codes])
        return self._answered(self.inner.answer(changed))

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        return self._answered(self.inner.finish())

    def doubts(self) -> tuple[str, ...]:
        """Say which outputs were frozen, and in how many rows."""
        return tuple(
            f"{name} repeats one number in {count} rows, which its noise does not: they are taken as missing"
            for name, count in self.frozen.items()
            if count
        )

    def _is_frozen(self, name: str) -> bool:
        """Return whether a run of repeats is none of chance: by the output itself, else by all others."""
        output = self._outputs[name]
        if output.pieces:
            return output.shows_noise(self.noise[name])
        others = [other for other in self._outputs if other != name]
        return bool(others) and all(self._outputs[other].shows_noise(self.noise[other]) for other in others)

    def _answered(self, found: Answer) -> Answer:
        reasons = {**found.reasons, **flag_codes.FROZEN_WORDS}
        if CARRIED_CODES in self.inner.optional or not self._is_by_row:
            return Answer(found.columns, found.codes, reasons)
        answered, self._codes = self._codes[: found.codes.size], self._codes[found.codes.size :]
        return Answer(found.columns, found.codes | answered, reasons)
