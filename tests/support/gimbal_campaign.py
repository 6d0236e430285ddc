"""Campaigns of packages on a gimbal of pitch, yaw and roll, from physics: three matrices turn gravity in turn.

Curves of index errors are those of ``physics_scenes``; sensors are linear, or have terms of their own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from physics_scenes.rotations import ARCSEC, LEVEL_FORCE, pitch_matrix, roll_matrix, turned, yaw_matrix

from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations

FloatArray = NDArray[np.float64]
GIMBAL_AXES = ("pitch", "yaw", "roll")
Curve = Callable[[FloatArray], FloatArray]
"""Angles (N,), rad, to the errors (1, N) of one table there."""
Terms = Callable[[FloatArray], FloatArray]
"""Force (N, 3), g, to what an output has beside its linear part, (N, 3) over the axes, g."""


@dataclass(frozen=True)
class GimbalDesign:
    """Attitudes on a grid, measured again and again, each time in another order."""

    pitch_deg: tuple[float, ...] = (-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0)
    yaw_deg: tuple[float, ...] = (-30.0, -15.0, 0.0, 15.0, 30.0)
    roll_deg: tuple[float, ...] = (-150.0, -90.0, -30.0, 30.0, 90.0, 150.0)
    replications: int = 4
    noise_arcsec: float = 1.65

    def points_rad(self) -> FloatArray:
        """Return (3, K) pitch, yaw and roll."""
        grid = np.meshgrid(self.pitch_deg, self.yaw_deg, self.roll_deg, indexing="ij")
        return np.deg2rad(np.stack([angles.ravel() for angles in grid]))


def on_a_gimbal(
    chance: np.random.Generator,
    design: GimbalDesign,
    curves: Mapping[str, Curve] | None = None,
    terms: Terms | None = None,
    *,
    is_on_sting: bool = False,
    play_arcsec: Mapping[str, float] | None = None,
    order: Literal["random", "there and back"] = "random",
) -> Observations:
    """Return a package of x, y and z, its truth drawn anew; ``is_on_sting``: roll does not reach it.

    ``play_arcsec``: how far apart an axis comes to rest by the side that it came from. ``order``: of the points.
    """
    points = design.points_rad()
    forth = np.arange(points.shape[1])
    point = np.concatenate(
        [
            chance.permutation(forth) if order == "random" else forth[:: 1 if replication % 2 == 0 else -1]
            for replication in range(design.replications)
        ]
    )
    stood = dict(zip(GIMBAL_AXES, points[:, point], strict=True))
    true = {
        axis: stood[axis] + curves[axis](stood[axis])[0] if axis in (curves or {}) else stood[axis] for axis in stood
    }
    for axis, size in (play_arcsec or {}).items():
        true[axis] = true[axis] + 0.5 * size * ARCSEC * _came_from(stood[axis], chance)
    force = turned(yaw_matrix(true["yaw"]), turned(pitch_matrix(true["pitch"]), LEVEL_FORCE))
    if not is_on_sting:
        force = turned(roll_matrix(true["roll"]), force)
    offset, scale = 0.05 * chance.standard_normal(3), 2.5 + 0.1 * chance.standard_normal(3)
    directions = np.eye(3) + 0.005 * chance.standard_normal((3, 3))
    sensed = force @ directions.T + (0.0 if terms is None else terms(force))
    read = offset + scale * (sensed + design.noise_arcsec * ARCSEC * chance.standard_normal(sensed.shape))
    return Observations(
        replication=np.repeat(np.arange(1, design.replications + 1), points.shape[1]), point=point + 1,
        pitch_rad=stood["pitch"], roll_rad=stood["roll"], yaw_rad=stood["yaw"],
        time_s=40.0 * np.arange(point.size), outputs=dict(zip("xyz", read.T, strict=True)),
    )  # fmt: skip


def _came_from(angle_rad: FloatArray, chance: np.random.Generator) -> FloatArray:
    """Return the sense of the last move before each dwell; before the first move either."""
    way, ways = float(chance.choice([-1.0, 1.0])), []
    for before, here in zip(np.append(angle_rad[:1], angle_rad[:-1]), angle_rad, strict=True):
        way = way if here == before else float(np.sign(here - before))
        ways.append(way)
    return np.array(ways)


def gimbal_limits(limit_arcsec: float = 1.0) -> TableUncertainty:
    """Return the same limit of all three axes."""
    return TableUncertainty(limit_arcsec * ARCSEC, limit_arcsec * ARCSEC, "limit", yaw_rad=limit_arcsec * ARCSEC)
