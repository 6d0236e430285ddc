"""What a meter proves about itself while a run lasts: its zero on a short, its scale on a reference, its temperature.

A short is read on every range that the rig uses, a reference on the smallest of them that holds it: those are the very
ranges on which the sensors are read.
"""

from collections.abc import Callable, Iterable
from typing import Literal

from pydantic import Field, model_validator

from rig.description.device_settings import Positive
from rig.devices.abilities import Burst
from rig.devices.self_checking import MeterProof
from rig.toml_file import StrictTable

OVER_RANGE = 1.05
"""Every range holds at least so much of its nominal value."""


class MeterChecks(StrictTable):
    """``checks`` of a readout, without how it reaches its short and its reference."""

    short_limit_v: Positive | None = None
    """How far from 0 V the short may read; without it the reading is recorded and not judged."""
    reference_v: float | None = None
    reference_limit_v: Positive | None = None
    every_s: Positive = 3600.0
    samples: int = Field(default=10, ge=2, le=1000)
    action: Literal["trip", "hold"] = "trip"
    """What a reading beyond its limit does: ``hold`` goes on when a person says so and the next reading is good."""

    def places(self) -> dict[str, int | None]:
        """Return where ``short`` and ``reference`` are, None where there is none."""
        raise NotImplementedError

    @property
    def asks_for_anything(self) -> bool:
        return any(place is not None for place in self.places().values())

    @model_validator(mode="after")
    def _whole(self) -> "MeterChecks":
        places = self.places()
        if (places["reference"] is None) != (self.reference_v is None):
            raise ValueError("reference_v and the channel of the reference belong together: give both or neither")
        for name, limit_v in (("short", self.short_limit_v), ("reference", self.reference_limit_v)):
            if limit_v is not None and places[name] is None:
                raise ValueError(f"{name}_limit_v stands there, but there is no channel of the {name}")
        return self

    def refuse_conflicts(self, used: Iterable[int], ranges_v: Iterable[float]) -> None:
        """Refuse checks that conflict with the channels in use.

        Raises: ValueError where a check's channel is a sensor's, or no used range holds the reference.
        """
        taken = set(used)
        for name, place in self.places().items():
            if place in taken:
                raise ValueError(f"checks: the {name} is on channel {place}, which belongs to a sensor; use another")
            taken |= set() if place is None else {place}
        if self.reference_v is not None and reference_range_v(self.reference_v, ranges_v) is None:
            raise ValueError(f"checks: reference_v = {self.reference_v:g} V fits on no range that a channel uses")


def reference_range_v(reference_v: float, ranges_v: Iterable[float]) -> float | None:
    """Return the smallest used range that holds the reference."""
    return min((range_v for range_v in ranges_v if OVER_RANGE * range_v >= abs(reference_v)), default=None)


def proofs(
    checks: MeterChecks, ranges_v: Iterable[float], read: Callable[[int, float], Burst]
) -> tuple[MeterProof, ...]:
    """Read what is there. ``read(place, range_v)`` measures one of the channels of :meth:`MeterChecks.places`."""
    places, used_v = checks.places(), sorted(set(ranges_v))
    wanted = [] if places["short"] is None else [("short", places["short"], 0.0, range_v) for range_v in used_v]
    if places["reference"] is not None and checks.reference_v is not None:
        range_v = reference_range_v(checks.reference_v, used_v)
        assert range_v is not None, "the settings were checked"
        wanted.append(("reference", places["reference"], checks.reference_v, range_v))
    limits_v = {"short": checks.short_limit_v, "reference": checks.reference_limit_v}
    return tuple(
        MeterProof(f"{name} on {range_v:g} V", float(read(place, range_v).samples.mean()), expected_v, limits_v[name])
        for name, place, expected_v, range_v in wanted
    )
