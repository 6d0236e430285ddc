"""Attitude from sampled body rates, many steps at once: turns of the intervals, then their products by a scan.

Over an interval the rate is a polynomial through its neighbouring samples: held, straight, or a cubic through four. Of
it two moments are taken, B = ∫ω dt and M = ∫(t − h/2) ω dt, and the turn is B + B × M / h: Magnus' expansion, fourth
order in the interval and exact for a rate of fixed direction. The product of n turns is associative: blocks of steps
are multiplied up side by side, their totals by the same scan, and every step once more by what went before its block.

A sample that is not a number is bridged, so that one bad reading cannot spoil all that follow, and marked; what has
been bridged so far stands beside every attitude. Arrays are channel-first; quaternions are scalar last, body to
reference.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt
from typing import Final, Literal, cast

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.errors import ObservationsError

Interpolation = Literal["cubic", "linear", "hold"]

Path = Callable[[FloatArray, FloatArray, slice, float, Interpolation], FloatArray]
"""From the attitude at the first of some steps, (3, n) rates, these steps, the interval and the interpolation: the
(4, m + 1) attitudes at their ends, the first included."""

NEEDED_SAMPLES: Final = {"cubic": 4, "linear": 2, "hold": 2}
LONGEST_BRIDGE: Final = 100
"""Samples over which rates are bridged by a straight line; over more of them the last rate is held."""
_SHORT: Final = 64
_BLOCK_STEPS: Final = 65536
"""Steps that are multiplied up at a time: what they need stays in the processor's cache."""


@dataclass(frozen=True)
class RatePath:
    """Attitudes at n samples."""

    quaternion: FloatArray
    """(4, n) body to reference, scalar last."""
    is_bridged: BoolArray
    """(n,) whether the sample's own rate was missing."""
    bridged_samples: IntArray
    """(n,) how many rates were missing up to here: the attitude knows nothing of what turned meanwhile."""


class RateScan:
    """Attitudes of a stream: chunks of any length give what the whole would have given.

    A cubic looks one sample ahead, so the attitude at the newest sample comes with the next one, or with
    :meth:`finish`; a missing rate waits for the next good one, at most ``LONGEST_BRIDGE`` samples.
    """

    def __init__(
        self,
        start: FloatArray,
        interval_s: float,
        interpolation: Interpolation = "cubic",
        path: Path | None = None,
    ) -> None:
        """``path``: another way to carry attitudes over steps than by the products of their turns."""
        if not interval_s > 0:
            raise ObservationsError(f"gyro: got an interval of {interval_s:g} s: it must be above 0 s")
        self._path: Path = path or path_by_turns
        self._quaternion = np.asarray(start, dtype=float) / np.linalg.norm(start)
        self._interval_s = interval_s
        self._interpolation: Interpolation = interpolation
        self._waiting: FloatArray = np.empty((3, 0))
        """Samples whose rate is not known yet."""
        self._rates: FloatArray = np.empty((3, 0))
        self._missing: BoolArray = np.empty(0, dtype=bool)
        """Of the samples in ``_rates``; the first ``_given`` of these have their attitude."""
        self._given = 0
        self._bridged = 0
        self._is_holding = False

    def feed(self, rates_rad_s: FloatArray) -> RatePath:
        """Return the attitudes that (3, n) further rates settle, oldest first."""
        self._take(np.asarray(rates_rad_s, dtype=float), is_last=False)
        return self._advance(ahead=1 if self._interpolation == "cubic" else 0)

    def finish(self) -> RatePath:
        """Return the attitudes still due; the stream ends here. Raises: ObservationsError with too few samples."""
        self._take(np.empty((3, 0)), is_last=True)
        check_length(self._given + self._rates.shape[1] if self._given == 0 else 4, self._interval_s,
                     self._interpolation)  # fmt: skip
        return self._advance(ahead=0)

    def _take(self, rates: FloatArray, *, is_last: bool) -> None:
        samples = np.concatenate([self._rates[:, -1:], self._waiting, self._held(rates)], axis=1)
        known = min(self._rates.shape[1], 1)
        filled, is_missing = bridge(samples)
        still = 0 if is_last else _open_end(is_missing)
        until = samples.shape[1] - still
        if until > known:
            self._is_holding = bool(is_missing[until - 1])
        self._waiting = samples[:, until:]
        if not np.isnan(filled[:, :until]).any():
            self._rates = np.concatenate([self._rates, filled[:, known:until]], axis=1)
            self._missing = np.concatenate([self._missing, is_missing[known:until]])
        elif is_last:
            raise ObservationsError("gyro: no sample has a rate in all three axes; nothing was integrated")
        else:
            self._waiting = samples[:, known:]

    def _held(self, rates: FloatArray) -> FloatArray:
        """Return what follows a gap that was too long to be bridged; its own end is held like its beginning."""
        if not self._is_holding:
            return rates
        good = np.flatnonzero(np.isfinite(rates).all(axis=0))
        until = int(good[0]) if good.size else rates.shape[1]
        self._rates = np.concatenate([self._rates, np.repeat(self._rates[:, -1:], until, axis=1)], axis=1)
        self._missing = np.concatenate([self._missing, np.ones(until, dtype=bool)])
        self._is_holding = not good.size
        return rates[:, until:]

    def _advance(self, ahead: int) -> RatePath:
        count = self._rates.shape[1]
        until = count - ahead if count >= NEEDED_SAMPLES[self._interpolation] else 0
        if until <= self._given:
            return RatePath(np.empty((4, 0)), np.empty(0, dtype=bool), np.empty(0, dtype=np.int64))
        steps = slice(max(self._given - 1, 0), until - 1)
        path = self._path(self._quaternion, self._rates, steps, self._interval_s, self._interpolation)
        new = path if self._given == 0 else path[:, 1:]
        missing = self._missing[self._given : until]
        bridged = self._bridged + np.cumsum(missing)
        self._quaternion, self._bridged = path[:, -1], int(bridged[-1])
        # Three stay beside the one that waits: the last interval of a stream is of the cubic through its last four.
        dropped = max(until - 3, 0)
        self._rates, self._missing = self._rates[:, dropped:], self._missing[dropped:]
        self._given = until - dropped
        return RatePath(new, missing, bridged)


def path_by_turns(
    start: FloatArray, rates_rad_s: FloatArray, steps: slice, interval_s: float, interpolation: Interpolation
) -> FloatArray:
    """Return the attitudes along some steps by the products of their turns: a :data:`Path`."""
    return path_of_turns(start, turns_of_rates(rates_rad_s, interval_s, interpolation)[:, steps])


def check_length(samples: int, interval_s: float, interpolation: Interpolation) -> None:
    """Raise ObservationsError where samples do not carry the interpolation."""
    needed = NEEDED_SAMPLES[interpolation]
    if samples < needed or not interval_s > 0:
        raise ObservationsError(
            f"gyro: got {samples} samples at an interval of {interval_s:g} s: {interpolation} "
            f"interpolation needs {needed} samples or more and an interval above 0 s"
        )


def bridge(rates: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return (3, n) rates without gaps and which samples were missing; all NaN where none is a number.

    A gap is bridged by a straight line; one of more than ``LONGEST_BRIDGE`` samples, or at the end, keeps the last
    rate, one at the start the first that comes.
    """
    is_missing: BoolArray = np.asarray(~np.isfinite(rates).all(axis=0))
    if not is_missing.any():
        return rates, is_missing
    good = np.flatnonzero(~is_missing)
    if not good.size:
        return np.full_like(rates, np.nan), is_missing
    gaps = np.flatnonzero(is_missing)
    after = np.searchsorted(good, gaps)
    before_row, after_row = good[np.maximum(after - 1, 0)], good[np.minimum(after, good.size - 1)]
    length = after_row - before_row - 1
    is_short = (length > 0) & (length <= LONGEST_BRIDGE)
    share = np.where(is_short, (gaps - before_row) / np.maximum(length + 1.0, 1.0), 0.0)
    filled = np.array(rates)
    first, last = rates[:, before_row], rates[:, after_row]
    filled[:, gaps] = first + share * (last - first)
    return filled, is_missing


def _open_end(is_missing: BoolArray) -> int:
    """Return how many samples at the end wait for a rate to come; none where the gap is too long to be bridged."""
    good = np.flatnonzero(~is_missing)
    if not good.size:
        return is_missing.size
    still = is_missing.size - 1 - int(good[-1])
    return still if still <= LONGEST_BRIDGE else 0


def turns_of_rates(rates: FloatArray, interval_s: float, interpolation: Interpolation) -> FloatArray:
    """Return the (3, N − 1) turns of the intervals between (3, N) samples, as rotation vectors in body axes."""
    if interpolation == "hold":
        return np.asarray(rates[:, :-1] * interval_s)
    intervals = rates.shape[1] - 1
    nodes = NEEDED_SAMPLES[interpolation]
    before = nodes // 2 - 1
    turns = np.empty((3, intervals))
    for first in range(before, intervals - before, _BLOCK_STEPS):
        last = min(first + _BLOCK_STEPS, intervals - before)
        turns[:, first:last] = _turns(rates[:, first - before : last + nodes // 2], nodes, before, interval_s)
    if before:
        turns[:, :1] = _turns(rates[:, :nodes], nodes, 0, interval_s)
        turns[:, -1:] = _turns(rates[:, -nodes:], nodes, nodes - 2, interval_s)
    return turns


def _turns(rates: FloatArray, nodes: int, at: int, interval_s: float) -> FloatArray:
    total, moment = _moments(rates, nodes, at)
    total *= interval_s
    moment *= interval_s
    x, y, z = total
    u, v, w = moment
    turns = np.array(total)
    turns[0] += y * w - z * v
    turns[1] += z * u - x * w
    turns[2] += x * v - y * u
    return turns


def _moments(rates: FloatArray, nodes: int, at: int) -> tuple[FloatArray, FloatArray]:
    """Return ∫p and ∫(t − ½)p over a unit interval of the polynomial p through every window.

    The interval starts at node ``at``.
    """
    powers = np.arange(nodes)
    vandermonde = (np.arange(nodes)[:, None] - at).astype(float) ** powers
    integrals = np.stack([1.0 / (powers + 1.0), 1.0 / (powers + 2.0) - 0.5 / (powers + 1.0)])
    weights = np.linalg.solve(vandermonde.T, integrals.T)
    windows = rates.shape[1] - nodes + 1
    found = np.zeros((2, 3, windows))
    for node, (weight, first) in enumerate(weights.tolist()):
        part = rates[:, node : node + windows]
        found[0] += weight * part
        found[1] += first * part
    return found[0], found[1]


def path_of_turns(start: FloatArray, turns: FloatArray) -> FloatArray:
    """Return the (4, n + 1) attitudes before, between and after (3, n) turns in body axes."""
    count = turns.shape[1]
    path = np.empty((4, count + 1))
    path[:, 0] = np.asarray(start, dtype=float) / np.linalg.norm(start)
    for first in range(0, count, _BLOCK_STEPS):
        last = min(first + _BLOCK_STEPS, count)
        block = path[:, first + 1 : last + 1]
        product(path[:, first : first + 1], prefix_products(quaternions(turns[:, first:last])), out=block)
        block /= np.sqrt(np.einsum("in,in->n", block, block))
    return path


def quaternions(turns: FloatArray) -> FloatArray:
    """Return the (4, n) quaternions of (3, n) rotation vectors."""
    half = 0.5 * np.sqrt(np.einsum("in,in->n", turns, turns))
    found = np.empty((4, turns.shape[1]))
    with np.errstate(invalid="ignore"):
        share = np.where(half > 0.0, 0.5 * np.sin(half) / half, 0.5)
    np.multiply(turns, share, out=found[:3])
    np.cos(half, out=found[3])
    return found


def prefix_products(steps: FloatArray) -> FloatArray:
    """Return q₁, q₁q₂, q₁q₂q₃, … of (4, n) quaternions."""
    count = steps.shape[1]
    if count <= _SHORT:
        found = steps.copy()
        for index in range(1, count):
            found[:, index] = product(found[:, index - 1], found[:, index])
        return found
    length = max(isqrt(count) // 2, 2)
    groups = -(-count // length)
    padded = np.zeros((4, groups * length))
    padded[3] = 1.0
    padded[:, :count] = steps
    # One group to a column, so that a step of all groups lies side by side in memory.
    columns = np.ascontiguousarray(padded.reshape(4, groups, length).swapaxes(1, 2))
    for index in range(1, length):
        columns[:, index] = product(columns[:, index - 1], columns[:, index])
    before = np.zeros((4, groups))
    before[3, 0] = 1.0
    before[:, 1:] = prefix_products(columns[:, -1, :-1])
    for index in range(length):
        columns[:, index] = product(before, columns[:, index])
    return cast(FloatArray, columns.swapaxes(1, 2).reshape(4, -1)[:, :count])


def product(p: FloatArray, q: FloatArray, out: FloatArray | None = None) -> FloatArray:
    """Return p ⊗ q (Hamilton's product) of (4, …) quaternions: q first, then p, read in the reference frame."""
    a, b, c, d = p
    x, y, z, w = q
    found = np.empty(np.broadcast_shapes(p.shape, q.shape)) if out is None else out
    found[0] = d * x + a * w + b * z - c * y
    found[1] = d * y - a * z + b * w + c * x
    found[2] = d * z + a * y - b * x + c * w
    found[3] = d * w - a * x - b * y - c * z
    return found
