"""A rotation of the package that goes with roll: what it does to each output, and its finding."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import ATTITUDE_TURN, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.sensed_force import along_force, turned_by
from ams.analysis.diagnostics.size_words import within
from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.frames import AXES
from ams.remembered import remembered
from ams.statistics.intervals import t_quantile
from ams.units import in_arcsec

_ABOUT: Final[tuple[What, ...]] = ("roll", "lateral axis", "normal")
"""Turns of the package about x, y and z."""
_TURN_RAD: Final = 2.0 * np.pi


@dataclass(frozen=True)
class RollTurn:
    """Of one package, over a whole turn of roll."""

    turn_rad: FloatArray
    """(3,) about x, y and z of the package."""
    covariance: FloatArray
    """(3, 3)"""
    dof: float
    p_value: float
    outputs: int
    """How many were asked."""
    lone_axis: str = ""
    """Nominal axis of the output without which the others do not show it; empty: they do."""

    @property
    def size_rad(self) -> float:
        """Over a whole turn of roll."""
        return float(np.linalg.norm(self.turn_rad))

    @property
    def standard_uncertainty_rad(self) -> float:
        """Along the rotation."""
        direction = self.turn_rad / self.size_rad
        return float(np.sqrt(direction @ self.covariance @ direction))

    @property
    def test(self) -> BeliefTest:
        """As one of every output of the package."""
        size, uncertainty = self.size_rad, self.standard_uncertainty_rad
        return BeliefTest(
            ATTITUDE_TURN, "table-rotation", self.p_value, size, uncertainty, "rad", self.dof,
            is_held=False, axes=self.outputs,
        )  # fmt: skip

    def taken_by(self, evidence: Evidence, output: int) -> tuple[FloatArray, FloatArray]:
        """Return (N, 3) what a radian about x, y and z of the package does to an output, and how many there are."""
        base = accelerometer_base(evidence.models[output])
        assert base is not None, "no other sensor shows it"
        turned = turned_with_roll(*turned_by(base, evidence.rows)).reshape(-1, 3, 3)
        return np.asarray(turned @ along_force(base, evidence.primary[output])), self.turn_rad

    def finding(self) -> Finding:
        """Return what is said of it: by how much over a turn of roll, and about which axes of the package."""
        quantile, sd = float(t_quantile(0.95, self.dof)), np.sqrt(np.diagonal(self.covariance))
        about = ", ".join(
            f"{axis} {within(in_arcsec(size), quantile * in_arcsec(each))}″"
            for axis, size, each in zip(AXES, self.turn_rad.tolist(), sd.tolist(), strict=True)
        )
        size = within(in_arcsec(self.size_rad), quantile * in_arcsec(self.standard_uncertainty_rad))
        others = (
            f"or it is of {self.lone_axis} alone, which shows nearly all of it: a cable that leaks as it is twisted; "
            if self.lone_axis
            else ""
        )
        fact = (
            f"the package turns on its mount, or the table, with the angle of roll, by {size}″ from −180° to 180° "
            f"(about {about} of the package): cables that pull, a mount that gives; {others}what of it is about x may "
            "be index errors of roll; offset and sensitivities hold part of it that the stated uncertainties do not"
        )
        details: dict[str, float | str | None] = {
            "test": ATTITUDE_TURN,
            "turn_with_roll_arcsec": in_arcsec(self.size_rad),
            "standard_uncertainty_arcsec": in_arcsec(self.standard_uncertainty_rad),
            **({"confounded_with": "sensor-change"} if self.lone_axis else {}),
            **{
                f"turn_about_{axis}_arcsec": in_arcsec(part)
                for axis, part in zip(AXES, self.turn_rad.tolist(), strict=True)
            },
        }
        way_out = "give the cables slack over the whole range of roll, look at the mount, and measure again"
        return Finding("table-rotation", fact, True, self.p_value, (), details, is_held=False, what_to_do=way_out)


@remembered(16)
def turned_with_roll(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None) -> FloatArray:
    """Return (N, 9) ∂f of a turn by a radian a whole turn of roll, about x, then y, then z of the package."""
    parts = [slip_pattern(about, pitch_rad, roll_rad, yaw_rad) for about in _ABOUT]
    return np.asarray(np.hstack(parts) * (roll_rad / _TURN_RAD)[:, None])
