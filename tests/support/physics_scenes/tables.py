"""What a two-axis indexing table does wrong: curves of index error, zeros, slips, its base, its orthogonality."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physics_scenes.designs import Schedule
from physics_scenes.rotations import (
    ARCSEC,
    LEVEL_FORCE,
    FloatArray,
    pitch_matrix,
    roll_matrix,
    turn_matrix,
    turned,
    yaw_matrix,
)

Curve = Callable[[FloatArray], FloatArray]
"""From indexed angles (D,) in rad to the error of every campaign's table there, (n, D) in rad."""


def exact(angle_rad: FloatArray) -> FloatArray:
    """The curve of a table without error."""
    return np.zeros((1, angle_rad.size))


@dataclass(frozen=True)
class Table:
    """The attitude in which the table truly stands. Slips are (n, D) in rad and stay what they are for a dwell."""

    pitch_curve: Curve = exact
    roll_curve: Curve = exact
    pitch_slip_rad: FloatArray | float = 0.0
    roll_slip_rad: FloatArray | float = 0.0
    base_turn_rad: FloatArray | float = 0.0
    """(n, D, 3) rotation vector of the base from level, in its own axes: x forward, y right, z down."""
    orthogonality_rad: FloatArray | float = 0.0
    """(n, D) by which the roll axis lies off the right angle to the pitch axis, turned about z."""

    def moved(
        self,
        pitch_rad: FloatArray | float = 0.0,
        roll_rad: FloatArray | float = 0.0,
        base_turn_rad: FloatArray | float = 0.0,
        orthogonality_rad: FloatArray | float = 0.0,
    ) -> "Table":
        """Return this table with a further slip, tilt or want of squareness, its curves as they are."""
        return replace(
            self,
            pitch_slip_rad=self.pitch_slip_rad + pitch_rad,
            roll_slip_rad=self.roll_slip_rad + roll_rad,
            base_turn_rad=self.base_turn_rad + base_turn_rad,
            orthogonality_rad=self.orthogonality_rad + orthogonality_rad,
        )

    def force_g(self, schedule: Schedule) -> FloatArray:
        """Return the specific force (n, D, 3) in the axes of the roll plate: base, pitch, squareness, roll."""
        pitch, roll = np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg)
        true_pitch = pitch + self.pitch_curve(pitch) + self.pitch_slip_rad
        true_roll = roll + self.roll_curve(roll) + self.roll_slip_rad
        force = np.broadcast_to(LEVEL_FORCE, (1, 1, 3))
        if np.any(self.base_turn_rad):
            force = turned(turn_matrix(np.asarray(self.base_turn_rad)), force)
        force = turned(pitch_matrix(true_pitch), force)
        if np.any(self.orthogonality_rad):
            force = turned(yaw_matrix(self.orthogonality_rad), force)
        return turned(roll_matrix(true_roll), force)


def once_per_turn(amplitude_rad: float, campaigns: int, chance: np.random.Generator, times: int = 1) -> Curve:
    """An axis off the centre of its scale: amplitude·sin(times·a + φ), φ uniform; twice is an elliptic scale."""
    phase = chance.uniform(0.0, 2.0 * np.pi, (campaigns, 1))
    return lambda angle: amplitude_rad * np.sin(times * angle + phase)


def eight_harmonics(limit_rad: float, campaigns: int, chance: np.random.Generator) -> Curve:
    """Harmonics one to eight of equal weight and random phase; the largest error anywhere is the limit."""
    weights = chance.standard_normal((2, campaigns, 8))

    def sums(angle: FloatArray) -> FloatArray:
        turns = np.arange(1, 9)[:, None] * angle
        return weights[0] @ np.cos(turns) + weights[1] @ np.sin(turns)

    largest = np.abs(sums(np.linspace(-np.pi, np.pi, 2881))).max(axis=1, keepdims=True)
    return lambda angle: limit_rad * sums(angle) / largest


def white_teeth(limit_rad: float, campaigns: int, chance: np.random.Generator) -> Curve:
    """An error of its own for every tooth of one degree, rectangular within the limit; ±180° are one tooth."""
    errors = chance.uniform(-limit_rad, limit_rad, (campaigns, 360))
    return lambda angle: errors[:, np.round(np.rad2deg(angle)).astype(int) % 360]


def sawtooth(limit_rad: float, campaigns: int, chance: np.random.Generator, worm_deg: float = 72.0) -> Curve:
    """A worm's own error, rising evenly from −limit to +limit over one turn of the worm and falling back at once.

    A worm of 72° stands for any that the design's spacing does not divide; a real one of 1° or 3° is seen by a grid of
    10° or 30° always at one place, and is then an offset of the axis.
    """
    phase = chance.uniform(0.0, 1.0, (campaigns, 1))
    return lambda angle: limit_rad * (2.0 * np.mod(np.mod(np.rad2deg(angle), 360.0) / worm_deg + phase, 1.0) - 1.0)


def zeroed(curve: Curve) -> Curve:
    """The table was set to read true at index 0: what is left elsewhere is E(a) − E(0)."""
    return lambda angle: curve(angle) - curve(np.zeros(1))


def arcsec(size: float) -> float:
    """Return an angle in rad."""
    return size * ARCSEC
