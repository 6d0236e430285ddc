"""What a meter proves about itself while a run lasts: its zero on a short, its scale on a reference, its temperature.

A short is read on every range that the rig uses, a reference on the smallest of them that holds it: those are the very
ranges on which the sensors are read.
"""

from collections.abc import Callable, Iterable
from typing import Literal

from pydantic import Field, model_validator

from rig.abilities.abilities import Burst
from rig.abilities.self_checking import MeterProof
from rig.description.device_settings import Positive
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

    def channel_numbers(self) -> dict[str, int | None]:
        """Return where ``short`` and ``reference`` are, None where there is none."""
        raise NotImplementedError

    @property
    def asks_for_anything(self) -> bool:
        return any(channel is not None for channel in self.channel_numbers().values())

    @model_validator(mode="after")
    def _whole(self) -> "MeterChecks":
        channels = self.channel_numbers()
        if (channels["reference"] is None) != (self.reference_v is None):
            raise ValueError("reference_v and the channel of the reference belong together: give both or neither")
        for name, limit_v in (("short", self.short_limit_v), ("reference", self.reference_limit_v)):
            if limit_v is not None and channels[name] is None:
                raise ValueError(f"{name}_limit_v stands there, but there is no channel of the {name}")
        return self

    def refuse_conflicts(self, used: Iterable[int], ranges_v: Iterable[float]) -> None:
        """Refuse checks that conflict with the channels in use.

        Raises: ValueError where a check's channel is a sensor's, or no used range holds the reference.
        """
        taken = set(used)
        for name, channel in self.channel_numbers().items():
            if channel in taken:
                raise ValueError(f"checks: the {name} is on channel {channel}, which belongs to a sensor; use another")
            taken |= set() if channel is None else {channel}
        if self.reference_v is not None and reference_range_v(self.reference_v, ranges_v) is None:
            raise ValueError(f"checks: reference_v = {self.reference_v:g} V fits on no range that a channel uses")


def reference_range_v(reference_v: float, ranges_v: Iterable[float]) -> float | None:
    """Return the smallest used range that holds the reference."""
    return min((range_v for range_v in ranges_v if OVER_RANGE * range_v >= abs(reference_v)), default=None)


def proofs(
    checks: MeterChecks, ranges_v: Iterable[float], read: Callable[[int, float], Burst]
) -> tuple[MeterProof, ...]:
    """Read what is there. ``read(channel, range_v)`` measures one of :meth:`MeterChecks.channel_numbers`."""
    channels, used_v = checks.channel_numbers(), sorted(set(ranges_v))
    wanted = [] if channels["short"] is None else [("short", channels["short"], 0.0, range_v) for range_v in used_v]
    if channels["reference"] is not None and checks.reference_v is not None:
        range_v = reference_range_v(checks.reference_v, used_v)
        assert range_v is not None, "the settings were checked"
        wanted.append(("reference", channels["reference"], checks.reference_v, range_v))
    limits_v = {"short": checks.short_limit_v, "reference": checks.reference_limit_v}
    return tuple(
        MeterProof(f"{name} on {range_v:g} V", float(read(channel, range_v).samples.mean()), expected_v, limits_v[name])
        for name, channel, expected_v, range_v in wanted
    )
