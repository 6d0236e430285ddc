"""The turns of table, base and fixture, by name, and what each does to the specific force that a package feels.

A table of pitch and roll has no turn about yaw; on a gimbal yaw stands between the two, and a slip of it is none of the
others. With the base level a turn about its lateral axis is a slip of pitch, and about the vertical nothing is seen.
"""

from collections.abc import Mapping
from typing import Final

from ams.arrays import FloatArray
from ams.frames import (
    specific_force_by_base,
    specific_force_by_pitch,
    specific_force_by_turn,
    specific_force_by_yaw,
)

ROLL, PITCH, YAW, BASE, FIXTURE = "roll", "pitch", "yaw", "tilt of the base", "fixture"
FIXTURE_Y, FIXTURE_Z = "fixture about y", "fixture about z"
ROTATIONS: Final = (ROLL, PITCH, YAW, BASE, FIXTURE_Y, FIXTURE_Z)
AXES_OF_TABLE: Final = (ROLL, PITCH, YAW)
"""Which seat anew at every dwell, and may slip."""


def force_changes(
    pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None = None
) -> Mapping[str, FloatArray]:
    """Return ∂f by each turn, (K, 3) per radian in table axes, in the order of :data:`ROTATIONS`.

    That of the base is about its forward axis. Without yaw there is none about it.
    """
    by_roll, about_y, about_z = specific_force_by_turn(pitch_rad, roll_rad, yaw_rad)
    return {
        ROLL: by_roll,
        PITCH: specific_force_by_pitch(pitch_rad, roll_rad, yaw_rad),
        **({} if yaw_rad is None else {YAW: specific_force_by_yaw(pitch_rad, roll_rad, yaw_rad)}),
        BASE: specific_force_by_base(pitch_rad, roll_rad, yaw_rad),
        FIXTURE_Y: about_y,
        FIXTURE_Z: about_z,
    }
