"""A rotation of the package that goes with its attitude: the ways it may go, what it does, and its finding."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from ams.analysis.diagnostics.beliefs import ATTITUDE_TURN, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force, turned_by
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.step_patterns import What, force, slip_pattern
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.frames import AXES
from ams.remembered import remembered
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

Course = Literal["force", "arm", "roll", "pitch", "roll either way", "roll over a turn"]
"""What it goes with."""
COLUMNS: Final[dict[Course, int]] = {
    "force": 3,
    "arm": 2,
    "roll": 4,
    "pitch": 3,
    "roll either way": 3,
    "roll over a turn": 3,
}
"""How many numbers say how it goes."""
_ABOUT: Final[tuple[What, ...]] = ("roll", "lateral axis", "normal")
"""Turns of the package about x, y and z."""
_SAID: Final[dict[Course, tuple[str, str]]] = {
    "force": (
        "by the force on it",
        "its centre of mass stands off, and a mount or an adapter yields",
    ),
    "arm": (
        "about the axes of the arm once a turn of roll",
        "the shaft of roll wobbles, or the arm sags under a load off its centre",
    ),
    "roll": ("once a turn of roll", "a mount or an adapter yields, or a cable pulls"),
    "pitch": ("with pitch", "a cable pulls, and the mount gives"),
    "roll either way": ("with roll to either side alike", "a cable pulls, and the mount gives"),
    "roll over a turn": ("with roll from −180° to 180°", "a cable pulls, and the mount gives"),
}
"""How it goes, and what does that."""


@dataclass(frozen=True)
class AttitudeTurn:
    """Of one package."""

    course: Course
    others: tuple[Course, ...]
    """That fit hardly worse."""
    sizes: FloatArray
    """(c,) radians of the columns of its course."""
    covariance: FloatArray
    """(c, c)"""
    dof: float
    p_value: float
    about_rad: FloatArray
    """(3,) root of the mean square over the points about x, y and z of the package."""
    standard_uncertainty_rad: float
    """Of the root of the sum of these squares."""
    outputs: int
    """How many were asked."""

    @property
    def size_rad(self) -> float:
        """Root of the mean square over the points."""
        return float(np.linalg.norm(self.about_rad))

    @property
    def test(self) -> BeliefTest:
        """As one of every output of the package."""
        return BeliefTest(
            ATTITUDE_TURN, "table-rotation", self.p_value, self.size_rad, self.standard_uncertainty_rad, "rad",
            self.dof, is_held=False, axes=self.outputs,
        )  # fmt: skip

    def taken_by(self, evidence: Evidence, output: int) -> tuple[FloatArray, FloatArray]:
        """Return (N, c) what a radian of each column does to an output, and how many there are."""
        base = accelerometer_base(evidence.models[output])
        assert base is not None, "no other sensor shows it"
        pitch_rad, roll_rad, _ = turned_by(base, evidence.rows)
        turned = turned_with_attitude(pitch_rad, roll_rad)[:, :, columns_of(self.course)]
        return np.asarray(turned.transpose(0, 2, 1) @ along_force(base, evidence.primary[output])), self.sizes

    def finding(self) -> Finding:
        """Return what is said of it: how it goes, by how much, and about which axes of the package."""
        how, cause = _SAID[self.course]
        half = float(t_quantile(0.95, self.dof)) * in_arcsec(self.standard_uncertainty_rad)
        size = within(in_arcsec(self.size_rad), half)
        about = ", ".join(
            f"{axis} {round(in_arcsec(size), 2):.2g}″" for axis, size in zip(AXES, self.about_rad.tolist(), strict=True)
        )
        or_else = "".join(f", or {_SAID[course][0]} ({_SAID[course][1]})" for course in self.others)
        fact = (
            f"the package turns on its mount, or the table, with the attitude, by {size}″ in the root of the mean "
            f"square over the points (about {about} of the package): {how} ({cause}){or_else}; one rotation of all "
            "outputs explains what would pass for terms of low order of each; offset and sensitivities hold part of it "
            "that the stated uncertainties do not"
        )
        details: dict[str, float | str | None] = {
            "test": ATTITUDE_TURN,
            "goes_with": self.course,
            "turn_rms_arcsec": in_arcsec(self.size_rad),
            "standard_uncertainty_arcsec": in_arcsec(self.standard_uncertainty_rad),
            **{
                f"turn_rms_about_{axis}_arcsec": in_arcsec(part)
                for axis, part in zip(AXES, self.about_rad.tolist(), strict=True)
            },
        }
        way_out = (
            "balance the package, stiffen mount, adapter and arm, give the cables slack over the whole range, and "
            "measure again"
        )
        return Finding("table-rotation", fact, True, self.p_value, (), details, is_held=False, what_to_do=way_out)


def columns_of(course: Course) -> slice:
    """Return where the columns of a course are."""
    courses = list(COLUMNS)
    first = sum(COLUMNS[each] for each in courses[: courses.index(course)])
    return slice(first, first + COLUMNS[course])


@remembered(16)
def rotations(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return (N, 3, c) rotations about x, y and z of the package by the columns of all courses, per radian of each.

    By the force it is r × f, r of the centre of mass: along x, y and z; of an arm what a turn about its own axes by
    cos R or sin R leaves beside fixed rotations of the package, (0, cos 2R, −sin 2R) and (0, sin 2R, cos 2R).
    """
    sensed, nothing, whole = force(pitch_rad, roll_rad, None), np.zeros_like(roll_rad), np.eye(3)
    cosine, sine = np.cos(2.0 * roll_rad), np.sin(2.0 * roll_rad)
    by_force = np.stack([np.cross(axis, sensed) for axis in whole], axis=2)
    of_arm = np.stack([np.stack([nothing, cosine, -sine], axis=1), np.stack([nothing, sine, cosine], axis=1)], axis=2)
    once = [wave[:, None, None] * whole[:, 1:] for wave in (np.cos(roll_rad), np.sin(roll_rad))]
    even = [by[:, None, None] * whole for by in (2.0 * pitch_rad / np.pi, np.abs(roll_rad) / np.pi, roll_rad / np.pi)]
    return np.concatenate([by_force, of_arm, *once, *even], axis=2)


@remembered(16)
def turned_with_attitude(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """Return (N, 3, c) ∂f of the columns of all courses, per radian of each."""
    turned = np.stack([slip_pattern(about, pitch_rad, roll_rad, None) for about in _ABOUT], axis=2)
    return np.asarray(turned @ rotations(pitch_rad, roll_rad))
