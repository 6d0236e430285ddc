"""What a target of an axis must obey: finite, inside the limits with its one-sided approach, on the increment.

One check for all who ask: the plan before any port is opened, a move before it begins, and every driver just before it
sends, whoever checked before.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, Protocol

from rig.errors import RequestRefused

Rule = Literal["finite", "limits_deg", "increment_deg", "written"]
Miswritten = Callable[[float], str]
"""Why the machine cannot be told of an attitude as its grammar writes it; empty where it can."""
_GRID_TOLERANCE = 1e-6
"""Largest distance from a multiple of the increment, in increments, that counts as rounding."""


class Positioning(Protocol):
    """What the rig file says of the places where an axis may stop."""

    @property
    def limits_deg(self) -> tuple[float, float]: ...
    @property
    def increment_deg(self) -> float: ...
    @property
    def approach_deg(self) -> float: ...
    def table_deg(self, attitude_deg: float, /) -> float: ...
    def attitude_deg(self, table_deg: float, /) -> float: ...


@dataclass(frozen=True, slots=True)
class BrokenRule:
    """One reason why an axis cannot be sent to a target."""

    rule: Rule
    excess_deg: float = 0.0
    """How far beyond the limits, approach included."""
    why: str = ""
    """What would be written."""


def broken_rules(
    target_deg: float,
    table_deg: float,
    limits_deg: tuple[float, float],
    increment_deg: float,
    approach_deg: float = 0.0,
    miswritten: Miswritten = lambda _target_deg: "",
) -> Iterator[BrokenRule]:
    """Tell every rule that a target breaks; none where the axis may be sent there.

    ``target_deg`` is the attitude, ``table_deg`` the angle that the machine is told. What would be written is told of
    targets alone that break no other rule.
    """
    if not math.isfinite(target_deg):
        yield BrokenRule("finite")
        return
    low_deg, high_deg = limits_deg
    way_deg = (target_deg, target_deg + approach_deg)
    if not (low_deg <= min(way_deg) and max(way_deg) <= high_deg):
        yield BrokenRule("limits_deg", max(low_deg - min(way_deg), max(way_deg) - high_deg))
    if not is_on_increment(table_deg, increment_deg):
        yield BrokenRule("increment_deg")
    elif why := next(filter(None, map(miswritten, dict.fromkeys(way_deg))), ""):
        yield BrokenRule("written", why=why)


def check_target(
    name: str, axis: Positioning, target_deg: float, miswritten: Miswritten = lambda _target_deg: ""
) -> None:
    """Refuse a target that is not finite, outside the limits, between two teeth or not to be written.

    The approach is a target of its own, so a driver is asked twice. Raises: RequestRefused.
    """
    table_deg = axis.table_deg(target_deg)
    for broken in broken_rules(target_deg, table_deg, axis.limits_deg, axis.increment_deg, miswritten=miswritten):
        sentence = _sentence(broken, name, target_deg, axis.limits_deg, axis.increment_deg)
        raise RequestRefused(f"{name}: move to {sentence}")


def require_home(name: str, task: str, *, is_homed: bool) -> None:
    """Refuse a task, such as ``move to 10 deg``, of an axis whose zero is not known. Raises: RequestRefused."""
    if not is_homed:
        raise RequestRefused(f"{name}: {task}: the axis is not homed; nothing moved; home it first")


def _sentence(
    broken: BrokenRule, name: str, target_deg: float, limits_deg: tuple[float, float], increment_deg: float
) -> str:
    if broken.rule == "written":
        return f"{target_deg:g}°: {broken.why}; nothing moved; ask for an angle that it can write"
    if broken.rule == "finite":
        return f"{target_deg}: not a number of degrees; nothing moved; give a finite angle"
    if broken.rule == "limits_deg":
        return (
            f"{target_deg:g}°: outside the limits, allowed {limits_deg[0]:g} to {limits_deg[1]:g}°"
            f" (axes.{name}: limits_deg); nothing moved; ask for an angle inside"
        )
    return (
        f"{target_deg:g}°: the machine stops only at multiples of {increment_deg:g}°"
        f" (axes.{name}: increment_deg); nothing moved; ask for a multiple"
    )


def allowed_range_deg(axis: Positioning) -> tuple[float, float]:
    """Return the lowest and highest attitude whose approach stays inside the limits too."""
    low_deg, high_deg = axis.limits_deg
    return low_deg - min(axis.approach_deg, 0.0), high_deg - max(axis.approach_deg, 0.0)


def nearest_targets_deg(axis: Positioning, target_deg: float) -> tuple[float, ...]:
    """Return the allowed attitudes beside a finite target, ascending: one, two, or none where the axis has none."""
    low_deg, high_deg = allowed_range_deg(axis)
    if low_deg > high_deg:
        return ()
    inside_deg = min(max(target_deg, low_deg), high_deg)
    if axis.increment_deg == 0.0:
        return (inside_deg,)
    increment = Decimal(repr(axis.increment_deg))
    tooth = round(Decimal(repr(axis.table_deg(inside_deg))) / increment)
    around = {axis.attitude_deg(float((tooth + step) * increment)) for step in (-1, 0, 1)}
    allowed = sorted(angle for angle in around if low_deg <= angle <= high_deg)
    below = [angle for angle in allowed if angle <= target_deg][-1:]
    above = [angle for angle in allowed if angle >= target_deg][:1]
    return tuple(dict.fromkeys((*below, *above)))


def nearest_step(step: float, limits: tuple[float, float]) -> int:
    """Return the whole step of a machine nearest to ``step`` and not beyond ``limits``, given in steps in any order."""
    low, high = sorted(limits)
    return min(max(round(step), math.ceil(low - _GRID_TOLERANCE)), math.floor(high + _GRID_TOLERANCE))


def is_on_increment(table_deg: float, increment_deg: float) -> bool:
    """Return whether an angle is a multiple of the increment, always so on a continuous axis (increment 0)."""
    if increment_deg == 0.0:
        return True
    teeth = table_deg / increment_deg
    return abs(teeth - round(teeth)) <= _GRID_TOLERANCE
