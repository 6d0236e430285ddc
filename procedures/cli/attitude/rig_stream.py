"""``calrig attitude --rig R --stream NAME``: the samples of a rig's own stream, as they come.

The rig file and the stream's port are locked while it is read, and the leases of what other machines reach are taken,
so no run and no other command is at it meanwhile. Nothing else of the rig is opened, and nothing moves. Twins live in
real time here, unless a duration is asked for: then by their rig file's clock.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ams.arrays import FloatArray
from ams.sets.coefficients import CoefficientSet
from ams.units import printed
from procedures.cli.locations import shared_archive_url
from procedures.cli.output import note
from procedures.cli.queues_disarmed import note_disarmed
from procedures.cli.run.stopping import stoppable_wait
from procedures.errors import RequestError
from procedures.lease.keeper import leased
from procedures.run.dwell.stream_recorder import recording
from rig.abilities.abilities import Stream, StreamBlock, Wait
from rig.assembly.discovery import with_only
from rig.assembly.open_rig import choose_clock, open_rig
from rig.clock import Clock, SystemClock, VirtualClock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import WaitEnded

LOOK_S = 0.02
"""Between two looks at what has come: twenty times within what the eye takes for at once, and a block of work."""
_COMPARED_S = 10.0
_LARGEST_RATE_ERROR = 1e-3


@dataclass(frozen=True)
class StreamWiring:
    """A stream of a rig file, and which of its channels carry the axes of which sensor."""

    rig: Path
    name: str
    description: RigDescription

    @property
    def rate_hz(self) -> float:
        return self.description.streams[self.name].samples_hz()

    @property
    def units(self) -> Mapping[str, str]:
        """By full channel name, as written in a key."""
        channel_units = self.description.streams[self.name].channel_units()
        return {f"{self.name}.{channel}": unit for channel, unit in channel_units.items()}

    def pairs(self, coefficients: CoefficientSet, option: str) -> list[str]:
        """Return AXIS=CHANNEL of the set's sensor as the rig file wires it. Raises: RequestError."""
        sensor = self.description.sensors.get(coefficients.sensor)
        channels = {} if sensor is None else {str(axis): channel for axis, channel in sensor.channels.items()}
        wired = {axis: channels.get(axis, "") for axis in coefficients.axes}
        if not set(wired.values()) <= set(self.units):
            raise RequestError(
                f"{self.rig}: sensors: {coefficients.sensor}, whose set this is, has no channels on the stream "
                f"{self.name}; nothing was opened; name them by {option} AXIS=CHANNEL (channels: "
                f"{', '.join(self.units)})"
            )
        return [f"{axis}={channel}" for axis, channel in wired.items()]

    def check(self, columns: Mapping[str, str], unit: str, option: str) -> None:
        """Refuse channels that the stream has not, or in another unit than the set's. Raises: RequestError."""
        for axis, channel in columns.items():
            if channel not in self.units:
                raise RequestError(
                    f"{option} {axis}={channel}: the stream {self.name} of {self.rig} has no such channel; nothing was "
                    f"opened; its channels are {', '.join(self.units)}"
                )
            if self.units[channel] != unit:
                raise RequestError(
                    f"{option} {axis}={channel}: comes in {printed(self.units[channel])}, the set takes "
                    f"{printed(unit)}; nothing was opened"
                )


def stream_wiring(rig: Path, name: str) -> StreamWiring:
    """Return a stream of a rig file. Raises: RequestError where it has none of this name; DescriptionError."""
    description = read_rig(rig)
    if name not in description.streams:
        raise RequestError(
            f"--stream {name}: {rig} has no such stream; nothing was opened; its streams are "
            f"{', '.join(description.streams) or 'none'}"
        )
    return StreamWiring(rig, name, description)


@dataclass
class StreamRows:
    """Blocks of a stream as columns of readings, with the time of every sample."""

    stream: Stream
    refused: int = 0
    """Lines that were no sample."""
    samples: int = 0
    lost: int = 0
    """Samples known to be missing."""
    _next: float = field(default=0.0, init=False)
    _first_s: float | None = field(default=None, init=False)
    _last_s: float = field(default=0.0, init=False)
    _has_compared: bool = field(default=False, init=False)

    def readings(self, blocks: Sequence[StreamBlock]) -> dict[str, FloatArray]:
        """Return the columns of what came, ``time_s`` and one a channel."""
        times = [self._times_s(block) for block in blocks]
        columns = {"time_s": np.concatenate(times)}
        for channel in self.stream.channels:
            columns[channel] = np.concatenate([block.values[channel] for block in blocks])
        return columns

    def _times_s(self, block: StreamBlock) -> FloatArray:
        """Return the device's own times; where it sends none its samples counted, the missing ones as well.

        A place where samples may be missing, nobody knows how many, counts as one: it is told, and angles of gyros are
        wrong by what turned meanwhile, as they are wherever samples are lost.
        """
        steps, behind = np.ones(block.samples), 0.0
        for gap in block.gaps:
            missing = 1 if gap.missing is None else gap.missing
            self.lost += missing
            step = missing + 1.0 if gap.missing != 0 else 0.0
            if gap.at < block.samples:
                steps[gap.at] = step
            else:
                behind += step - 1.0
        counted = self._next + np.cumsum(steps) - 1.0
        self._next = (float(counted[-1]) + 1.0 if counted.size else self._next) + behind
        self.samples += block.samples
        self.refused += block.refused
        device_s = block.device_s
        if not device_s.size or not np.isfinite(device_s).all():
            return np.asarray(counted / self.stream.rate_hz)
        self._compare(device_s)
        return device_s

    def _compare(self, device_s: FloatArray) -> None:
        """Tell, once, where the device's own time does not keep the rate that the rig file states."""
        if self._first_s is None:
            self._first_s = float(device_s[0])
        self._last_s = float(device_s[-1])
        took_s, intervals = self._last_s - self._first_s, self._next - 1.0
        if self._has_compared or took_s < _COMPARED_S:
            return
        self._has_compared = True
        device_hz = intervals / took_s
        if abs(device_hz / self.stream.rate_hz - 1.0) > _LARGEST_RATE_ERROR:
            note(
                f"streams.{self.stream.name}: sends {device_hz:.5g} samples a second by its own time, "
                f"{self.stream.rate_hz:g} by the rig file: angles integrated from its rates are wrong by as much; give "
                "--rate-hz, or mend rate_hz"
            )

    def in_words(self) -> str:
        """Return what came, and what did not."""
        return (
            f"streams.{self.stream.name}: {self.samples} samples, {self.lost} missing, {self.refused} lines that were "
            "no sample"
        )


@contextmanager
def opened_stream(wiring: StreamWiring, for_s: float | None) -> Iterator[Iterator[dict[str, FloatArray]]]:
    """Yield the columns of a stream, block by block, until its time is over or the command is asked to end.

    Raises: RigBusy naming who has the rig, LinkLost, DescriptionError.
    """
    only = with_only(wiring.description, "streams", {wiring.name: wiring.description.streams[wiring.name]})
    with (
        leased(shared_archive_url(), "attitude", note) as lease,
        open_rig(
            only,
            clock=_clock(only, for_s),
            rig_file=wiring.rig,
            purpose="attitude",
            claim=lease.claim,
        ) as opened,
        stoppable_wait(opened.clock) as wait,
    ):
        note_disarmed()
        opened.require_identities()
        yield _blocks(opened.streams[wiring.name], opened.clock, wait, for_s)


def _blocks(stream: Stream, clock: Clock, wait: Wait, for_s: float | None) -> Iterator[dict[str, FloatArray]]:
    rows = StreamRows(stream)
    with recording({stream.name: stream}, clock, wait) as recorder:
        recorder.start()
        ends_s = np.inf if for_s is None else clock.monotonic_s() + for_s
        is_over = False
        while not is_over:
            try:
                recorder.wait(min(LOOK_S if not isinstance(clock, VirtualClock) else 1.0, ends_s - clock.monotonic_s()))
            except WaitEnded:
                is_over = True
            is_over = is_over or clock.monotonic_s() >= ends_s
            blocks = [block for block in recorder.taken(stream.name) if block.samples or block.gaps or block.refused]
            if any(block.samples for block in blocks):
                yield rows.readings(blocks)
    note(rows.in_words())


def _clock(description: RigDescription, for_s: float | None) -> Clock:
    clock = choose_clock(description)
    return SystemClock() if for_s is None and isinstance(clock, VirtualClock) else clock
