"""Record streams while an axis moves: every sample, when it was taken, and what is missing.

In real time a reader thread empties each line, so that no buffer runs over while an axis is asked; in virtual time,
where nothing happens by itself, the waits poll. Samples lie in memory until the dwell is done and go into the journal
with it.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Lock

import numpy as np

from ams.arrays import FloatArray, IntArray
from rig.abilities.abilities import Stream, StreamBlock, Wait
from rig.clock import Clock, VirtualClock
from rig.errors import DeviceSilent, RigError
from rig.threads import BegunThread

LONGEST_POLL_S, SHORTEST_POLL_S, REAL_POLL_S, LEISURELY_POLL_S = 0.1, 0.002, 0.005, 0.23
LEISURELY_SAMPLES = 0.7
GOLDEN = 0.6180339887498949
_SILENT_AFTER_S, _SILENT_AFTER_SAMPLES = 5.0, 5.0


@dataclass(frozen=True)
class Gap:
    """A place where samples are missing, or may be."""

    at: int
    """Index of the first sample behind it."""
    missing: int | None
    why: str


@dataclass(frozen=True)
class Recording:
    """What one stream sent, in the order sent."""

    stream: str
    rate_hz: float
    values: Mapping[str, FloatArray]
    """By full channel name, (n,)."""
    device_s: FloatArray
    """(n,) seconds by the device's own time, or by its sample count where it sends none."""
    last_of_poll: IntArray
    """(m,) index of the last sample of every poll that brought one."""
    polled_s: FloatArray
    """(m,) rig seconds of those polls."""
    gaps: tuple[Gap, ...]
    refused: int
    units: Mapping[str, str] = field(default_factory=dict)
    """Of ``values``, as written in a key."""

    @property
    def samples(self) -> int:
        return int(self.device_s.size)

    def part(self, first: int, count: int) -> "Recording":
        """``count`` samples from ``first`` on; gaps between them stay."""
        inside = (self.last_of_poll >= first) & (self.last_of_poll < first + count)
        return Recording(
            self.stream,
            self.rate_hz,
            {name: values[first : first + count] for name, values in self.values.items()},
            self.device_s[first : first + count],
            self.last_of_poll[inside] - first,
            self.polled_s[inside],
            tuple(Gap(gap.at - first, gap.missing, gap.why) for gap in self.gaps if first < gap.at < first + count),
            self.refused,
            self.units,
        )


@dataclass
class _Tape:
    """One stream that is being recorded."""

    stream: Stream
    heard_s: float
    blocks: list[StreamBlock] = field(default_factory=list)
    samples: int = 0
    refused: int = 0
    """Lines that were no sample, since the last that was one."""
    error: Exception | None = None

    def take(self, block: StreamBlock) -> None:
        if block.samples or block.refused:
            self.blocks.append(block)
        self.refused += block.refused
        if block.samples:
            self.samples += block.samples
            self.heard_s, self.refused = block.polled_s, 0


class Recorder:
    """Records from :meth:`start` to :meth:`stop`; :meth:`wait` instead of the run's own wait keeps it fed."""

    def __init__(self, streams: Mapping[str, Stream], clock: Clock, wait: Wait, *, is_timed: bool = False) -> None:
        """``is_timed``: when a sample was taken matters, so it is fetched as soon as it may be there."""
        self._streams = dict(streams)
        self._clock = clock
        self._wait = wait
        self._tapes: dict[str, _Tape] = {}
        self._lock = Lock()
        self._ends = Event()
        self._thread: BegunThread | None = None
        self._polls = 0
        fastest_hz = max((stream.rate_hz for stream in streams.values()), default=1.0)
        often_s = min(max(0.2 / fastest_hz, SHORTEST_POLL_S), LONGEST_POLL_S)
        self.poll_s = often_s if is_timed else max(LEISURELY_POLL_S, LEISURELY_SAMPLES / fastest_hz)

    def start(self) -> None:
        """Let every stream send; what came before is dropped. Raises as the streams, MemoryError without a thread."""
        for name, stream in self._streams.items():
            stream.start()
            self._tapes[name] = _Tape(stream, self._clock.monotonic_s())
        if not isinstance(self._clock, VirtualClock) and self._streams:
            self._ends.clear()
            reader = BegunThread(self._read_on, "what is read of streams")
            reader.begin()
            self._thread = reader

    def wait(self, duration_s: float) -> None:
        """Let rig time pass while recording. Raises: WaitEnded, and what a stream says."""
        if self._thread is not None or not self._tapes:
            self._wait(duration_s)
            self.look()
            return
        ends_s = self._clock.monotonic_s() + duration_s
        while (left_s := ends_s - self._clock.monotonic_s()) > 0.0:
            self._wait(min(left_s, self._next_poll_s()))
            self._poll()
            self.look()

    def _next_poll_s(self) -> float:
        """Return the time to the next poll.

        Polls keep no step with the samples: some come right behind one, and these tell when it was taken.
        """
        self._polls += 1
        return self.poll_s * (0.6 + 0.8 * (self._polls * GOLDEN % 1.0))

    def look(self) -> None:
        """Check that every stream sends. Raises: what a reader met, DeviceSilent where a stream sends nothing."""
        now_s = self._clock.monotonic_s()
        for name, tape in self._tapes.items():
            if tape.error is not None:
                raise tape.error
            silent_s = _SILENT_AFTER_S + _SILENT_AFTER_SAMPLES / tape.stream.rate_hz
            if now_s - tape.heard_s > silent_s:
                came, to_do = "", "check power, cable and baud rate"
                if tape.refused:
                    came = f", but {tape.refused} lines that are none"
                    to_do = "check columns and baud rate, and that no two cables changed places"
                raise DeviceSilent(
                    f"streams.{name}: no sample for {silent_s:.3g} s{came}; what was recorded is void; {to_do}"
                )

    def samples(self, stream: str) -> int:
        """Return how many samples came so far."""
        return self._tapes[stream].samples

    def taken(self, stream: str) -> list[StreamBlock]:
        """Return what came since this was asked last; it is kept here no longer."""
        tape = self._tapes[stream]
        with self._lock:
            blocks, tape.blocks = tape.blocks, []
        return blocks

    def stop(self) -> dict[str, Recording]:
        """End it; everything that was recorded, by stream. Raises: what a reader met."""
        self.close()
        for tape in self._tapes.values():
            if tape.error is not None:
                raise tape.error
        return {name: _joined(name, tape) for name, tape in self._tapes.items()}

    def close(self) -> None:
        """End it whatever happened; a device that cannot be told is left as it is."""
        self._ends.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        for tape in self._tapes.values():
            try:
                tape.stream.stop()
            except RigError as error:
                tape.error = tape.error or error

    def _read_on(self) -> None:
        while not self._ends.is_set():
            self._poll()
            self._clock.sleep(REAL_POLL_S)

    def _poll(self) -> None:
        for tape in self._tapes.values():
            if tape.error is None:
                try:
                    block = tape.stream.poll()
                    with self._lock:
                        tape.take(block)
                except Exception as error:  # noqa: BLE001  the rim of a thread: whoever looks at the tape raises it
                    tape.error = error


@contextmanager
def recording(streams: Mapping[str, Stream], clock: Clock, wait: Wait, *, is_timed: bool = False) -> Iterator[Recorder]:
    """Yield a recorder that is closed whatever happens inside."""
    recorder = Recorder(streams, clock, wait, is_timed=is_timed)
    try:
        yield recorder
    finally:
        recorder.close()


def _joined(name: str, tape: _Tape) -> Recording:
    blocks = tape.blocks
    firsts = np.cumsum([0, *(block.samples for block in blocks)])
    gaps = tuple(
        Gap(int(first) + gap.at, gap.missing, gap.why)
        for first, block in zip(firsts, blocks, strict=False)
        for gap in block.gaps
    )
    device_s = _concatenated([block.device_s for block in blocks])
    if not np.isfinite(device_s).all():
        device_s = _counted_s(device_s.size, gaps, tape.stream.rate_hz)
    bringing = [index for index, block in enumerate(blocks) if block.samples]
    return Recording(
        name,
        tape.stream.rate_hz,
        {channel: _concatenated([block.values[channel] for block in blocks]) for channel in tape.stream.channels},
        device_s,
        np.array([firsts[index + 1] - 1 for index in bringing], dtype=np.int64),
        np.array([blocks[index].polled_s for index in bringing], dtype=np.float64),
        gaps,
        sum(block.refused for block in blocks),
        tape.stream.units,
    )


def _concatenated(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros(0)


def _counted_s(samples: int, gaps: Sequence[Gap], rate_hz: float) -> FloatArray:
    """Return the times of a stream without time stamps: its samples counted, those known to be missing as well."""
    steps = np.ones(samples)
    for gap in gaps:
        if gap.missing is not None and 0 < gap.at < samples:
            steps[gap.at] = gap.missing + 1 if gap.missing else 0.0
    counted: FloatArray = (np.cumsum(steps) - 1.0) / rate_hz
    return counted
