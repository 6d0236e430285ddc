"""What is said to an operator who sets an axis by hand, and what may be answered.

One line each; angles are the machine's own scale, in degrees with up to six decimals.
"""

import math
import re
from dataclasses import dataclass

TERMINATOR = b"\n"
CANNOT = "no"
"""The answer of an operator who cannot do it."""

_SET = re.compile(r"([^:\n]+): set the axis to (-?\d+(?:\.\d+)?) deg\b.*")
_HOME = re.compile(r"([^:\n]+): set the axis to its zero\b.*")
_FIELD = re.compile(r"([^:\n]+): apply a field of (-?\d+(?:\.\d+)?) uT\b.*")
_STOP = re.compile(r"([^:\n]+): stop\b.*")
_ANGLE = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)", re.ASCII)


@dataclass(frozen=True, slots=True)
class SetTo:
    axis: str
    angle_deg: float


@dataclass(frozen=True, slots=True)
class SetToZero:
    axis: str


@dataclass(frozen=True, slots=True)
class LeaveIt:
    """Stop: leave the axis as it is."""

    axis: str


@dataclass(frozen=True, slots=True)
class ApplyField:
    """Bring a coil or a magnet to a field; 0 is none."""

    axis: str
    """Name of the coil."""
    field_ut: float


Order = SetTo | SetToZero | LeaveIt | ApplyField


def encode(order: Order) -> bytes:
    """Return the line that an operator reads."""
    match order:
        case SetTo():
            text = (
                f"{order.axis}: set the axis to {shown_deg(order.angle_deg)} deg, then press Enter"
                f" (or type the angle it shows, or '{CANNOT}')"
            )
        case SetToZero():
            text = f"{order.axis}: set the axis to its zero, then press Enter (or type '{CANNOT}')"
        case ApplyField():
            off = " (none: switch it off or take it away)" if order.field_ut == 0.0 else ""
            shown = shown_deg(order.field_ut)
            text = f"{order.axis}: apply a field of {shown} uT{off}, then press Enter (or type '{CANNOT}')"
        case LeaveIt():
            text = f"{order.axis}: stop; leave the axis as it is"
    return text.encode("utf-8") + TERMINATOR


def decode(line: str) -> Order | None:
    """Return the order of a whole line without terminator; None where it is none."""
    if found := _SET.fullmatch(line):
        return SetTo(found[1], float(found[2]))
    if found := _HOME.fullmatch(line):
        return SetToZero(found[1])
    if found := _FIELD.fullmatch(line):
        return ApplyField(found[1], float(found[2]))
    found = _STOP.fullmatch(line)
    return None if found is None else LeaveIt(found[1])


def decode_angle(answer: str) -> float | None:
    """Decode a typed angle; None where it is no plain number."""
    value = float(answer) if _ANGLE.fullmatch(answer) else math.nan
    return value if math.isfinite(value) else None


def shown_deg(angle_deg: float) -> str:
    """Return an angle with up to six decimals, none that say nothing."""
    text = f"{round(angle_deg, 6) + 0.0:.6f}"
    return text.rstrip("0").rstrip(".")
