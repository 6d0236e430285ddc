"""A reference sensor that tells the attitude: measured, not commanded, and where asked for the loop closed on it."""

import math
from collections.abc import Sequence
from statistics import fmean

from ams.frames import wrap_deg
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell
from procedures.run.dwell.measure import OpenRig, read_channel
from rig.abilities.abilities import Wait
from rig.errors import DeviceFault
from rig.motion.move import move_and_arrive


def reference_attitude(rig: OpenRig, plan: Plan, wait: Wait) -> dict[str, float]:
    """Return axis to the mean angle that the reference tells, degrees; empty where none is declared.

    Raises: DeviceFault where it is beyond its range; as the readout or the stream.
    """
    reference = plan.attitude_reference
    if reference is None:
        return {}
    return {
        str(axis): _mean_deg(channel, read_channel(rig, channel, reference.samples, wait).samples.tolist())
        for axis, channel in reference.channels.items()
    }


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
            name: wrap_deg(dwell.targets_deg[name] - reference_deg[name])
            for name in reference_deg
            if name in dwell.targets_deg
        }
        if all(abs(error) <= reference.tolerance_deg for error in off.values()):
            return commanded
        for name, error in off.items():
            axis = rig.axes[name]
            wanted_deg = axis_step(commanded[name] + error, axis.increment_deg)
            commanded[name] = move_and_arrive(axis, wanted_deg, rig.clock, wait)
    off_text = ", ".join(f"{name} {error:+.3g}°" for name, error in off.items())
    raise DeviceFault(
        f"attitude_reference: after {reference.corrections} corrections still off by {off_text}, allowed "
        f"{reference.tolerance_deg:g}° (rig file: attitude_reference.tolerance_deg); the axes rest; look at their "
        "slack and at the reference"
    )


def axis_step(angle_deg: float, increment_deg: float) -> float:
    """Return the nearest angle at which the axis can stop."""
    return round(angle_deg / increment_deg) * increment_deg if increment_deg else round(angle_deg, 6)


def _mean_deg(channel: str, samples_deg: Sequence[float]) -> float:
    """Return the mean of angles that may lie on both sides of where they begin again."""
    if not all(map(math.isfinite, samples_deg)):
        raise DeviceFault(
            f"attitude_reference: {channel} is beyond its range: the attitude is not known; the axes rest; plan"
            " attitudes that it reaches, or measure without it"
        )
    first_deg = samples_deg[0]
    return first_deg + fmean(wrap_deg(sample_deg - first_deg) for sample_deg in samples_deg)
