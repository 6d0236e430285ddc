"""The warm-up gate: at one attitude, a channel must have been on long enough and have come to rest.

Its slope is a straight line through the last looks; it passes when the slope itself, not its uncertainty, is small.
"""

import numpy as np

from procedures.numbers import duration
from procedures.run.dwell.measure import OpenRig
from procedures.run.judgement.run_limits import WarmUp
from rig.abilities.abilities import Wait
from rig.errors import DeviceFault

LOOKS = 10
SAMPLES = 5
_LEAST_PAUSE_S = 6.0
_LONGEST_S = 12.0 * 3600.0


def warm_up(rig: OpenRig, gate: WarmUp, wait: Wait, stand: Wait) -> dict[str, object]:
    """Wait until the gate lets us pass; what was found, for the record. ``stand``: between two looks, ``wait`` in them.

    Raises: DeviceFault after twelve hours of drift, WaitEnded, RigError of the readout.
    """
    clock, readout = rig.clock, rig.readouts[gate.channel.partition(".")[0]]
    pause_s = max(gate.warm_up_s / LOOKS, _LEAST_PAUSE_S)
    began_s, times_s, means_v = clock.monotonic_s(), list[float](), list[float]()
    while True:
        times_s.append(clock.monotonic_s())
        means_v.append(float(readout.read(gate.channel, SAMPLES, wait).samples.mean()))
        took_s = times_s[-1] - began_s
        slope_v_per_h = _slope_v_per_h(times_s[-LOOKS:], means_v[-LOOKS:])
        steady = gate.slope_v_per_h is None or (slope_v_per_h is not None and abs(slope_v_per_h) <= gate.slope_v_per_h)
        if took_s >= gate.warm_up_s and steady:
            return {"channel": gate.channel, "took_s": took_s, "slope_v_per_h": slope_v_per_h}
        if took_s > max(_LONGEST_S, 2.0 * gate.warm_up_s):
            raise DeviceFault(
                f"{gate.channel}: still drifts by {slope_v_per_h:.3g} V/h after {duration(took_s)}, allowed "
                f"{gate.slope_v_per_h:g} V/h (rig file: chain.{gate.channel}.warm_up_slope_v_per_h); nothing was "
                "measured; look at supply, temperature and sensor"
            )
        stand(pause_s)


def _slope_v_per_h(times_s: list[float], means_v: list[float]) -> float | None:
    """Return the slope of the looks so far; None until there are enough."""
    if len(times_s) < LOOKS:
        return None
    return float(np.polyfit(np.array(times_s) - times_s[0], means_v, 1)[0]) * 3600.0
