"""One package measured twice on one table: as it is, then turned on its seat. The table's curves are the same in both.

What is drawn anew in every campaign: the curves of pitch and roll, ordinary sensors with terms of second and third
order, the seat of every mounting but the first, what every replication moves, and noise.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physics_scenes.designs import Schedule, Setup, timed
from physics_scenes.package import Package, draw_package
from physics_scenes.rotations import ARCSEC, FloatArray, specific_force, turn_matrix, turned
from physics_scenes.tables import Curve, Table

CurveOf = Callable[[float, int, np.random.Generator], Curve]
UPRIGHT, ABOUT_X, ABOUT_Y, ABOUT_Z = (np.diag(signs).astype(float) for signs in (
    (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1),
))  # fmt: skip
"""From the axes of the seat to those of the package: as it is, and turned half round."""
MICRO = 1e-6


@dataclass(frozen=True)
class Sizes:
    """How large what is drawn is."""

    curve_arcsec: float = 1.0
    terms_micro: float = 2.0
    """Standard deviation of every element of second order and of the cubic term, in µg/g² and µg/g³."""
    seat_arcsec: float = 5.0
    drift_arcsec: float = 0.0
    """Standard deviation of the offset between replications."""
    drift_ppm: float = 0.0
    """The same of the sensitivity."""


@dataclass(frozen=True)
class Mounted:
    """The rows of one mounting."""

    package_from_table: FloatArray
    pitch_deg: FloatArray
    roll_deg: FloatArray
    """(K,) as shown by the table."""
    output_v: FloatArray
    """(n, R, K, A)"""


@dataclass(frozen=True)
class Remounted:
    """n packages in all their mountings."""

    package: Package
    """(n, 1, A)"""
    mountings: tuple[Mounted, ...]

    def best_linear(self) -> FloatArray:
        """Return (n, A, 4) offset and sensitivities of the linear sensor that comes closest over all mountings."""
        force = np.concatenate([
            specific_force(np.deg2rad(m.pitch_deg), np.deg2rad(m.roll_deg)) @ m.package_from_table.T
            for m in self.mountings
        ])  # fmt: skip
        basis = np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)
        true_v = self.package.response_v(force[None, :, None])[:, :, 0]
        return np.einsum("jd,nda->naj", np.linalg.pinv(basis), true_v)


def remounted(
    curve_of: CurveOf,
    sizes: Sizes,
    setup: Setup,
    campaigns: int,
    chance: np.random.Generator,
    turns: tuple[FloatArray, ...] = (UPRIGHT, ABOUT_Z),
) -> Remounted:
    """Draw campaigns; ``setup.replications`` in each mounting."""
    package = _bent(draw_package(setup, campaigns, chance), sizes.terms_micro * MICRO, chance)
    limit = sizes.curve_arcsec * ARCSEC
    table = Table(curve_of(limit, campaigns, chance), curve_of(limit, campaigns, chance))
    points = setup.points_deg()
    schedule = timed([("point", 0, index, *map(float, point)) for index, point in enumerate(points)], setup)
    mountings = [_mounted(package, table, schedule, turn, number > 0, sizes, setup, chance)
                 for number, turn in enumerate(turns)]  # fmt: skip
    return Remounted(package, tuple(mountings))


def _bent(package: Package, size: float, chance: np.random.Generator) -> Package:
    shape = package.offset_v.shape
    drawn = size * chance.standard_normal((*shape, 3, 3))
    symmetric = (drawn + np.swapaxes(drawn, -1, -2)) / np.sqrt(2.0)
    return replace(package, q_per_g=symmetric, cubic_per_g2=size * chance.standard_normal(shape))


def _mounted(
    package: Package,
    table: Table,
    schedule: Schedule,
    turn: FloatArray,
    is_seated_anew: bool,
    sizes: Sizes,
    setup: Setup,
    chance: np.random.Generator,
) -> Mounted:
    n, r = package.offset_v.shape[0], setup.replications
    force = table.force_g(schedule) @ turn.T
    if is_seated_anew:
        force = turned(turn_matrix(sizes.seat_arcsec * ARCSEC * chance.standard_normal((n, 1, 3))), force)
    sensed_v = package.response_v(np.broadcast_to(force, (n, *force.shape[1:]))[:, :, None])[:, None, :, 0]
    arcsec_v = ARCSEC * package.sensitivity_v_per_g[:, None]
    gain = 1.0 + sizes.drift_ppm * MICRO * chance.standard_normal((n, r, 1, sensed_v.shape[-1]))
    moved = sizes.drift_arcsec * arcsec_v * chance.standard_normal(gain.shape)
    noise = setup.noise_arcsec * arcsec_v * chance.standard_normal((n, r, *sensed_v.shape[2:]))
    offset = package.offset_v[:, None]
    return Mounted(turn, schedule.pitch_deg, schedule.roll_deg, offset + moved + gain * (sensed_v - offset) + noise)
