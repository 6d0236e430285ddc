"""What can be wrong with a table and with the seat of a package on it, and what one radian of it does.

Every error is a small turn put somewhere into the chain of rotations from the vertical to the package; its effect is
the derivative of the specific force. Checked against those rotations by a complex step in the tests of the joint fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force_by_pitch, specific_force_by_roll
from ams.inputs.table_uncertainty import TableUncertainty, index_members, shown_rad
from ams.observations import Observations
from ams.solve.extension import angles_of_points
from ams.solve.layout import layout_of

UPRIGHT: Final = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
REVERSED: Final = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
"""Turned half round about the vertical axis of the table's seat."""

WHOLE_TABLE: Final = ("pitch zero", "roll zero", "base tilt", "squareness", "droop")
"""Errors that all indices share."""
SEAT: Final = "seat"
"""Begins the names of the turns of a mounting after the first."""


@dataclass(frozen=True)
class TablePriors:
    """What is stated of the table: its index errors, and standard uncertainties of the rest, radians.

    0 leaves an error out (taken as exact).
    """

    table: TableUncertainty | None = None
    """Index errors of both axes."""
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

    @property
    def of_whole_rad(self) -> tuple[float, ...]:
        """Standard uncertainties in the order of ``WHOLE_TABLE``."""
        return (
            self.pitch_zero_rad, self.roll_zero_rad, self.base_tilt_rad, self.squareness_rad, self.droop_rad
        )  # fmt: skip

    def force_errors(self, pitch: FloatArray, roll: FloatArray) -> FloatArray:
        """Return (N, 3, q) what one standard uncertainty of each error changes of the specific force in table axes.

        At (N,) attitudes, radians, of the first mounting, so that no error of a seat is among them.
        """
        slopes = {"pitch": specific_force_by_pitch(pitch, roll), "roll": specific_force_by_roll(pitch, roll)}
        of_whole = np.asarray(table_effects(pitch, roll, WHOLE_TABLE) * self.of_whole_rad)
        if self.table is None:
            return of_whole
        members = index_members(self.table, shown_rad(self.table, {"pitch": pitch, "roll": roll}))
        of_indices = [slopes[axis][:, :, None] * columns[:, None, :] for axis, columns in members.items()]
        return np.concatenate([of_whole, *of_indices], axis=2)


@dataclass(frozen=True)
class Mounting:
    """Rows taken with the package in one orientation on the table."""

    observations: Observations
    package_from_table: Sequence[Sequence[float]] = UPRIGHT
    """(3, 3) rotation; signed permutation for the usual datum faces."""


@dataclass(frozen=True)
class Nuisances:
    """All errors that have a prior: parts of the index errors, whole-table errors, seats."""

    names: tuple[str, ...]
    prior_rad: FloatArray
    """(q,)"""
    index_parts: Sequence[Mapping[str, FloatArray]]
    """For every mounting: name to (K,), what one radian of a part of the index errors is at the points."""

    def effects(self, number: int, pitch: FloatArray, roll: FloatArray) -> FloatArray:
        """Return the (K, 3, q) change of specific force in table axes at a mounting's points by one radian of each."""
        slopes = {"pitch": specific_force_by_pitch(pitch, roll), "roll": specific_force_by_roll(pitch, roll)}
        parts = self.index_parts[number]
        whole = table_effects(pitch, roll, self.names)
        for index, name in enumerate(self.names):
            if name in parts:
                whole[:, :, index] = slopes[name.partition(" ")[0]] * parts[name][:, None]
        return whole


def nuisances_of(mountings: Sequence[Mounting], priors: TablePriors) -> Nuisances:
    """Return the errors of all mountings together: an index has one error in every one of them."""
    angles = [angles_of_points(m.observations, layout_of(m.observations)) for m in mountings]
    edges = np.cumsum([pitch.size for pitch, _ in angles])[:-1]
    named: list[tuple[str, float]] = []
    parts: list[dict[str, FloatArray]] = [{} for _ in mountings]
    for axis, shown in zip(("pitch", "roll"), zip(*angles, strict=True), strict=True):
        if priors.table is None:
            continue
        found = priors.table.index_errors(axis, shown_rad(priors.table, {axis: np.concatenate(shown)})[axis])
        names = [f"{axis} {name}" for name in found.names]
        named += zip(names, found.standard_rad.tolist(), strict=True)
        for part, columns in zip(parts, np.split(found.columns, edges), strict=True):
            part.update(zip(names, columns.T, strict=True))
    named += zip(WHOLE_TABLE, priors.of_whole_rad, strict=True)
    for number in range(1, len(mountings)):
        named += [(f"{SEAT} {number + 1} about {axis}", priors.seat_rad) for axis in "xyz"]
    kept = [(name, prior) for name, prior in named if prior > 0.0]
    return Nuisances(tuple(name for name, _ in kept), np.array([prior for _, prior in kept]), parts)


def table_effects(pitch: FloatArray, roll: FloatArray, names: Sequence[str]) -> FloatArray:
    """Return the (K, 3, q) change of specific force in table axes by one radian of each error of the whole table."""
    by_pitch, by_roll = specific_force_by_pitch(pitch, roll), specific_force_by_roll(pitch, roll)
    zero = np.zeros_like(pitch)
    across = np.stack([zero, -np.cos(roll), np.sin(roll)], axis=-1)
    whole = {
        "pitch zero": by_pitch,
        "roll zero": by_roll,
        "base tilt": across,
        "squareness": np.sin(pitch)[:, None] * across,
        "droop": -np.cos(pitch)[:, None] * by_pitch,
    }
    columns = [whole.get(name, np.zeros_like(by_pitch)) for name in names]
    return np.stack(columns, axis=-1) if columns else np.zeros((pitch.size, 3, 0))


def seat_effects(force: FloatArray, names: Sequence[str], number: int) -> FloatArray:
    """Return the effects of small turns of the package on its seat: f becomes f − θ × f."""
    effects = np.zeros((force.shape[0], 3, len(names)))
    for axis, unit in zip("xyz", np.eye(3), strict=True):
        name = f"{SEAT} {number + 1} about {axis}"
        if name in names:
            effects[:, :, names.index(name)] = -np.cross(unit, force)
    return effects
