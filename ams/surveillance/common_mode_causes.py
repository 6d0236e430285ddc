"""The causes that are looked for in what all sensors saw at once, and what a fit of them is judged against."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ams.statistics.distributions import f_tail
from ams.surveillance.common_mode_columns import OF_ALIKE, OF_LONE, Whitened
from ams.surveillance.turns import BASE, FIXTURE, PITCH, ROLL, ROTATIONS, YAW, turns_of_fixture

Kind = Literal["table-rotation", "meter-gain", "meter-offset", "sensor-change"]

ROTATION = "rotation"
BASE_ASIDE = "tilt of the base to any side"
LIKE_AXES = "of all like axes"
"""How the name of a cause ends that moves the axes of one name in all sensors alike."""
_OF_AXES = ("offset", "sensitivity")
FEWEST_LEFT = 4
"""Degrees of freedom from which on what is left over tells how much the sensors do by themselves."""


@dataclass(frozen=True)
class Cause:
    """One explanation."""

    kind: Kind
    name: str
    parts: tuple[str, ...]
    """Names of its columns."""


@dataclass(frozen=True)
class Scale:
    """What a sum of squares is judged against."""

    variance: float
    dof: float

    def p_value(self, squares: float, numerator: int) -> float:
        if numerator <= 0 or squares <= 0.0:
            return 1.0
        return float(f_tail(squares / numerator / self.variance, numerator, self.dof))


def scale_of(left: float, dof: int, known_dof: float) -> Scale:
    """Return the known scatter, or what is left over where that is more."""
    if dof >= FEWEST_LEFT and left > dof:
        return Scale(left / dof, float(dof))
    return Scale(1.0, known_dof)


def causes_of(data: Whitened) -> Iterator[Cause]:
    """Yield the single causes in the order in which they are judged."""
    yield from (Cause("table-rotation", name, (name,)) for name in (ROLL, PITCH, YAW) if name in data.columns)
    yield Cause("table-rotation", BASE, (BASE,))
    yield Cause("table-rotation", BASE_ASIDE, (PITCH, BASE))
    yield Cause("table-rotation", FIXTURE, turns_of_fixture(data.columns))
    yield from (of_meter(name) for name in data.columns if name.startswith("gain"))
    yield from (of_meter(name) for name in data.columns if name.startswith("offset"))
    yield from (
        Cause("sensor-change", name.removeprefix(f"{OF_LONE} "), (name,))
        for name in data.columns
        if name.startswith(OF_LONE)
    )
    yield from of_temperature(data)


def rotation(data: Whitened) -> Cause:
    """Return any turn, about all that the table has and of base and fixture."""
    return Cause("table-rotation", ROTATION, tuple(name for name in ROTATIONS if name in data.columns))


def of_temperature(data: Whitened) -> Iterator[Cause]:
    """Yield what a temperature may do: every axis by its own coefficient, and alike in sensors of one make."""
    by_kind: tuple[tuple[str, tuple[Kind, Kind]], ...] = (
        (OF_LONE, ("sensor-change", "sensor-change")),
        (OF_ALIKE, ("meter-offset", "meter-gain")),
    )
    for prefix, kinds in by_kind:
        of = {what: tuple(name for name in data.columns if name.startswith(f"{prefix} {what}")) for what in _OF_AXES}
        whose = "of its axes" if prefix == OF_LONE else LIKE_AXES
        for what, kind in zip(_OF_AXES, kinds, strict=True):
            if of[what] and (prefix == OF_ALIKE or len(of[what]) > 1):
                yield Cause(kind, f"{what} {whose}", of[what])
        both = tuple(name for names in of.values() for name in names)
        if both:
            yield Cause(kinds[0], f"offset and sensitivity {whose}", both)


def of_meter(name: str) -> Cause:
    return Cause("meter-gain" if name.startswith("gain") else "meter-offset", name, (name,))


def common_names(data: Whitened) -> tuple[str, ...]:
    """Return the common columns."""
    return tuple(name for name in data.columns if not name.startswith((OF_LONE, OF_ALIKE)))
