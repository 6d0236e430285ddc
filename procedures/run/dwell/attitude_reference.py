"""A reference sensor that tells the attitude: measured, not commanded, and where asked for the loop closed on it."""

from statistics import fmean

from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell
from procedures.run.dwell.measure import OpenRig
from procedures.run.dwell.stream_readout import StreamedReadout
from rig.devices.abilities import Wait
from rig.errors import DeviceFault
from rig.motion.move import move_and_arrive


def reference_attitude(rig: OpenRig, plan: Plan, wait: Wait) -> dict[str, float]:
    """Axis to the mean angle that the reference tells, degrees; empty where none is declared."""
    reference = plan.attitude_reference
    if reference is None:
        return {}
    angles_deg = {}
    for axis, channel in reference.channels.items():
        stream = rig.streams[channel.partition(".")[0]]
        angles_deg[str(axis)] = fmean(StreamedReadout(stream, rig.clock).read(channel, reference.samples, wait).samples)
    return angles_deg


def approach(rig: OpenRig, plan: Plan, dwell: Dwell, wait: Wait) -> dict[str, float]:
    """Correct the axes until the reference says that they are there; where they then stand by their own read-back.

    Raises: DeviceFault where that takes too many corrections, RequestRefused where one leads beyond the limits.
    """
    reference = plan.attitude_reference
    if reference is None:
        return {}
    commanded = {name: rig.axes[name].state().position_deg for name in dwell.targets_deg}
    if not reference.closes_loop:
        return commanded
    for _ in range(reference.corrections + 1):
        reference_deg = reference_attitude(rig, plan, wait)
        off = {
            name: _turned(dwell.targets_deg[name] - reference_deg[name])
            for name in reference_deg
            if name in dwell.targets_deg
        }
        if all(abs(error) <= reference.tolerance_deg for error in off.values()):
            return commanded
        for name, error in off.items():
            axis = rig.axes[name]
            wanted_deg = axis_step(commanded[name] + error, axis.increment_deg)
            commanded[name] = move_and_arrive(axis, wanted_deg, rig.clock, wait)
    off_text = ", ".join(f"{name} {error:+.3g} deg" for name, error in off.items())
    raise DeviceFault(
        f"attitude_reference: after {reference.corrections} corrections still off by {off_text}, allowed "
        f"{reference.tolerance_deg:g} deg (rig file: attitude_reference.tolerance_deg); the axes rest; look at their "
        "slack and at the reference"
    )


def axis_step(angle_deg: float, increment_deg: float) -> float:
    """Return the nearest angle at which the axis can stop."""
    return round(angle_deg / increment_deg) * increment_deg if increment_deg else round(angle_deg, 6)


def _turned(angle_deg: float) -> float:
    """Return the same turn within ±180°."""
    return (angle_deg + 180.0) % 360.0 - 180.0
