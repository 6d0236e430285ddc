"""Rates of turning axes: what is checked before one is sent, and what is measured by looking twice."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from rig.abilities.abilities import TurnLook
from rig.clock import Clock
from rig.description.device_settings import AxisSettings, Positive
from rig.errors import RequestRefused


@dataclass(frozen=True, slots=True)
class MeasuredRate:
    """A rate from two looks at the angle and the clock, never from the set value."""

    rate_dps: float
    uncertainty_dps: float
    """Limit (rectangular) from not knowing when within question and answer the angle was taken."""
    turned_deg: float


def check_rate(name: str, rate_dps: float, top_rate_dps: float) -> None:
    """Refuse a rate that is not finite, zero or too fast. Raises: RequestRefused."""
    if not math.isfinite(rate_dps) or rate_dps == 0.0 or abs(rate_dps) > top_rate_dps:
        raise RequestRefused(
            f"{name}: turn at {rate_dps:g} °/s: allowed up to {top_rate_dps:g} °/s either way and not 0"
            f" (axes.{name}: top_rate_dps); nothing moved; ask for a rate inside"
        )


class RevolvingSettings(AxisSettings):
    """Of an axis that turns on at a rate where its file says how fast."""

    top_rate_dps: Positive | None = None
    """Largest rate of continuous turning; without it the axis only positions."""

    @property
    def turning(self) -> Literal["no", "revolves", "sweeps"]:
        return "no" if self.top_rate_dps is None else "revolves"

    def refuse_rate(self, name: str, rate_dps: float) -> None:
        if self.top_rate_dps is None:
            super().refuse_rate(name, rate_dps)
        else:
            check_rate(name, rate_dps, self.top_rate_dps)


def look(ask_angle_deg: Callable[[], float], clock: Clock) -> TurnLook:
    """Time one question for the angle by the rig's clock."""
    sent_s = clock.monotonic_s()
    angle_deg = ask_angle_deg()
    answered_s = clock.monotonic_s()
    return TurnLook(angle_deg, 0.5 * (sent_s + answered_s), 0.5 * (answered_s - sent_s))


def measured_rate(first: TurnLook, last: TurnLook) -> MeasuredRate:
    """Return the mean rate between two looks. Raises: RequestRefused where no time passed between them."""
    elapsed_s = last.taken_s - first.taken_s
    if not elapsed_s > 0.0:
        raise RequestRefused(f"measured rate: {elapsed_s:g} s between the two looks; look again later")
    turned_deg = last.angle_deg - first.angle_deg
    rate_dps = turned_deg / elapsed_s
    return MeasuredRate(rate_dps, abs(rate_dps) * (first.uncertainty_s + last.uncertainty_s) / elapsed_s, turned_deg)
