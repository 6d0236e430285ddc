"""One output as its readings show it: its noise where it is quietest, its step, and runs of one number."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray

LEAST_REPEATS: Final = 25
"""Of a run: a quarter to this power is 10⁻¹⁵."""
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
_PARTS_OF_NOISE: Final = 50.0
"""A finer step than this part of the noise makes readings no less likely to be equal than is asked for."""
_ABOUT: Final = np.linspace(-1.0, 1.0, 9)[:, np.newaxis]
_MOST_DIGITS: Final = 8
_ROUNDING: Final = 1.2e-7
"""Of a number in single precision, relative: readings are taken to be no better than that."""


class SeenOutput:
    """One output: its step, its noise where it is quietest, and how long it stands at its last number."""

    def __init__(self) -> None:
        self.pieces = 0
        self._quietest = np.inf
        self._step = np.inf
        """It was seen that the output has no wider one."""
        self._digits: int | None = None
        self._decimal: float | None = None
        """Of readings that are written with a fixed number of them, what one in the last is worth."""
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
        noise = self.noise(stated)
        if self._step > noise and not self._is_judged:
            self._judge(noise)
        return self._step <= noise

    def is_resolved(self, values: FloatArray, stated: float) -> BoolArray:
        """Return where (n,) values have digits enough for noise to be seen: six of them end at 10 µV above 1 V."""
        return np.asarray(self._last_digit(values) <= self.noise(stated))

    def noise(self, stated: float) -> float:
        """Return the standard deviation of a reading: the lesser of what is stated and what was seen."""
        return min(stated, self._quietest / (_QUIETEST if self.pieces >= _MANY_PIECES else 1.0))

    def step_at_most(self, level: float, noise: float) -> float:
        """Return what the step at a level is no wider than, by the newest readings; it may be much finer.

        Infinite where they are all the same. With a few significant digits it is wider there than nearer to zero.
        """
        gaps, rounding = self._gaps()
        if not gaps.size:
            return np.inf
        least = float(gaps.min())
        finest = max(noise / _PARTS_OF_NOISE, least / _MOST_COUNTS)
        step = least
        if least > finest and gaps.size >= _LEAST_GAPS:
            step = _scale_of(gaps, finest, rounding) or finest
        step = max(step, float(self._last_digit(np.array([level]))[0]))
        if np.array_equal(self._newest, self._newest.astype(np.float32)):
            step = max(step, float(np.spacing(np.float32(abs(level)))))
        return step

    def newest_but(self, levels: Sequence[float]) -> FloatArray:
        """Return the newest readings, in order, that are none of some levels."""
        return self._newest[~np.isin(self._newest, levels)]

    def _judge(self, noise: float) -> None:
        """Find whether the newest readings lie closer than ``noise``, or on no scale whose step is wider."""
        self._is_judged = True
        gaps, rounding = self._gaps()
        if not gaps.size:
            return
        least = float(gaps.min())
        self._step = min(self._step, least)
        if least <= noise or gaps.size < _LEAST_GAPS or least > _MOST_COUNTS * noise:
            return
        if _scale_of(gaps, noise, rounding) is None:
            self._step = min(self._step, noise)

    def _gaps(self) -> tuple[FloatArray, float]:
        """Return the (n,) gaps between the newest readings in their order, and by how much those may be rounded."""
        distinct = np.unique(self._newest)
        if not distinct.size:
            return distinct, 0.0
        largest = float(np.abs(distinct[[0, -1]]).max())
        self._digits = _digits_of(distinct)
        if self._digits is not None:
            decimal = _decimal_of(distinct, self._digits)
            self._decimal = decimal if self._decimal is None else min(self._decimal, decimal or np.inf)
        rounding = max(_ROUNDING * largest, float(self._last_digit(np.array([largest]))[0]))
        gaps = np.diff(distinct)
        return gaps[gaps > 1e-13 * largest], rounding

    def _last_digit(self, values: FloatArray) -> FloatArray:
        """Return what one in the last digit of (n,) values is worth, as they are written; 0 where that is not seen."""
        if self._digits is None:
            return np.zeros(values.size)
        if self._decimal is not None:
            return np.full(values.size, self._decimal)
        return _last_digit_worth(values, self._digits)


def _scale_of(gaps: FloatArray, finest: float, rounding: float) -> float | None:
    """Return the widest step that (n,) gaps may all be multiples of, wider than ``finest``, None where there is none.

    Readings were rounded.
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
                return step
            continue
        is_sure = unsure <= max(0.3 * step, 1.1 * rounding)
        sure = gaps[is_sure]
        if sure.size < _LEAST_GAPS:
            return step
        steps = step + rounding / count * _ABOUT
        beside = (sure - steps * np.rint(sure / steps)) / unsure[is_sure]
        if (np.sqrt(np.mean(beside**2, axis=1)) <= 0.52 + 0.4 / np.sqrt(sure.size)).any():
            return step
    return None


def _digits_of(values: FloatArray) -> int | None:
    """Return with how many significant digits (n,) values are written, None where they are more than is looked for."""
    values = values[values != 0.0]
    for digits in range(1, _MOST_DIGITS + 1):
        in_last_digits = values / _last_digit_worth(values, digits)
        if (np.abs(in_last_digits - np.rint(in_last_digits)) < 1e-6).all():
            return digits
    return None


def _decimal_of(values: FloatArray, digits: int) -> float | None:
    """Return the last decimal of (n,) values where they have as many decimals, None where they have as many digits.

    Small ones have fewer digits then; where there are hardly any they do not tell.
    """
    values = values[values != 0.0]
    in_digits = _last_digit_worth(values, digits)
    for decimal in np.unique(in_digits)[::-1].tolist():
        in_decimals = values / decimal
        if (np.abs(in_decimals - np.rint(in_decimals)) < 1e-6).all():
            return decimal if np.count_nonzero(in_digits < 0.5 * decimal) >= _LEAST_GAPS else None
    return None


def _last_digit_worth(values: FloatArray, digits: int) -> FloatArray:
    """Return what one in the last of so many digits of (n,) values is worth, 0 of zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 ** (np.floor(np.log10(np.abs(values))) - digits + 1))
