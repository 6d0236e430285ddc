"""What differs between two coefficient sets beyond rounding: a difference counts from 1e-12 of the axis' scale."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any, Final

ROUNDING: Final = 1e-12
"""Of the axis' scale, |b| + Σ|k|."""


@dataclass(frozen=True)
class NumberChange:
    """One number that is not what it was."""

    sensor: str
    axis: str
    name: str
    old: float | None
    """None where the archived set does not have it."""
    new: float | None
    of_scale: float | None
    """Size of the change over the axis' scale."""
    in_uncertainties: float | None
    """Size of the change over the archived standard uncertainty."""


def number_changes(sensor: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[NumberChange]:
    """Yield what differs between the primary parameters of two coefficient sets beyond rounding."""
    for axis in dict.fromkeys([*old["axes"], *new["axes"]]):
        before, after = (document["axes"].get(axis) for document in (old, new))
        if before is None or after is None:
            was, becomes = (None if part is None else 1.0 for part in (before, after))
            yield NumberChange(sensor, axis, "axis", was, becomes, None, None)
            continue
        yield from _axis_changes(sensor, axis, before["primary"], after["primary"])


def _axis_changes(
    sensor: str, axis: str, before: Mapping[str, Any], after: Mapping[str, Any]
) -> Iterator[NumberChange]:
    values, now = before["values"], after["values"]
    scale = sum(abs(value) for value in values.values())
    spread, new_spread = _uncertainties(before), _uncertainties(after)
    for name in dict.fromkeys([*values, *now]):
        yield from _change(sensor, axis, name, values.get(name), now.get(name), scale, spread.get(name))
        label = f"u({name})"
        yield from _change(sensor, axis, label, spread.get(name), new_spread.get(name), scale, spread.get(name))


def _change(
    sensor: str, axis: str, name: str, old: float | None, new: float | None, scale: float, uncertainty: float | None
) -> Iterator[NumberChange]:
    if old is None or new is None:
        if old is not new:
            yield NumberChange(sensor, axis, name, old, new, None, None)
        return
    size = abs(new - old)
    if size > ROUNDING * scale:
        yield NumberChange(sensor, axis, name, old, new, size / scale, size / uncertainty if uncertainty else None)


def _uncertainties(primary: Mapping[str, Any]) -> dict[str, float | None]:
    diagonal = (primary["covariance"][index][index] for index in range(len(primary["order"])))
    return {
        name: None if value is None else sqrt(max(value, 0.0))
        for name, value in zip(primary["order"], diagonal, strict=True)
    }
