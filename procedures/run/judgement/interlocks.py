"""Bands with hysteresis and delay, as values: what was seen of a quantity, and what follows from it.

A value outside its band for ``delay_s`` alarms; it is over when the value was inside by the hysteresis for as long.
A value that is not finite is outside every band. Dwells taken since the band was last seen kept are void, so the
state remembers when that was.
"""

from dataclasses import dataclass, replace
from math import isfinite
from typing import Literal

Action = Literal["hold", "trip"]


@dataclass(frozen=True, slots=True)
class Interlock:
    """One watched quantity."""

    name: str
    """For messages, such as ``environment.air``."""
    unit: str
    low: float
    high: float
    hysteresis: float
    delay_s: float
    action: Action
    key: str
    """Where the band is declared, such as ``rig.toml: interlocks.temperature.air``."""

    def sentence(self, value: float) -> str:
        """Return the sentence of an alarm."""
        return (
            f"{self.name}: got {value:.6g} {self.unit}, allowed {self.low:g} to {self.high:g} {self.unit} ({self.key})"
        )


@dataclass(frozen=True, slots=True)
class Watched:
    """What is known of a quantity; seconds are the rig's."""

    kept_until_s: float | None = None
    """When it was last seen inside, before the alarm; None before the first look."""
    outside_since_s: float | None = None
    inside_since_s: float | None = None
    is_alarmed: bool = False


def look_at(lock: Interlock, before: Watched, value: float, now_s: float) -> Watched:
    """Return what one more look makes of a watched interlock."""
    margin = lock.hysteresis if before.is_alarmed else 0.0
    if isfinite(value) and lock.low + margin <= value <= lock.high - margin:
        return _inside(lock, before, now_s)
    since_s = now_s if before.outside_since_s is None else before.outside_since_s
    is_alarmed = before.is_alarmed or now_s - since_s >= lock.delay_s
    return replace(before, outside_since_s=since_s, inside_since_s=None, is_alarmed=is_alarmed)


def _inside(lock: Interlock, before: Watched, now_s: float) -> Watched:
    since_s = now_s if before.inside_since_s is None else before.inside_since_s
    if before.is_alarmed and now_s - since_s < lock.delay_s:
        return replace(before, outside_since_s=None, inside_since_s=since_s)
    return Watched(kept_until_s=now_s, inside_since_s=since_s)
