"""Is the package mounted, wired and scaled as the rig file declares: judged from a handful of attitudes.

A body axis that points along the table's +z must read about S·f_z at every attitude. The six table axes, signed, are
tried one after the other with the nominal sensitivity; the offset is free. Where another one explains the readings
much better than the declared one, the mount or the wiring contradicts the file, and the sentence names both.
f = (sin α, −cos α sin R, −cos α cos R). Source: TP (2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force
from ams.inputs.declared_direction import GAIN_RANGE
from procedures.records.dwells import DwellRecord, read_back_rad
from rig.description.rig_file import Sensor

FEWEST_ATTITUDES = 4
CLEARLY = 0.25
"""The best axis contradicts the declared one where it leaves less than this share of its sum of squares."""
LEAST_SPREAD_G = 0.25
"""Root mean square about the mean of what an axis should feel; below, these attitudes cannot tell."""

_SIGNED_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")


@dataclass(frozen=True, slots=True)
class _Try:
    """One table axis as the explanation of one channel."""

    axis: str
    spread_g: float
    gain: float
    misfit_v2: float


def contradictions(name: str, sensor: Sensor, dwells: Sequence[DwellRecord]) -> tuple[str, ...]:
    """Return what speaks against the declared mount, one sentence a channel.

    Empty where nothing does, or nothing can.
    """
    if len(dwells) < FEWEST_ATTITUDES or not sensor.is_sensitivity_declared:
        return ()
    force_g = _table_force_g(dwells, rolls=sensor.rolls)
    found = []
    for axis, channel in sensor.channels.items():
        outputs_v = np.array([dwell.readings[channel].mean for dwell in dwells])
        nominal_v_per_g = sensor.nominal_v_per_g(axis)
        contradiction = _contradiction(outputs_v, force_g, getattr(sensor.mount, axis), nominal_v_per_g)
        if contradiction:
            found.append(f"{name}.{axis} ({channel}): {contradiction}")
    return tuple(found)


def _contradiction(outputs_v: FloatArray, force_g: FloatArray, declared: str, nominal_v_per_g: float) -> str:
    tries = {axis: _try(outputs_v, _along(force_g, axis), axis, nominal_v_per_g) for axis in _SIGNED_AXES}
    stated, best = tries[declared], min(tries.values(), key=lambda attempt: attempt.misfit_v2)
    if stated.spread_g < LEAST_SPREAD_G:
        return ""
    if float(outputs_v.std()) < 0.1 * stated.spread_g * abs(nominal_v_per_g):
        return f"does not respond: it changed by {np.ptp(outputs_v):.3g} V over {outputs_v.size} attitudes"
    if best.axis != declared and best.misfit_v2 < CLEARLY * stated.misfit_v2:
        what = "polarity reversed" if best.axis[1] == declared[1] else "another axis"
        return f"declared along {declared} of the table, but it reads as {best.axis}: {what}"
    if not GAIN_RANGE[0] <= stated.gain <= GAIN_RANGE[1]:
        return (
            f"sensitivity about {stated.gain * nominal_v_per_g:.3g} V/g, declared {nominal_v_per_g:g} V/g, allowed "
            f"{GAIN_RANGE[0]:g} to {GAIN_RANGE[1]:g} times that"
        )
    return ""


def _try(outputs_v: FloatArray, along_g: FloatArray, axis: str, nominal_v_per_g: float) -> _Try:
    outputs_v, along_g = outputs_v - outputs_v.mean(), along_g - along_g.mean()
    squares_g2 = float(along_g @ along_g)
    gain = float(along_g @ outputs_v) / (squares_g2 * nominal_v_per_g) if squares_g2 > 0.0 else 0.0
    misfit_v = outputs_v - nominal_v_per_g * along_g
    return _Try(axis, float(np.sqrt(squares_g2 / along_g.size)), gain, float(misfit_v @ misfit_v))


def _along(force_g: FloatArray, axis: str) -> FloatArray:
    sign = 1.0 if axis[0] == "+" else -1.0
    return sign * force_g[:, "xyz".index(axis[1])]


def _table_force_g(dwells: Sequence[DwellRecord], *, rolls: bool) -> FloatArray:
    """Return (K, 3) of specific force in the axes of the stage at the read-back attitudes, 1 g local gravity."""
    pitch, roll, yaw = read_back_rad(dwells)
    return np.asarray(specific_force(pitch, roll if rolls else 0.0 * roll, yaw))
