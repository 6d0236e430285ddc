"""The last check before an axis is sent anywhere: every driver calls it, whoever checked before."""

import math

from rig.errors import RequestRefused

_GRID_TOLERANCE = 1e-6
"""Largest distance from a multiple of the increment, in increments, that counts as rounding."""


def check_target(
    name: str, target_deg: float, table_deg: float, limits_deg: tuple[float, float], increment_deg: float
) -> None:
    """Refuse a target that is not finite, outside the limits or between two teeth.

    ``target_deg`` is the attitude, ``table_deg`` the angle that the machine is told. Raises: RequestRefused.
    """
    if not math.isfinite(target_deg):
        raise RequestRefused(
            f"{name}: move to {target_deg}: not a number of degrees; nothing moved; give a finite angle"
        )
    low_deg, high_deg = limits_deg
    if not low_deg <= target_deg <= high_deg:
        raise RequestRefused(
            f"{name}: move to {target_deg:g} deg: outside the limits, allowed {low_deg:g} to {high_deg:g} deg"
            f" (axes.{name}: limits_deg); nothing moved; ask for an angle inside"
        )
    if not is_on_increment(table_deg, increment_deg):
        raise RequestRefused(
            f"{name}: move to {target_deg:g} deg: the machine stops only at multiples of {increment_deg:g} deg"
            f" (axes.{name}: increment_deg); nothing moved; ask for a multiple"
        )


def nearest_step(step: float, limits: tuple[float, float]) -> int:
    """The whole step of a machine nearest to ``step`` and not beyond ``limits``, given in steps in any order."""
    low, high = sorted(limits)
    return min(max(round(step), math.ceil(low - _GRID_TOLERANCE)), math.floor(high + _GRID_TOLERANCE))


def is_on_increment(table_deg: float, increment_deg: float) -> bool:
    """True for a multiple of the increment, and always on a continuous axis (increment 0)."""
    if increment_deg == 0.0:
        return True
    teeth = table_deg / increment_deg
    return abs(teeth - round(teeth)) <= _GRID_TOLERANCE * max(1.0, abs(teeth) * 1e-3)
