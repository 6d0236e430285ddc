"""Where a sensor axis is declared to lie, with which sign it is declared to read, and how much."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from ams.frames import AXES
from ams.models.convert import STANDARD_GRAVITY_MPS2
from ams.units import label_and_unit


@dataclass(frozen=True)
class NominalSensitivity:
    """What an output is said to change by with what it senses: by the data sheet, or by the unit that it is read in."""

    size: float
    """Above 0, in ``unit`` over ``per``."""
    unit: str = "v"
    """Of the readings, as it is written in a key."""
    per: str = "g"
    """Of what is sensed."""

    @property
    def is_of_unit(self) -> bool:
        """Whether nobody declared it: readings in a unit of what is sensed have it by that unit."""
        return self.unit != "v"

    @property
    def printed_unit(self) -> str:
        return label_and_unit(f"sensitivity_{self.unit}_per_{self.per}")[1]


_OF_UNIT: Final[Mapping[tuple[str, str], float]] = {
    ("g", "g"): 1.0,
    ("mps2", "g"): STANDARD_GRAVITY_MPS2,
    ("dps", "dps"): 1.0,
    ("ut", "ut"): 1.0,
}
"""Units of readings and of what is sensed, to what the first changes by with one of the second."""


def nominal_of_unit(unit: str, per: str) -> NominalSensitivity | None:
    """Return what readings in a unit of what is sensed change by; None of any other unit."""
    size = _OF_UNIT.get((unit, per))
    return None if size is None else NominalSensitivity(size, unit, per)


@dataclass(frozen=True)
class DeclaredDirection:
    """One axis of those in which the sensitivities of a model are counted."""

    axis: str
    """``x``, ``y`` or ``z``."""
    sense: Literal[1, -1] = 1
    """Along that axis, or against it."""
    polarity: Literal[1, -1] | None = None
    """Sign of the declared sensitivity; None where nobody declared one: then either sense agrees."""
    sensitivity: NominalSensitivity | None = None
    """None where nobody declared one and the unit of the readings says none."""

    @property
    def index(self) -> int:
        """Place of the axis among x, y, z."""
        return AXES.index(self.axis)

    @property
    def signed_axis(self) -> str:
        """The axis as a rig file's ``mount`` writes it, such as ``+x``."""
        return f"{'+' if self.sense > 0 else '-'}{self.axis}"


GAIN_RANGE: Final = (0.5, 2.0)
"""A sensitivity over the declared one; outside, a range, a load or a unit is wrong."""
NOTHING_DECLARED: Final[Mapping[str, DeclaredDirection]] = MappingProxyType({})
"""Every axis lies along the one that it is named by, of either polarity."""
