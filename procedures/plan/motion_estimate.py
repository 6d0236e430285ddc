"""How long plans with motion take: ways, settling, what is read, ramps, returns of sweeps and revolutions."""

from collections.abc import Sequence
from itertools import pairwise

from procedures.description.procedure_file import DwellSettings
from procedures.plan.estimate import channel_reading_s, earliest_settling_s, move_s, window_s
from procedures.plan.plan import Expectation
from procedures.plan.steps import Dwell, Follow, Rest, Step, Turn
from rig.description.rig_file import RigDescription

RAMP_S = 4.0
"""To come to speed and to rest again, and to be seen there."""
HANDLING_S = 30.0
"""An operator at a coil."""


def expected_motion_duration(
    rig: RigDescription, steps: Sequence[Step], dwell: DwellSettings, channels: Sequence[str]
) -> Expectation:
    """Duration of ``steps`` in the order given."""
    dwells = [step for step in steps if isinstance(step, Dwell)]
    moving_s = sum(move_s(rig.axes, one.targets_deg, other.targets_deg) for one, other in pairwise(dwells))
    one_window_s = window_s(rig, dwell, channels[0])
    settling_s = earliest_settling_s(dwell, one_window_s)
    voltages = [channel for channel in channels if channel.partition(".")[0] in rig.readouts]
    reading_s = dwell.samples * sum(channel_reading_s(rig, channel) for channel in voltages)
    streamed_s = max(
        (dwell.samples * channel_reading_s(rig, channel) for channel in channels if channel not in voltages),
        default=0.0,
    )
    p50_s = moving_s + sum(_dwell_s(rig, one, settling_s, reading_s, streamed_s) for one in dwells)
    handled = sum(one.applied != other.applied for one, other in pairwise(dwells))
    p50_s += HANDLING_S * handled
    return Expectation(p50_s, 1.05 * p50_s + len(dwells) * one_window_s)


def _dwell_s(rig: RigDescription, dwell: Dwell, settling_s: float, reading_s: float, streamed_s: float) -> float:
    match dwell.motion:
        case Turn():
            turn, axis = dwell.motion, rig.axes[dwell.motion.turned_axis]
            back_deg = (
                turn.sweeps * abs(turn.sweep_deg[1] - turn.sweep_deg[0])
                if turn.sweep_deg
                else 360.0 * (turn.revolutions + 0.5)
            )
            sweeping_s = back_deg / abs(turn.rate_dps) if turn.sweep_deg else max(turn.seconds, reading_s)
            return sweeping_s + back_deg / axis.speed_dps + RAMP_S * max(turn.sweeps, 1)
        case Follow():
            return dwell.motion.seconds + RAMP_S
        case Rest():
            return settling_s + max(dwell.motion.rest_seconds, reading_s)
    return settling_s + max(reading_s, streamed_s)
