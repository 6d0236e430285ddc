"""A package on a table and a base that are not what they show, by explicit rotations, and its coefficient sets."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from physics_scenes.rotations import ARCSEC, LEVEL_FORCE, pitch_matrix, roll_matrix, turn_matrix, turned
from physics_scenes.tables import Curve, eight_harmonics, once_per_turn, white_teeth, zeroed
from solved_sets import tp_set

from ams.calibration.calibrate import calibrate
from ams.calibration.jointly import with_level
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import IndexErrors, Shape, TableUncertainty
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance
from ams.solve.table_errors import TablePriors
from ams.surveillance.reference_attitude import ReferenceAttitude, ReferenceInWords, parts_of

LIMIT_ARCSEC = 1.0
NOISE_ARCSEC = 0.4
GRID = np.deg2rad([(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 30)])
SLACK = 60.0 * NOISE_ARCSEC * ARCSEC
"""Of |f|²: what noise alone makes of two axes on their side."""
OFFSET_V = {"x": 0.005, "y": -0.02, "z": 0.011}
K_V_PER_G = {"x": (2.4999, 0.0179, 0.0125), "y": (0.0091, -2.48, 0.015), "z": (-0.011, 0.02, 2.51)}
CurveOf = Callable[[float, int, np.random.Generator], Curve]
SHAPES: dict[str, CurveOf] = {"once": once_per_turn, "harmonics": eight_harmonics, "teeth": white_teeth}


@dataclass(frozen=True)
class Rig:
    """A table, its base and what is declared of both."""

    shape: CurveOf = once_per_turn
    zero_rad: float | None = None
    declared: Shape = "unknown"
    tilt_limit_arcsec: float = 0.0

    @property
    def shared(self) -> tuple[SharedError, ...]:
        u_rad = self.tilt_limit_arcsec * ARCSEC / np.sqrt(3.0)
        named = (("level of the base about pitch", "pitch"), ("level of the base about roll", "base-tilt"))
        return tuple(SharedError(name, effect, u_rad) for name, effect in named) if u_rad else ()

    @property
    def table(self) -> TableUncertainty:
        errors = dict.fromkeys(("pitch", "roll"), IndexErrors(self.declared, self.zero_rad))
        return TableUncertainty(LIMIT_ARCSEC * ARCSEC, LIMIT_ARCSEC * ARCSEC, kind="limit", errors=errors)

    @property
    def reference(self) -> ReferenceAttitude:
        shared = dict.fromkeys("xyz", self.shared)
        return ReferenceAttitude(
            with_level(TablePriors(self.table), shared), ReferenceInWords("table"), parts_of(shared)
        )

    def observe(
        self, axes: str, replications: int, chance: np.random.Generator, gain: float = 1.0, grid: np.ndarray = GRID
    ) -> Observations:
        """Return the rows of one campaign: a table and a base of its own."""
        curves = [self.shape(LIMIT_ARCSEC * ARCSEC, 1, chance) for _ in range(2)]
        curves = curves if self.zero_rad is None else [zeroed(curve) for curve in curves]
        pitch, roll = (angle + curve(angle)[0] for angle, curve in zip(grid.T, curves, strict=True))
        tilt = chance.uniform(-1.0, 1.0, 2) * self.tilt_limit_arcsec * ARCSEC
        clean = outputs_v(axes, pitch, roll, np.array([tilt[0], tilt[1], 0.0]), gain)
        points = grid.shape[0]
        noise = {axis: 2.5 * NOISE_ARCSEC * ARCSEC * chance.standard_normal((replications, points)) for axis in axes}
        return Observations(
            np.repeat(np.arange(1, replications + 1), points),
            np.tile(np.arange(points), replications),
            *(np.tile(angle, replications) for angle in grid.T),
            {axis: (clean[axis] + noise[axis]).ravel() for axis in axes},
        )

    def solved(self, rows: Observations) -> CoefficientSet:
        request = CalibrationRequest(table=self.table, shared_errors=dict.fromkeys(rows.outputs, self.shared))
        provenance = Provenance(
            sensor="TP1", gravity_mps2=9.79826, gravity_source="survey", pitch_range_deg=(-90.0, 90.0),
            roll_range_deg=(-180.0, 180.0), created_utc=tp_set("x").created_utc, software_version="0.1.0",
            rig="bench", procedure="fit", simulated=False,
        )  # fmt: skip
        return build_set(calibrate(rows, request), provenance)


def outputs_v(axes: str, pitch: np.ndarray, roll: np.ndarray, tilt: np.ndarray, gain: float) -> dict[str, np.ndarray]:
    force = turned(turn_matrix(tilt), LEVEL_FORCE)
    force = turned(roll_matrix(roll), turned(pitch_matrix(pitch), force))
    return {axis: OFFSET_V[axis] + gain * (force @ np.array(K_V_PER_G[axis])) for axis in axes}
