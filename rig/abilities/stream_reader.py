"""What all streams share: whole lines out of pieces, running numbers, gaps, time stamps whose wraps are undone."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rig.abilities.abilities import StreamGap
from rig.errors import DeviceNonsense
from rig.link.byte_stream import ByteStream
from rig.link.exchange import shown
from rig.wire.stream_lines import LONGEST_LINE, Floats, Refusal, Rows, split_whole_lines

FOREIGN_LINES = 5
"""So many lines without a single sample among them are no stream of this kind, where the stream says nothing else."""


class RowReader:
    """Rows of one stream. ``parse`` makes rows of whole lines."""

    def __init__(
        self, stream: ByteStream, name: str, parse: Callable[[bytes], Rows], foreign_lines: int = FOREIGN_LINES
    ) -> None:
        """``foreign_lines``: so many before the first sample are no stream of this kind."""
        self.rows = 0
        """Rows since :meth:`begin`."""
        self._stream = stream
        self._name = name
        self._parse = parse
        self._foreign_lines = foreign_lines
        self._received = b""
        self._is_aligned = False
        self._foreign = 0

    def begin(self, received: bytes | None = None) -> None:
        """Count from here.

        ``received`` starts with a whole line; None: what waits is dropped, and so is everything up to the first line
        feed.
        """
        self.rows = self._foreign = 0
        self._is_aligned = received is not None
        self._received = received or b""
        if received is None:
            self._stream.discard_input()

    def take(self) -> Rows:
        """Return what came since. Raises: DeviceNonsense where nothing that comes is a row, LinkLost."""
        self._received += self._stream.discard_input()
        if not self._is_aligned:
            begun, feed, rest = self._received.partition(b"\n")
            self._received, self._is_aligned = (rest, True) if feed else (begun, False)
        whole, rest = split_whole_lines(self._received) if self._is_aligned else (b"", self._received)
        self._received = rest
        if len(rest) > LONGEST_LINE:
            self._received, self._is_aligned = b"", False
            raise self._nonsense(rest, f"no line feed in {len(rest)} bytes")
        rows = self._parse(whole)
        self.rows += len(rows.values)
        if not self.rows:
            self._foreign += len(rows.refused)
            if self._foreign >= self._foreign_lines:
                self._foreign = 0
                last = rows.refused[-1]
                raise self._nonsense(last.line, last.why)
        return rows

    def _nonsense(self, line: bytes, why: str) -> DeviceNonsense:
        return DeviceNonsense(
            f"{self._name}: {self._stream.name}: none of its lines is a sample: got {shown(line)}: {why}; nothing was"
            " taken from it; check baud rate and columns, and that this is the right device"
        )


@dataclass(frozen=True, slots=True)
class Wrapping:
    """A count or time that starts again at ``modulus`` (None: never), and its value per unit."""

    modulus: float | None = None
    unit: float = 1.0

    def unwrapped(self, raw: Floats, last: float | None) -> Floats:
        """Return the counts unwrapped, going on from ``last`` (unwrapped, in raw units).

        A step is the shortest that leads there.
        """
        if self.modulus is None or not raw.size:
            return raw
        begin = float(raw[0]) if last is None else last
        steps = np.diff(np.concatenate([[begin], raw])) + self.modulus / 2.0
        walked: Floats = begin + np.cumsum(np.mod(steps, self.modulus) - self.modulus / 2.0)
        return walked


def count_gaps(counts: Floats, last: float | None) -> tuple[StreamGap, ...]:
    """Return where unwrapped counts do not go up by one."""
    steps, offset = _steps(counts, last)
    indices = np.flatnonzero(steps != 1.0)
    return tuple(_count_gap(int(index) + offset, float(steps[index])) for index in indices)


def time_gaps(times_s: Floats, last_s: float | None, rate_hz: float) -> tuple[StreamGap, ...]:
    """Return where device time does not go on by about a sample interval."""
    steps_s, offset = _steps(times_s, last_s)
    indices = np.flatnonzero((steps_s <= 0.0) | (steps_s * rate_hz > 1.5))
    return tuple(_time_gap(int(index) + offset, float(steps_s[index]), rate_hz) for index in indices)


def refusal_gaps(refused: tuple[Refusal, ...]) -> tuple[StreamGap, ...]:
    """Return the gaps of a stream without count and time.

    A line that is no sample may have been one, or two that ran together.
    """
    return tuple(StreamGap(refusal.before, None, refusal.why) for refusal in refused)


def _steps(values: Floats, last: float | None) -> tuple[Floats, int]:
    """Return steps to each value, and the index of the value that the first step leads to."""
    if last is None:
        return np.diff(values), 1
    return np.diff(np.concatenate([[last], values])), 0


def _count_gap(at: int, step: float) -> StreamGap:
    if step > 1.0:
        return StreamGap(at, int(step) - 1, f"the count goes on by {step:g}")
    return StreamGap(at, 0 if step == 0.0 else None, "a count came twice" if step == 0.0 else "the count went back")


def _time_gap(at: int, step_s: float, rate_hz: float) -> StreamGap:
    if step_s > 0.0:
        return StreamGap(at, round(step_s * rate_hz) - 1, f"device time goes on by {step_s:g} s")
    return StreamGap(
        at, 0 if step_s == 0.0 else None, "a time came twice" if step_s == 0.0 else "device time went back"
    )
