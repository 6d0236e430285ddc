"""What can be wrong with a table and with the seat of a package on it, and what one radian of it does.

Every error is a small turn put somewhere into the chain of rotations from the vertical to the package; its effect is
the derivative of the specific force. Checked against those rotations by a complex step in the tests of the joint fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.frames import specific_force_by_pitch, specific_force_by_roll
from ams.observations import Observations

UPRIGHT: Final = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
REVERSED: Final = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
"""Turned half round about the vertical axis of the table's seat."""
_INDEX_GRID_RAD: Final = float(np.deg2rad(1e-5))


@dataclass(frozen=True)
class TablePriors:
    """Standard uncertainties of the table's errors, radians; 0 leaves an error out (taken as exact)."""

    pitch_tooth_rad: float = 0.0
    roll_tooth_rad: float = 0.0
    pitch_zero_rad: float = 0.0
    """Zero of the pitch axis, and with it the tilt of the base about that axis: the two act alike."""
    roll_zero_rad: float = 0.0
    base_tilt_rad: float = 0.0
    """Tilt of the base about the x direction at zero pitch."""
    squareness_rad: float = 0.0
    """Of the roll axis to the pitch axis."""
    droop_rad: float = 0.0
    """Pitch lost at the horizontal, as the cosine of pitch."""
    seat_rad: float = 0.0
    """Each of the three angles of every mounting after the first."""


@dataclass(frozen=True)
class Mounting:
    """Rows taken with the package in one orientation on the table."""

    observations: Observations
    package_from_table: Sequence[Sequence[float]] = UPRIGHT
    """(3, 3) rotation; signed permutation for the usual datum faces."""


def nuisances_of(mountings: Sequence[Mounting], priors: TablePriors) -> tuple[list[str], FloatArray]:
    """Return the names of all errors that have a prior, and the priors, radians.

    They are teeth, whole-table errors, seats.
    """
    named: list[tuple[str, float]] = []
    for axis, prior in (("pitch", priors.pitch_tooth_rad), ("roll", priors.roll_tooth_rad)):
        indices = np.unique(np.concatenate([_indices(m.observations, axis) for m in mountings]))
        named += [(f"{axis} tooth {index * 1e-5:g}°", prior) for index in indices.tolist()]
    named += [
        ("pitch zero", priors.pitch_zero_rad),
        ("roll zero", priors.roll_zero_rad),
        ("base tilt", priors.base_tilt_rad),
        ("squareness", priors.squareness_rad),
        ("droop", priors.droop_rad),
    ]
    for number in range(1, len(mountings)):
        named += [(f"seat {number + 1} about {axis}", priors.seat_rad) for axis in "xyz"]
    kept = [(name, prior) for name, prior in named if prior > 0.0]
    return [name for name, _ in kept], np.array([prior for _, prior in kept])


def _indices(observations: Observations, axis: str) -> IntArray:
    angle = observations.pitch_rad if axis == "pitch" else observations.roll_rad
    return np.round(angle / _INDEX_GRID_RAD).astype(np.int64) % round(2.0 * np.pi / _INDEX_GRID_RAD)


def table_effects(pitch: FloatArray, roll: FloatArray, names: list[str]) -> FloatArray:
    """Return the (K, 3, q) change of specific force in table axes by one radian of each nuisance."""
    by_pitch, by_roll = specific_force_by_pitch(pitch, roll), specific_force_by_roll(pitch, roll)
    zero = np.zeros_like(pitch)
    across = np.stack([zero, -np.cos(roll), np.sin(roll)], axis=-1)
    places = {"pitch": (by_pitch, pitch), "roll": (by_roll, roll)}
    whole = {
        "pitch zero": by_pitch,
        "roll zero": by_roll,
        "base tilt": across,
        "squareness": np.sin(pitch)[:, None] * across,
        "droop": -np.cos(pitch)[:, None] * by_pitch,
    }
    columns = []
    for name in names:
        axis, _, rest = name.partition(" tooth ")
        if rest:
            slope, angle = places[axis]
            turned = (angle - np.deg2rad(float(rest[:-1])) + np.pi) % (2.0 * np.pi) - np.pi
            columns.append(slope * (np.abs(turned) < 0.6 * _INDEX_GRID_RAD)[:, None])
        else:
            columns.append(whole.get(name, np.zeros_like(by_pitch)))
    return np.stack(columns, axis=-1) if columns else np.zeros((pitch.size, 3, 0))


def seat_effects(force: FloatArray, names: list[str], number: int) -> FloatArray:
    """Return the effects of small turns of the package on its seat: f becomes f − θ × f."""
    effects = np.zeros((force.shape[0], 3, len(names)))
    for axis, unit in zip("xyz", np.eye(3), strict=True):
        name = f"seat {number + 1} about {axis}"
        if name in names:
            effects[:, :, names.index(name)] = -np.cross(unit, force)
    return effects
