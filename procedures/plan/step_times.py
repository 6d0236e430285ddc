"""How long each step of a plan takes by the files alone, in parts that a journal can be compared with.

A part has a name, such as ``move pitch up to 30 deg`` or ``settle``, under which what it really took is learned
(:mod:`procedures.plan.learned_times`). Moves and readings are counted one after the other, or at once where the rig
file says so, as they are made. The numbers that no file tells are those of the twins.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from types import MappingProxyType
from typing import NamedTuple

from procedures.description.dwell_settings import DwellSettings
from procedures.plan.adaptive import Reading
from procedures.plan.steps import Dwell, Follow, Rest, Soak, Step, Turn
from procedures.plan.windows import FEWEST_READINGS
from rig.description.device_settings import AxisSettings
from rig.description.rig_file import RigDescription

COUPLING_S = 1.3
"""Lifting, seating and locking a curvic coupling, as the twin does it; added to every move of an indexing axis."""
GATHERING_DPS2 = 40.0
"""Acceleration of an axis that turns on and on, as the twins have it."""
SEEN_S = 0.1
"""Until an axis that arrived is seen there."""
HOMING_S, ENDING_S = 0.5, 3.0
"""An axis that stands at its home, beside its coupling; the standstill at the end of a run."""
STANDSTILL_S = 1.0
"""To see an axis rest that was told to stop."""
LEADING_S = 4.3
"""Before and behind a motion that is followed: recorded at rest, and every axis seen at rest."""
STREAM_S, STREAM_SAMPLES = 0.12, 1.6
"""Until a stream that is started has sent: seconds, and samples beside those that are wanted."""
SWEEP_MARGIN = 0.05
"""Of a sweep at either end, where the axis gathers and loses speed: nothing is recorded there."""
HANDLING_S = 30.0
"""An operator at a coil."""
RAMPING_S_PER_DEGC = 18.0
LABORATORY_DEGC = 20.0
"""Where a chamber begins."""
SIZES_DEG = (1.0, 3.0, 10.0, 30.0, 100.0)
BEGIN, END, SETTLE, SOAK, RAMP, AGAIN = "begin", "end", "settle", "soak", "ramp of the chamber", "measured again"
MOVE = "move"


class StepPart(NamedTuple):
    """A part of one step; ``step`` is None for what belongs to the run as a whole."""

    step: int | None
    name: str
    expected_s: float


def step_parts(
    rig: RigDescription,
    steps: Sequence[Step],
    dwell: DwellSettings,
    channels: Sequence[str],
    readings: Mapping[str, Reading] = MappingProxyType({}),
) -> Iterator[StepPart]:
    """Yield the parts of every step in the order given, then those of the run as a whole.

    ``readings``: of channels that are not read as ``[dwell]`` says.
    """
    together = rig.moving_together()
    times = _ReadingTimes.of(rig, dwell, channels, readings)
    single_window_s = window_s(rig, dwell, channels[0])
    settling_s = earliest_settling_s(dwell, single_window_s)
    axes: Collection[str] = ()
    stands_deg = {name: axis.home_attitude_deg for name, axis in rig.axes.items()}
    degc, applied = LABORATORY_DEGC, None
    for step in steps:
        if isinstance(step, Soak):
            yield StepPart(step.step, RAMP, RAMPING_S_PER_DEGC * abs(step.setpoint_degc - degc))
            yield StepPart(step.step, SOAK, step.soak_s)
            degc = step.setpoint_degc
            continue
        yield from _ways(rig.axes, step, stands_deg, together)
        if step.applied != applied and applied is not None:
            yield StepPart(step.step, "operator at the coil", HANDLING_S)
        applied = step.applied or applied
        if not isinstance(step.motion, Turn | Follow):
            yield StepPart(step.step, SETTLE, settling_s)
        yield StepPart(step.step, reading_name(step), _reading_s(rig, step, times))
        axes = step.targets_deg.keys()
        stands_deg = stands_deg | _left_at(step, rig.axes)
    homing_s = sum(HOMING_S + (COUPLING_S if rig.axes[name].increment_deg > 0.0 else 0.0) for name in axes)
    yield StepPart(None, BEGIN, homing_s)
    yield StepPart(None, END, ENDING_S)


@dataclass(frozen=True, slots=True)
class _ReadingTimes:
    """How long the readings of a dwell take."""

    turning_s: float
    """While an axis turns, whose rate is watched between the channels: one channel after the other."""
    resting_s: float
    """Readouts that read together at the same time, the others one after the other."""
    streamed_s: float
    """Of streams, all at once."""
    starting_s: float
    """Until the slowest of the streams that are read has sent what is wanted."""
    reference_s: float
    """What a reference tells of the attitude before."""

    @classmethod
    def of(
        cls, rig: RigDescription, dwell: DwellSettings, channels: Sequence[str], readings: Mapping[str, Reading]
    ) -> "_ReadingTimes":
        reference = rig.attitude_reference
        reference_s = 0.0
        if reference is not None:
            reference_s = sum(burst_s(rig, channel, reference.samples) for channel in reference.channels.values())
            reference_s *= 2.0 if reference.closes_loop else 1.0
        readout_s: dict[str, float] = {}
        for channel in channels:
            name = channel.partition(".")[0]
            reading = readings.get(channel, Reading(dwell.samples, dwell.nplc))
            seconds = burst_s(rig, channel, reading.samples, reading.nplc)
            readout_s[name] = readout_s.get(name, 0.0) + seconds if name in rig.readouts else seconds
        in_turn_s = sum(seconds for name, seconds in readout_s.items() if name in rig.readouts)
        beside_s = [readout_s[name] for name in rig.reading_together() if name in readout_s]
        streams = [name for name in readout_s if name in rig.streams]
        return cls(
            turning_s=in_turn_s,
            resting_s=in_turn_s - sum(beside_s) + max(beside_s, default=0.0),
            streamed_s=max((readout_s[name] for name in streams), default=0.0),
            starting_s=max((_starting_s(rig.streams[name].samples_hz()) for name in streams), default=0.0),
            reference_s=reference_s,
        )


def reading_name(step: Dwell) -> str:
    """Return the name of what is done at the attitude of a dwell, behind the settling."""
    match step.motion:
        case Turn(sweep_deg=None):
            return "turn"
        case Turn():
            return "sweep"
        case Follow():
            return "follow"
        case Rest():
            return "rest"
    return "read"


def _reading_s(rig: RigDescription, step: Dwell, readings: _ReadingTimes) -> float:
    match step.motion:
        case Turn(sweep_deg=None) as turn:
            reading_s = max(turn.seconds, readings.turning_s) + readings.starting_s
            return reading_s + abs(turn.rate_dps) / GATHERING_DPS2 + 2.0 * STANDSTILL_S
        case Turn() as turn:
            return _sweeping_s(rig.axes[turn.turned_axis], turn, readings.starting_s)
        case Follow() as follow:
            return follow.seconds + LEADING_S
        case Rest() as rest:
            return max(rest.rest_seconds + readings.starting_s, readings.resting_s) + readings.reference_s
    return max(readings.resting_s, readings.streamed_s) + readings.reference_s


def _sweeping_s(axis: AxisSettings, turn: Turn, starting_s: float) -> float:
    """Every sweep leaves its begin, is read and stopped; between them the axis goes back."""
    assert turn.sweep_deg is not None
    rate_dps, margin_deg = abs(turn.rate_dps), SWEEP_MARGIN * abs(turn.sweep_deg[1] - turn.sweep_deg[0])
    read_s = turn.seconds / turn.sweeps + starting_s
    back_s = _way_s(axis, margin_deg + rate_dps * read_s)
    return turn.sweeps * (margin_deg / rate_dps + read_s + STANDSTILL_S) + (turn.sweeps - 1) * back_s


def _left_at(step: Dwell, axes: Mapping[str, AxisSettings]) -> dict[str, float]:
    """Return where the axes are known to stand behind a dwell; cumulative where one has turned on and on."""
    stands_deg = dict(step.targets_deg)
    match step.motion:
        case Turn(sweep_deg=None) as turn:
            turned_deg = 360.0 * turn.revolutions + abs(turn.rate_dps) * STREAM_SAMPLES
            stands_deg[turn.turned_axis] += turned_deg if turn.rate_dps > 0.0 else -turned_deg
        case Turn(sweep_deg=(begin_deg, end_deg)) as turn:
            way_deg = SWEEP_MARGIN * abs(end_deg - begin_deg) + abs(turn.rate_dps) * turn.seconds / turn.sweeps
            part = min(way_deg / abs(end_deg - begin_deg), 1.0)
            stands_deg[turn.turned_axis] = begin_deg + part * (end_deg - begin_deg)
        case Follow() as follow:
            stands_deg |= {name: stands_deg[name] + span for name, span in follow.span_deg.items() if name in axes}
    return stands_deg


def _ways(
    axes: Mapping[str, AxisSettings], step: Dwell, from_deg: Mapping[str, float], together: Collection[str]
) -> Iterator[StepPart]:
    """Yield the moves of one dwell that take time: those of axes that move together as one."""
    alone: dict[str, tuple[str, float, float]] = {}
    beside: list[tuple[str, float, float]] = []
    for name, end_deg in step.targets_deg.items():
        way = (name, abs(end_deg - from_deg[name]), axis_move_s(axes[name], from_deg[name], end_deg))
        if way[2] > 0.0 and name in together:
            beside.append(way)
        elif way[2] > 0.0:
            alone[name] = way
    if beside:
        _, size_deg, seconds = max(beside, key=lambda way: way[2])
        yield StepPart(step.step, _move_name(", ".join(name for name, _, _ in beside), size_deg), seconds)
    for name, size_deg, seconds in alone.values():
        yield StepPart(step.step, _move_name(name, size_deg), seconds)


def _move_name(axes: str, size_deg: float) -> str:
    within_deg = next((size for size in SIZES_DEG if size_deg <= size), None)
    return f"{MOVE} {axes} " + (f"over {SIZES_DEG[-1]:g} deg" if within_deg is None else f"up to {within_deg:g} deg")


def axis_move_s(axis: AxisSettings, start_deg: float, end_deg: float) -> float:
    """Return how long an axis moves.

    An axis that is approached from one side goes back to the approach even where it stands at its target.
    """
    if axis.approach_deg == 0.0:
        return _way_s(axis, abs(end_deg - start_deg)) if start_deg != end_deg else 0.0
    return _way_s(axis, abs(end_deg + axis.approach_deg - start_deg)) + _way_s(axis, abs(axis.approach_deg))


def _way_s(axis: AxisSettings, turned_deg: float) -> float:
    """Return the seconds of one way: gathering and losing speed where the axis is made to turn, and its coupling."""
    if axis.increment_deg > 0.0:
        return turned_deg / axis.speed_dps + COUPLING_S
    if axis.turning != "revolves":
        return turned_deg / axis.speed_dps + SEEN_S
    gathered_deg = axis.speed_dps**2 / GATHERING_DPS2
    if turned_deg < gathered_deg:
        return 2.0 * sqrt(turned_deg / GATHERING_DPS2) + SEEN_S
    return turned_deg / axis.speed_dps + axis.speed_dps / GATHERING_DPS2 + SEEN_S


def window_s(rig: RigDescription, dwell: DwellSettings, channel: str) -> float:
    """Return the length of one settle window: as its fewest readings take, where that is longer than asked for."""
    return max(dwell.settle.window_s, burst_s(rig, channel, FEWEST_READINGS, dwell.settle_nplc))


def earliest_settling_s(dwell: DwellSettings, single_window_s: float) -> float:
    """Return the shortest time in which a package can be found at rest: whole windows."""
    return max(dwell.settle.windows, ceil(dwell.settle.min_s / single_window_s)) * single_window_s


def burst_s(rig: RigDescription, channel: str, samples: int, nplc: float | None = None) -> float:
    """Return the seconds for so many readings of ``readout.channel``, or samples of a stream from its start.

    ``nplc``: None for the readout's own.
    """
    name = channel.partition(".")[0]
    if name in rig.readouts:
        return samples * rig.readouts[name].reading_s(nplc)
    rate_hz = rig.streams[name].samples_hz()
    return samples / rate_hz + _starting_s(rate_hz)


def _starting_s(rate_hz: float) -> float:
    return STREAM_S + STREAM_SAMPLES / rate_hz
