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

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.inference import Package
from ams.inference.rows.angle_stream import CARRIED_CODES, OF_STREAMS, AngleStream, Answer
from ams.inference.rows.possible_rows import OutputColumns, overload_codes, possible_readings, unit_by_column
from ams.inference.watch.impossible_outputs import ImpossibleOutputs
from ams.models.possible_temperature import (
    COLUMN,
    POSSIBLE,
    impossible_temperature,
    likely_unit,
    possible_temperatures,
)
from ams.sets.axis_section import standard_error_of
from ams.sets.canonical import table

LEAST_REPEATS: Final = 25
"""Of a run: a quarter to this power is 10⁻¹⁵."""
LEAST_ROWS: Final = 20
"""Fewer say nothing of an output that does not change."""
_PIECE: Final = 32
"""Rows whose fourth differences tell a noise: of a smooth motion hardly anything is left in them."""
_LEAST_PIECES: Final = 2
_MANY_PIECES: Final = 16
_QUIETEST: Final = 0.67
"""Of many pieces of one noise the quietest shows no more than this share of it."""
_LOOKED_AT: Final = 4096
"""Rows of a block, and readings of the newest ones, from which step and noise are taken."""
_LEAST_GAPS: Final = 16
_GAPS_LOOKED_AT: Final = 512
_MOST_COUNTS: Final = 256
_MOST_DIGITS: Final = 8
_ROUNDING: Final = 1.2e-7
"""Of a number in single precision, relative: readings are taken to be no better than that."""
_WORDS: Final = {**flag_codes.FROZEN_WORDS, **flag_codes.OVERLOAD_WORDS, **flag_codes.TEMPERATURE_WORDS}


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
        self.pieces = 0
        self._quietest = np.inf
        self._step = np.inf
        """It was seen that the output has no wider one."""
        self._digits: int | None = None
        self._newest = np.empty(0)
        self._is_judged = False
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
        """Take further values, NaN where they repeat; of many those after the first that does not."""
        if values.size > _LOOKED_AT:
            first = int(np.argmax(np.isfinite(values)))
            values, before = values[first : first + _LOOKED_AT], np.empty(0)
        else:
            before = self._rest
        finite = values[np.isfinite(values)]
        if finite.size:
            self._newest = np.concatenate([self._newest, finite])[-_LOOKED_AT:]
            self._is_judged = False
        values = np.concatenate([before, values])
        self._rest = values[values.size // _PIECE * _PIECE :]
        pieces = values[: values.size // _PIECE * _PIECE].reshape(-1, _PIECE)
        with np.errstate(invalid="ignore"):
            pieces = pieces[np.isfinite(pieces).all(axis=1) & (np.ptp(pieces, axis=1) > 0.0)]
        if len(pieces):
            bends = np.diff(pieces, n=4, axis=1)
            self._quietest = min(self._quietest, float(np.sqrt(np.mean(bends**2, axis=1) / 70.0).min()))
            self.pieces += len(pieces)

    def shows_noise(self, stated: float) -> bool:
        """Return whether noise is to be seen at its step, by what it showed and what is stated."""
        if self.pieces < _LEAST_PIECES:
            return False
        noise = self._noise(stated)
        if self._step > noise and not self._is_judged:
            self._judge(noise)
        return self._step <= noise

    def is_resolved(self, values: FloatArray, stated: float) -> BoolArray:
        """Return where (n,) values have digits enough for noise to be seen: six of them end at 10 µV above 1 V."""
        if self._digits is None:
            return np.ones(values.size, dtype=bool)
        return np.asarray(_last_digit_worth(values, self._digits) <= self._noise(stated))

    def _noise(self, stated: float) -> float:
        return min(stated, self._quietest / (_QUIETEST if self.pieces >= _MANY_PIECES else 1.0))

    def _judge(self, noise: float) -> None:
        """Find whether the newest readings lie closer than ``noise``, or on no scale whose step is wider."""
        self._is_judged = True
        distinct = np.unique(self._newest)
        largest = float(np.abs(distinct[[0, -1]]).max())
        self._digits = _digits_of(distinct)
        gaps = np.diff(distinct)
        gaps = gaps[gaps > 1e-13 * largest]
        if not gaps.size:
            return
        least = float(gaps.min())
        self._step = min(self._step, least)
        if least <= noise or gaps.size < _LEAST_GAPS or least > _MOST_COUNTS * noise:
            return
        rounding = _ROUNDING * largest
        if self._digits is not None:
            rounding = max(rounding, float(_last_digit_worth(np.array([largest]), self._digits)[0]))
        if not _lie_on_a_scale(gaps, noise, rounding):
            self._step = min(self._step, noise)


def _lie_on_a_scale(gaps: FloatArray, finest: float, rounding: float) -> bool:
    """Return whether (n,) gaps may all be multiples of one step, wider than ``finest``, whose readings were rounded.

    Such a step goes a whole number of times into the least gap, and what rounding leaves beside the multiples has a
    root mean square of no more than half of it. Of a step hardly wider than the rounding only exact multiples tell.
    """
    gaps = np.sort(gaps)[:_GAPS_LOOKED_AT]
    least = float(gaps[0])
    unsure = rounding * np.hypot(1.0, 0.3 * gaps / least)
    for count in range(1, int(least / finest) + 1):
        step = least / count
        if step < 2.4 * rounding:
            if (np.abs(gaps - step * np.rint(gaps / step)) <= 0.1 * rounding).all():
                return True
            continue
        is_sure = unsure <= max(0.3 * step, 1.1 * rounding)
        sure = gaps[is_sure]
        if sure.size < _LEAST_GAPS:
            return True
        steps = step + rounding / count * np.linspace(-1.0, 1.0, 9)[:, np.newaxis]
        beside = (sure - steps * np.rint(sure / steps)) / unsure[is_sure]
        if (np.sqrt(np.mean(beside**2, axis=1)) <= 0.52 + 0.4 / np.sqrt(sure.size)).any():
            return True
    return False


def _digits_of(values: FloatArray) -> int | None:
    """Return with how many significant digits (n,) values are written, None where they are more than is looked for."""
    values = values[values != 0.0]
    for digits in range(1, _MOST_DIGITS + 1):
        in_last_digits = values / _last_digit_worth(values, digits)
        if (np.abs(in_last_digits - np.rint(in_last_digits)) < 1e-6).all():
            return digits
    return None


def _last_digit_worth(values: FloatArray, digits: int) -> FloatArray:
    """Return what one in the last of so many digits of (n,) values is worth, 0 of zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 ** (np.floor(np.log10(np.abs(values))) - digits + 1))


class FrozenOutputs:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` before another one.

    ``noise`` is the standard deviation of one reading by column, in the unit of its output; others do not freeze.
    ``packages``: those that the columns are outputs of.
    Where the answers are not one for each row (``is_by_row`` false) what is missing is theirs to tell. ``untested``:
    columns that are told where they are the same number in all rows.
    """

    def __init__(
        self,
        inner: AngleStream,
        noise: Mapping[str, float],
        *,
        packages: Sequence[OutputColumns] = (),
        is_by_row: bool = True,
        untested: Sequence[str] = (),
    ) -> None:
        self.inner, self.noise = inner, noise
        self._packages, self._impossible = packages, ImpossibleOutputs(unit_by_column(packages))
        self._is_by_row = is_by_row
        self.frozen = dict.fromkeys(noise, 0)
        """Rows by column that were taken as missing."""
        self.impossible_rows = 0
        """Rows whose temperature no sensor stands."""
        self.rows_without_temperature = 0
        self._impossible_degc = (np.inf, -np.inf)
        self._outputs = {name: _Output() for name in noise}
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
        for name, in_run in runs.items():
            if not in_run.any() or not self._is_frozen(name):
                continue
            is_frozen = in_run & self._outputs[name].is_resolved(readings[name], self.noise[name])
            changed[name] = np.where(is_frozen, np.nan, readings[name])
            codes[is_frozen] |= np.uint64(flag_codes.FROZEN)
            self.frozen[name] += int(np.count_nonzero(is_frozen))
        if CARRIED_CODES in self.inner.optional:
            return self._answered(self.inner.answer({**changed, CARRIED_CODES: codes.astype(float)}))
        if self._is_by_row:
            self._codes = np.concatenate([self._codes, codes])
        return self._answered(self.inner.answer(changed))

    def finish(self) -> Answer:
        """Return the angles that are still due."""
        return self._answered(self.inner.finish())

    def doubts(self) -> tuple[str, ...]:
        """Say which outputs were frozen, and in how many rows, and which are one number in all."""
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
        return (*self._impossible.doubts(), *frozen, *constant, *self._doubts_of_temperature())

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
