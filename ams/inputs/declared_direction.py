"""Where a sensor axis is declared to lie, with which sign it is declared to read, and how much."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from ams.frames import AXES


@dataclass(frozen=True)
class DeclaredDirection:
    """One axis of those in which the sensitivities of a model are counted."""

    axis: str
    """``x``, ``y`` or ``z``."""
    sense: Literal[1, -1] = 1
    """Along that axis, or against it."""
    polarity: Literal[1, -1] | None = None
    """Sign of the declared sensitivity; None where nobody declared one: then either sense agrees."""
    v_per_g: float | None = None
    """Size of the declared sensitivity of an accelerometer, above 0; None where nobody declared one."""

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
