"""Homing keeps the limits: nothing is sent to a home outside them, and what homes without a motion stands inside."""

from rig.abilities.abilities import Axis, AxisState
from rig.description.motion_limits import home_beyond_limits
from rig.errors import DeviceFault, RequestRefused
from rig.motion.expectation import WHOLE_TURN_DEG
from rig.motion.standstill import is_inside


def require_home_inside(axis: Axis, home_deg: float | None) -> None:
    """Refuse to home an axis to outside its limits; None: homing moves nothing. Raises: RequestRefused."""
    if home_deg is not None and (why := home_beyond_limits(axis.limits_deg, home_deg)):
        raise RequestRefused(
            f"{axis.name}: home: {why}; nothing moved; take the home into the limits (axes.{axis.name}: limits_deg)"
        )


def require_inside(axis: Axis, state: AxisState) -> None:
    """Refuse to go on with an axis that homes without a motion and stands outside its limits. Raises: DeviceFault.

    One that turns on and on has none where they are a whole turn or more apart.
    """
    low_deg, high_deg = axis.limits_deg
    has_none = getattr(axis, "top_rate_dps", 0.0) > 0.0 and high_deg - low_deg >= WHOLE_TURN_DEG
    if state.is_homed and not has_none and not is_inside(axis, state.position_deg):
        raise DeviceFault(
            f"{axis.name}: home: its positions are absolute and it stands at {state.position_deg:g}°, outside its"
            f" limits, allowed {low_deg:g} to {high_deg:g}° (axes.{axis.name}: limits_deg); nothing moved; see what"
            f" moved it there, then bring it inside by calrig jog --to"
        )
