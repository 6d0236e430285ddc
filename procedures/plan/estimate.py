"""How long a plan takes, from what the files say about the devices.

p50 lets every dwell settle at the earliest time its settings allow and repeats none. p90 adds one more window to
every settling and repeats one dwell in twenty: a bad night of a sound rig. Moves and readings are counted one after
the other, or at once where the rig file says so, as they are made.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

from procedures.description.procedure_file import DwellSettings
from procedures.plan.plan import Expectation
from procedures.plan.steps import Dwell, Follow, Rest, Soak, Step, Turn
from procedures.plan.windows import FEWEST_READINGS
from rig.description.device_settings import AxisSettings
from rig.description.rig_file import RigDescription

REPEATED_P90 = 0.05
"""Share of dwells that are measured again on a bad night."""
COUPLING_S = 1.3
"""Lifting, seating and locking a curvic coupling, as the twin does it; added to every move of an indexing axis."""
RAMP_S = 4.0
"""To come to speed and to rest again, and to be seen there."""
HANDLING_S = 30.0
"""An operator at a coil."""


def expected_duration(
    rig: RigDescription, steps: Sequence[Step], dwell: DwellSettings, channels: Sequence[str]
) -> Expectation:
    """Return the duration of ``steps`` in the order given: ways, soaks, settling, what is read, ramps, an operator."""
    dwells = [step for step in steps if isinstance(step, Dwell)]
    together = rig.moving_together()
    moving_s = sum(move_s(rig.axes, one.targets_deg, other.targets_deg, together) for one, other in pairwise(dwells))
    soaking_s = sum(step.soak_s for step in steps if isinstance(step, Soak))
    handling_s = HANDLING_S * sum(one.applied != other.applied for one, other in pairwise(dwells))
    one_window_s = window_s(rig, dwell, channels[0])
    settling_s = earliest_settling_s(dwell, one_window_s)
    reading = _Reading.of(rig, dwell, channels)
    taken_s = sum(_dwell_s(rig, one, settling_s, reading) for one in dwells)
    again_s = REPEATED_P90 * (taken_s + len(dwells) * one_window_s)
    p50_s = moving_s + soaking_s + handling_s + taken_s
    return Expectation(p50_s=p50_s, p90_s=p50_s + len(dwells) * one_window_s + again_s)


@dataclass(frozen=True, slots=True)
class _Reading:
    """How long the samples of ``[dwell]`` take, with what a reference tells of the attitude before."""

    turning_s: float
    """While an axis turns, whose rate is watched between the channels: one channel after the other."""
    resting_s: float
    """Readouts that read together at the same time, the others one after the other."""
    streamed_s: float
    """Of streams, all at once."""

    @classmethod
    def of(cls, rig: RigDescription, dwell: DwellSettings, channels: Sequence[str]) -> "_Reading":
        reference = rig.attitude_reference
        told_s = (
            sum(reference.samples * channel_reading_s(rig, channel) for channel in reference.channels.values())
            if reference
            else 0.0
        )
        readout_s: dict[str, float] = {}
        for channel in channels:
            name = channel.partition(".")[0]
            burst_s = dwell.samples * channel_reading_s(rig, channel, dwell.nplc)
            readout_s[name] = readout_s.get(name, 0.0) + burst_s if name in rig.readouts else burst_s
        together = rig.reading_together()
        in_turn_s = sum(seconds for name, seconds in readout_s.items() if name in rig.readouts)
        beside_s = [readout_s[name] for name in together if name in readout_s]
        resting_s = in_turn_s - sum(beside_s) + max(beside_s, default=0.0)
        streamed_s = max((seconds for name, seconds in readout_s.items() if name not in rig.readouts), default=0.0)
        return cls(in_turn_s + told_s, resting_s + told_s, streamed_s)


def _dwell_s(rig: RigDescription, dwell: Dwell, settling_s: float, reading: _Reading) -> float:
    match dwell.motion:
        case Turn():
            turn, axis = dwell.motion, rig.axes[dwell.motion.turned_axis]
            back_deg = (
                turn.sweeps * abs(turn.sweep_deg[1] - turn.sweep_deg[0])
                if turn.sweep_deg
                else 360.0 * (turn.revolutions + 0.5)
            )
            sweeping_s = back_deg / abs(turn.rate_dps) if turn.sweep_deg else max(turn.seconds, reading.turning_s)
            return sweeping_s + back_deg / axis.speed_dps + RAMP_S * max(turn.sweeps, 1)
        case Follow():
            return dwell.motion.seconds + RAMP_S
        case Rest():
            return settling_s + max(dwell.motion.rest_seconds, reading.resting_s)
    return settling_s + max(reading.resting_s, reading.streamed_s)


def window_s(rig: RigDescription, dwell: DwellSettings, channel: str) -> float:
    """Return the length of one settle window: as its fewest readings take, where that is longer than asked for."""
    reading_s = channel_reading_s(rig, channel, dwell.settle_nplc)
    return max(dwell.settle.window_s, FEWEST_READINGS * reading_s)


def earliest_settling_s(dwell: DwellSettings, one_window_s: float) -> float:
    """Return the shortest time in which a package can be found at rest: whole windows."""
    return max(dwell.settle.windows, ceil(dwell.settle.min_s / one_window_s)) * one_window_s


def move_s(
    axes: Mapping[str, AxisSettings],
    start_deg: Mapping[str, float],
    end_deg: Mapping[str, float],
    together: Collection[str] = (),
) -> float:
    """Seconds from one attitude to another, approach included; axes named ``together`` at once, the others in turn."""
    seconds = {name: _axis_move_s(axes[name], start_deg[name], end) for name, end in end_deg.items()}
    at_once_s = max((seconds[name] for name in seconds if name in together), default=0.0)
    return at_once_s + sum(seconds[name] for name in seconds if name not in together)


def _axis_move_s(axis: AxisSettings, start_deg: float, end_deg: float) -> float:
    """Return how long an axis moves.

    An axis that is approached from one side goes back to the approach even where it stands at its target.
    """
    coupling_s = COUPLING_S if axis.increment_deg > 0.0 else 0.0
    if axis.approach_deg == 0.0:
        return abs(end_deg - start_deg) / axis.speed_dps + coupling_s if start_deg != end_deg else 0.0
    turned_deg = abs(end_deg + axis.approach_deg - start_deg) + abs(axis.approach_deg)
    return turned_deg / axis.speed_dps + 2.0 * coupling_s


def channel_reading_s(rig: RigDescription, channel: str, nplc: float | None = None) -> float:
    """Seconds for one reading of ``readout.channel``, one sample of a stream; ``nplc`` None: the readout's own."""
    name = channel.split(".", 1)[0]
    return rig.readouts[name].reading_s(nplc) if name in rig.readouts else 1.0 / rig.streams[name].samples_hz()
