"""What the outputs of a package take of a change of the table or of the meter, row by row."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_turn, specific_force_by_yaw
from ams.remembered import remembered

What = Literal["roll", "pitch", "yaw", "forward axis", "lateral axis", "normal", "offset", "sensitivity"]
ALONE: Final = ((0, 0),)
"""Pairs of columns of a pattern of one."""
EACH_WITH_EACH: Final = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
SLIPS: Final[dict[What, tuple[tuple[int, int], ...]]] = {
    "roll": ((1, 1), (1, 2), (2, 2)),
    "pitch": EACH_WITH_EACH,
    "yaw": EACH_WITH_EACH,
    "forward axis": ((1, 1), (1, 2), (2, 2)),
    "lateral axis": ((0, 0), (0, 2), (2, 2)),
    "normal": ((0, 0), (0, 1), (1, 1)),
}
_OF_A_STING: Final[tuple[What, ...]] = ("pitch", "yaw", "forward axis", "lateral axis")
"""Turns of the table, and of the package on its mount, with the pairs of columns that there are of the specific force's
change. That about yaw is one of a gimbal only."""
ON_MOUNT: Final[frozenset[What]] = frozenset({"forward axis", "lateral axis", "normal"})
"""Turns of the package about its own axes, those of the table's stage. That about x is a slip of roll; where roll does
not reach the package, that about z is a slip of yaw."""


@dataclass(frozen=True)
class Watched:
    """One output."""

    departures: FloatArray
    """(N,) what differs from replication to replication."""
    variance: float
    """Of a dwell."""
    k: FloatArray | None
    """(3,) per g; None where it senses no attitude."""
    sensed: FloatArray
    """(N,) what a change of its sensitivity scales."""
    drift: FloatArray | None = None
    """(N,) of unit length, less the mean of each point: an even drift that stands beside every change, and that the
    departures are without; None where it does not drift. The same for all outputs that do."""

    @cached_property
    def squares(self) -> float:
        """Of the departures."""
        return float(self.departures @ self.departures)

    def beside(self, columns: FloatArray) -> FloatArray:
        """Return (N, …) columns without what they have in common with the drift."""
        return columns if self.drift is None else columns - np.multiply.outer(self.drift, self.drift @ columns)


@remembered(16)
def ones(rows: int) -> FloatArray:
    """Return the (N,) change of what is read by a step of its offset, per unit of it."""
    return np.ones(rows)


def slips_of(yaw_rad: FloatArray | None, *, is_rolled: bool = True) -> tuple[What, ...]:
    """Return the turns that there are; ``is_rolled``: whether roll reaches the package."""
    if not is_rolled:
        return _OF_A_STING
    return tuple(what for what in SLIPS if what != "forward axis" and (what != "yaw" or yaw_rad is not None))


@remembered(16)
def slip_pattern(
    what: What, pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> FloatArray:
    """Return the (N, 3) change of specific force by a turn about one axis, per radian."""
    if what == "pitch":
        return np.asarray(specific_force_by_pitch(pitch_rad, roll_rad, yaw_rad))
    if what == "yaw":
        assert yaw_rad is not None, "only a gimbal turns about it"
        return np.asarray(specific_force_by_yaw(pitch_rad, roll_rad, yaw_rad))
    about_x, about_y, about_z = specific_force_by_turn(pitch_rad, roll_rad, yaw_rad)
    return {"roll": about_x, "forward axis": about_x, "lateral axis": about_y, "normal": about_z}[what]


@remembered(16)
def force(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None) -> FloatArray:
    """Return the (N, 3) specific force, g: what each sensitivity takes of a step of the meter's gain, per part."""
    return np.asarray(specific_force(pitch_rad, roll_rad, yaw_rad))


@remembered(16)
def force_along(
    nominal_axis: str, pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> FloatArray:
    """Return the (N,) specific force along one nominal axis, g."""
    return np.array(specific_force(pitch_rad, roll_rad, yaw_rad)[:, "xyz".index(nominal_axis)])
