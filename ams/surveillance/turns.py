"""The turns of table, base and fixture, by name, and what each does to the specific force that a package feels.

A table of pitch and roll has no turn about yaw; on a gimbal yaw stands between the two, and a slip of it is none of the
others. On a sting, which roll does not reach, yaw carries the package: what turns it about its normal is a slip of yaw,
and what turns it about its forward axis the fixture. With the base level a turn about its lateral axis is a slip of
pitch, and about the vertical nothing is seen.
"""

from collections.abc import Container, Mapping
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.frames import (
    specific_force_by_base,
    specific_force_by_pitch,
    specific_force_by_turn,
    specific_force_by_yaw,
)

ROLL, PITCH, YAW, BASE, FIXTURE = "roll", "pitch", "yaw", "tilt of the base", "fixture"
FIXTURE_X, FIXTURE_Y, FIXTURE_Z = "fixture about x", "fixture about y", "fixture about z"
ROTATIONS: Final = (ROLL, PITCH, YAW, BASE, FIXTURE_X, FIXTURE_Y, FIXTURE_Z)
AXES_OF_TABLE: Final = (ROLL, PITCH, YAW)
"""Which seat anew at every dwell, and may slip."""


def force_changes(
    pitch_rad: FloatArray, roll_rad: FloatArray | None, yaw_rad: FloatArray | None = None
) -> Mapping[str, FloatArray]:
    """Return ∂f by each turn, (K, 3) per radian in table axes, in the order of :data:`ROTATIONS`.

    That of the base is about its forward axis. Without yaw there is none about it. ``roll_rad``: None of what roll does
    not reach.
    """
    if roll_rad is None:
        return _on_sting(pitch_rad, np.zeros_like(pitch_rad), yaw_rad)
    by_roll, about_y, about_z = specific_force_by_turn(pitch_rad, roll_rad, yaw_rad)
    return {
        ROLL: by_roll,
        PITCH: specific_force_by_pitch(pitch_rad, roll_rad, yaw_rad),
        **({} if yaw_rad is None else {YAW: specific_force_by_yaw(pitch_rad, roll_rad, yaw_rad)}),
        BASE: specific_force_by_base(pitch_rad, roll_rad, yaw_rad),
        FIXTURE_Y: about_y,
        FIXTURE_Z: about_z,
    }


def _on_sting(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None) -> Mapping[str, FloatArray]:
    about_x, about_y, about_z = specific_force_by_turn(pitch_rad, roll_rad, yaw_rad)
    return {
        PITCH: specific_force_by_pitch(pitch_rad, roll_rad, yaw_rad),
        **({} if yaw_rad is None else {YAW: about_z}),
        BASE: specific_force_by_base(pitch_rad, roll_rad, yaw_rad),
        FIXTURE_X: about_x,
        FIXTURE_Y: about_y,
        **({FIXTURE_Z: about_z} if yaw_rad is None else {}),
    }


def turns_of_fixture(turns: Container[str]) -> tuple[str, ...]:
    """Return the turns that a fixture may make, of those that there are: about the axis that carries it as well."""
    carried_by = (ROLL,) if ROLL in turns else (YAW,) if YAW in turns else ()
    return (*carried_by, *(name for name in (FIXTURE_X, FIXTURE_Y, FIXTURE_Z) if name in turns))
