"""Motion by hand and a look at the readings: the same limits, the same arrival, no screen.

Every function needs an open rig, so the lock is held; every wait is the caller's, so a stop reaches the axis.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rig.clock import Clock
from rig.devices.abilities import Axis, Readout, Wait
from rig.errors import RequestRefused
from rig.motion import home_and_arrive, move_and_arrive, trusted_state


class OpenRig(Protocol):
    """What jogging needs of :class:`rig.assembly.Rig`."""

    @property
    def axes(self) -> Mapping[str, Axis]: ...
    @property
    def readouts(self) -> Mapping[str, Readout]: ...
    @property
    def clock(self) -> Clock: ...


@dataclass(frozen=True, slots=True)
class Reading:
    """A channel as the bench sees it."""

    channel: str
    mean_v: float
    """NaN where every reading was an overload."""
    standard_deviation_v: float
    """NaN below two readings."""
    samples: int
    overloads: int


def jog_to(rig: OpenRig, axis: str, target_deg: float, wait: Wait) -> float:
    """Go to an attitude; returns the read-back at rest, degrees. Raises as :func:`rig.motion.move_and_arrive`."""
    return move_and_arrive(_axis(rig, axis), target_deg, rig.clock, wait)


def jog_by(rig: OpenRig, axis: str, step_deg: float, wait: Wait) -> float:
    """Go ``step_deg`` further than the axis stands; it is sent as an absolute target."""
    device = _axis(rig, axis)
    here_deg = trusted_state(device).position_deg
    return move_and_arrive(device, round(here_deg + step_deg, 9), rig.clock, wait)


def home(rig: OpenRig, axis: str, wait: Wait) -> float:
    """Run the reference move; returns the read-back at rest, degrees."""
    return home_and_arrive(_axis(rig, axis), rig.clock, wait)


def readings(rig: OpenRig, channels: Sequence[str], samples: int, wait: Wait) -> list[Reading]:
    """Read channels by full name (``dmm.x``). Raises: RequestRefused for a name the rig does not have."""
    known = {channel: readout for readout in rig.readouts.values() for channel in readout.channels}
    unknown = [channel for channel in channels if channel not in known]
    if unknown:
        raise RequestRefused(f"no channel {unknown[0]!r} (allowed: {', '.join(known)}); nothing was read")
    return [_reading(known[channel], channel, samples, wait) for channel in channels]


def _reading(readout: Readout, channel: str, samples: int, wait: Wait) -> Reading:
    burst = readout.read(channel, samples, wait)
    good_v = burst.values_v[~burst.overload]
    return Reading(
        channel=channel,
        mean_v=float(np.mean(good_v)) if good_v.size else float("nan"),
        standard_deviation_v=float(np.std(good_v, ddof=1)) if good_v.size > 1 else float("nan"),
        samples=int(burst.values_v.size),
        overloads=int(np.count_nonzero(burst.overload)),
    )


def _axis(rig: OpenRig, name: str) -> Axis:
    if name not in rig.axes:
        raise RequestRefused(f"no axis {name!r} (allowed: {', '.join(rig.axes)}); nothing moved")
    return rig.axes[name]
