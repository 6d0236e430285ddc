"""Numbers of motion that the machine cannot be told, or that its own file forbids: refused before any port is opened.

A driver that clamps such a number, or a controller that refuses it, would be met when an axis is to move. What a
controller alone knows (the top speed of its stage) is asked when a line is opened, and refused there.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from rig.description.device_settings import AxisSettings
from rig.description.rig_file import RigDescription
from rig.errors import DescriptionError
from rig.toml_file import TomlFile

FASTEST_DPS: Final = 36_000.0
"""A hundred turns a second: nothing that carries a sensor turns faster."""
WIDEST_ARRIVAL_DEG: Final = 1.0
"""An axis that far beside its target has not arrived there, whatever it is."""
FINE_DEG: Final = 0.01
"""A drive of finer steps has no teeth: it may come to rest some of them beside its target."""
_ROUNDING_DEG: Final = 1e-9


def impossible_motion(file: TomlFile, rig: RigDescription) -> Iterator[str]:
    """Yield every speed, rate, acceleration and tolerance of an axis that is none of its machine's."""
    for name, axis in rig.axes.items():
        slowest_dps, fastest_dps = axis.speed_range_dps
        fastest_dps = min(fastest_dps, FASTEST_DPS)
        top_dps = getattr(axis, "top_rate_dps", None)
        for key, value in (("speed_dps", axis.speed_dps), ("top_rate_dps", top_dps)):
            if value is not None and not slowest_dps <= value <= fastest_dps:
                yield file.complaint(
                    ("axes", name, key),
                    f"got {value:g} °/s, allowed is {slowest_dps:.3g} to {fastest_dps:.6g} °/s, which driver "
                    f"{axis.driver} can tell such a machine; nothing moved; correct the number, or its unit",
                )
        if top_dps is not None and axis.speed_dps > top_dps:
            yield file.complaint(
                ("axes", name, "speed_dps"),
                f"got {axis.speed_dps:g} °/s, allowed is up to {top_dps:g} °/s, the largest rate of the axis "
                "(top_rate_dps); lower it, or correct that",
            )
        for key, sentence in axis.motion_complaints():
            yield file.complaint(("axes", name, key), sentence)
        if why := _home_outside(axis, file.path.parent):
            yield file.complaint(
                ("axes", name, "limits_deg"),
                f"{why}, and every run homes it before anything else; nothing moved; take the home into limits_deg, or "
                f"correct it ({axis.home_key})",
            )
        beside_deg = max(0.5 * axis.increment_deg, FINE_DEG) if axis.increment_deg else WIDEST_ARRIVAL_DEG
        widest_deg = min(WIDEST_ARRIVAL_DEG, beside_deg)
        if axis.arrival_tolerance_deg >= widest_deg:
            why = (
                "half its increment_deg: it would count as there beside the next index"
                if 0.5 * axis.increment_deg >= FINE_DEG
                else "farther off it is at another attitude"
            )
            yield file.complaint(
                ("axes", name, "arrival_tolerance_deg"),
                f"got {axis.arrival_tolerance_deg:g}°, allowed is below {widest_deg:g}° ({why}); correct the number, "
                "or its unit",
            )


def home_beyond_limits(limits_deg: tuple[float, float], home_deg: float) -> str:
    """Return why an axis is not homed whose homing ends at the attitude ``home_deg``; empty where it may be."""
    low_deg, high_deg = limits_deg
    if low_deg - _ROUNDING_DEG <= home_deg <= high_deg + _ROUNDING_DEG:
        return ""
    return f"homing brings it to {home_deg:g}°, outside its limits, allowed {low_deg:g} to {high_deg:g}° (limits_deg)"


def _home_outside(axis: AxisSettings, folder: Path) -> str:
    """Return why homing would leave the limits; empty where it does not, or moves nothing."""
    try:
        moves = axis.with_files(folder).moves_to_home
    except DescriptionError:
        return ""  # told of the dialect itself
    return home_beyond_limits(axis.limits_deg, axis.home_attitude_deg) if moves else ""
