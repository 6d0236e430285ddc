"""One attempt at one dwell: settle, look, read every channel, look again. Nothing is judged here."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Protocol

from procedures.plan.adaptive import Reading
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell
from procedures.records.dwells import ChannelReading, Look, Measurement
from procedures.run.dwell.settle import Settled, settle
from procedures.run.dwell.stream_readout import StreamedReadout
from rig.abilities.abilities import Axis, Environment, Field, Readout, Stream, TwinChance, Wait
from rig.assembly.identity import Identifiable
from rig.clock import Clock
from rig.crash_points import CrashPoint, crash_point
from rig.link.counts import ExchangeCounts
from rig.motion.motion_memory import MotionMemory
from rig.motion.move import Tell
from rig.motion.together import move_all
from rig.side_by_side import side_by_side


def _tell_nobody(_phase: str) -> None:
    return None


class OpenRig(Protocol):
    """What a run needs of :class:`rig.assembly.open_rig.Rig`."""

    @property
    def axes(self) -> Mapping[str, Axis]: ...
    @property
    def readouts(self) -> Mapping[str, Readout]: ...
    @property
    def environments(self) -> Mapping[str, Environment]: ...
    @property
    def streams(self) -> Mapping[str, Stream]: ...
    @property
    def fields(self) -> Mapping[str, Field]: ...
    @property
    def chance(self) -> TwinChance: ...
    @property
    def clock(self) -> Clock: ...
    @property
    def motion(self) -> MotionMemory: ...
    def identities(self) -> Mapping[str, str]: ...
    def by_table(self) -> Mapping[str, Identifiable]: ...
    def link_counts(self) -> Mapping[str, ExchangeCounts]: ...
    def reconnect(self) -> None: ...
    def open_lost(self, until_s: float) -> str: ...
    def stranger_axes(self, names: Iterable[str]) -> Mapping[str, str]: ...
    def sign_of_life(self) -> None: ...


@dataclass(frozen=True, slots=True)
class Announcement:
    """How an attempt is told to the twins; real devices do not listen."""

    step: int
    attempt: int
    replications: float
    settle_phase: str
    read_phase: str
    tell: Callable[[str], None] = _tell_nobody
    """Hears what is being done: ``settling``, then ``reading``."""

    def settle(self, chance: TwinChance) -> None:
        self.tell("settling")
        chance.announce(self.step, self.settle_phase, self.attempt, self.replications)

    def read(self, chance: TwinChance) -> None:
        self.tell("reading")
        chance.announce(self.step, self.read_phase, self.attempt, self.replications)

    def of_sweep(self, number: int) -> "Announcement":
        """Return the announcement of one sweep: every sweep of a dwell has chance of its own."""
        return replace(self, read_phase=f"{self.read_phase}-sweep-{number}")


def move(
    rig: OpenRig,
    dwell: Dwell,
    wait: Wait,
    tell: Tell = lambda _message: None,
    together: Collection[str] = (),
) -> dict[str, float]:
    """Bring every axis of the dwell to its target, those named ``together`` at once, else in their order; their
    read-backs, degrees. ``tell`` hears of a move that is made again.

    Raises as :func:`rig.motion.move.move_and_arrive`.
    """
    return move_all(rig.axes, dwell.targets_deg, together, rig.clock, wait, tell)


def measure(
    rig: OpenRig,
    plan: Plan,
    dwell: Dwell,
    announcement: Announcement,
    wait: Wait,
    chosen: Mapping[str, Reading] = MappingProxyType({}),
) -> Measurement:
    """Settle and read at the attitude the axes have reached. Raises: RigError of the device that failed, WaitEnded."""
    announcement.settle(rig.chance)
    settled = settle_at(rig, plan, wait)
    announcement.read(rig.chance)
    before = look(rig, dwell.targets_deg)
    readings = read_channels(rig, plan, plan.channels, wait, chosen)
    after = look(rig, dwell.targets_deg)
    return Measurement(before, after, readings, settled.is_settled, settled.took_s)


def look(rig: OpenRig, axes: Mapping[str, object]) -> Look:
    """Return the position of every axis and every temperature, now."""
    return Look(
        {name: rig.axes[name].state() for name in axes},
        {name: environment.temperature_degc() for name, environment in rig.environments.items()},
    )


def settle_at(rig: OpenRig, plan: Plan, wait: Wait) -> Settled:
    """Wait until the package is at rest, by the channel that decides it. Raises as the readout, WaitEnded."""
    channel = plan.settle_channel
    settings = plan.dwell
    return settle(readout_of(rig, channel), channel, settings.settle, settings.settle_nplc, rig.clock, wait)


def read_channels(
    rig: OpenRig,
    plan: Plan,
    channels: Sequence[str],
    wait: Wait,
    chosen: Mapping[str, Reading] = MappingProxyType({}),
) -> dict[str, ChannelReading]:
    """Read a burst of each channel, in their order: the readouts that may read together at the same time.

    ``chosen``: how channels are read that are not read as ``[dwell]`` says.

    Raises: RigError of the readout that failed, WaitEnded; none is left reading.
    """
    turns: dict[str, list[str]] = {}
    for channel in channels:
        readout = channel.partition(".")[0]
        turns.setdefault(readout if readout in plan.reading_together else "", []).append(channel)

    def read_turn(turn: Sequence[str], wait_beside: Wait) -> dict[str, ChannelReading]:
        as_planned = Reading(plan.dwell.samples, plan.dwell.nplc)
        readings = {channel: chosen.get(channel, as_planned) for channel in turn}
        return {
            channel: read_channel(rig, channel, reading.samples, wait_beside, reading.nplc)
            for channel, reading in readings.items()
        }

    alone = read_turn(turns.pop("", []), wait)
    if len(turns) < 2:
        found = [read_turn(turn, wait) for turn in turns.values()]
    else:
        works = {readout: partial(read_turn, turn) for readout, turn in turns.items()}
        found = list(side_by_side(works, rig.clock, wait).values())
    readings = {channel: reading for found_readings in [alone, *found] for channel, reading in found_readings.items()}
    return {channel: readings[channel] for channel in channels}


def read_channel(rig: OpenRig, channel: str, samples: int, wait: Wait, nplc: float | None = None) -> ChannelReading:
    """Read one burst, overloaded readings as NaN. ``nplc``: None for what the rig file says."""
    burst = readout_of(rig, channel).read(channel, samples, wait, nplc)
    crash_point(CrashPoint.ACQUIRING)
    values = burst.samples.copy()
    values[burst.overload] = float("nan")
    return ChannelReading(channel, values, burst.started_s, burst.interval_s, burst.unit)


def readout_of(rig: OpenRig, channel: str) -> Readout:
    """Return what answers for a full channel name: ``readout.channel``, or ``stream.channel`` read on demand."""
    name = channel.partition(".")[0]
    return rig.readouts[name] if name in rig.readouts else StreamedReadout(rig.streams[name], rig.clock)
