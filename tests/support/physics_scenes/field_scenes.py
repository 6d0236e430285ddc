"""Two-level calibration of a magnetometer: each axis up and down along a coil, with the coil's field and without.

m = M·(R·(B_earth + level·B_coil)) + o in counts, R from laboratory axes (north, east, down) to package axes, M 3 × 3.
Reversing one axis leaves the horizontal part of Earth's field where it was or turns it aside: misalignment times cross
field looks like an offset unless M is solved whole. Source: MATH 10, SR on the magnetometer.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physics_scenes.rotations import FloatArray, pitch_matrix, random_directions, roll_matrix, turn_matrix, turned
from physics_scenes.scene import Scene

COUNTS_PER_UT = 31.24
"""SR's magnetometer, MATH 7."""


@dataclass(frozen=True)
class FieldSetup:
    """What a laboratory chooses before a two-level calibration."""

    earth_ut: float = 46.6
    inclination_deg: float = 62.0
    coil_ut: float = 100.0
    levels: tuple[float, ...] = (0.0, 1.0)
    """Of the coil's current; (−1, 1) reverses it."""
    replications: int = 4
    noise_counts: float = 1.0
    coning_deg: float = 0.0
    """Of every axis, to any side, before a scene changes it."""


@dataclass(frozen=True)
class FieldWorld:
    """What is true of n calibrations."""

    setup: FieldSetup
    campaigns: int
    coning_deg: float
    coil_turn_rad: FloatArray | float = 0.0
    """(n, 3) rotation vector of the coil from the vertical"""
    earth_change_ut: FloatArray | float = 0.0
    """(n, R, 6, L, 3) in laboratory axes"""
    earth_ratio: float = 1.0
    supply_ratio: FloatArray | float = 1.0
    """(n, R, 6, L) of the coil's current"""


@dataclass(frozen=True)
class FieldReadings:
    """n two-level calibrations: replications, six positions, levels, three outputs."""

    setup: FieldSetup
    to_package: FloatArray
    """(6, 3, 3) from laboratory axes: x up, x down, y up, y down, z up, z down"""
    nominal_earth_ut: FloatArray
    """(3,) in laboratory axes, as declared"""
    nominal_coil_ut: FloatArray
    """(L, 3) in laboratory axes, as declared: along down"""
    counts: FloatArray
    """(n, R, 6, L, 3)"""
    matrix_counts_per_ut: FloatArray
    """(n, 3, 3): M"""
    offset_counts: FloatArray
    """(n, 3): o"""
    true_earth_ut: FloatArray
    """(3,) without its change in time"""
    true_coil_ut: FloatArray
    """(n, 3) at level 1"""


def six_positions() -> FloatArray:
    """Return the matrices (6, 3, 3) that bring x, y, z up and down, by pitch or by roll."""
    quarter = np.pi / 2.0
    level = np.eye(3)
    return np.stack(
        [
            pitch_matrix(quarter),
            pitch_matrix(-quarter),
            roll_matrix(-quarter),
            roll_matrix(quarter),
            roll_matrix(np.pi),
            level,
        ]
    )


def coned_triad(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """Every axis lies off its nominal direction by the size in degrees, to any side: M is not diagonal."""
    return replace(world, coning_deg=size)


def cross_field(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """Earth's field is the size times 46.6 µT, known to the laboratory; axes are coned by half a degree.

    At nothing a shield is around the coil.
    """
    setup = replace(world.setup, earth_ut=world.setup.earth_ut * size)
    return replace(world, setup=setup)


def undeclared_field(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """Earth's field in the laboratory is larger than declared by the size in percent: steel in the floor."""
    return replace(world, earth_ratio=1.0 + size / 100.0)


def coil_direction(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """The coil stands off the vertical by the size in degrees, to any side: a rotation of M, unseen without B_earth."""
    azimuth = chance.uniform(0.0, 2.0 * np.pi, world.campaigns)
    direction = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=-1)
    return replace(world, coil_turn_rad=np.deg2rad(size) * direction)


def earth_wanders(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """Earth's field wanders between readings, normal with the size in µT in any direction: a lift, a tram, the day."""
    shape = (world.campaigns, world.setup.replications, 6, len(world.setup.levels), 3)
    return replace(world, earth_change_ut=size * chance.standard_normal(shape))


def coil_current(world: FieldWorld, size: float, chance: np.random.Generator) -> FieldWorld:
    """The coil's current drifts by the size in percent over the run while it warms."""
    count = world.setup.replications * 6 * len(world.setup.levels)
    phase = np.linspace(-0.5, 0.5, count).reshape(1, world.setup.replications, 6, -1)
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 1, 1, 1))
    return replace(world, supply_ratio=1.0 + size / 100.0 * sign * phase)


def draw_field(
    build: Callable[..., FieldWorld], size: float, setup: FieldSetup, campaigns: int, chance: np.random.Generator
) -> FieldReadings:
    """Draw n two-level calibrations."""
    sensors, scene, noise = chance.spawn(3)
    world = build(FieldWorld(setup, campaigns, setup.coning_deg), size, scene)
    setup = world.setup
    gain = COUNTS_PER_UT * (1.0 + 0.02 * sensors.uniform(-1.0, 1.0, (campaigns, 3, 1)))
    aside = random_directions(sensors, campaigns, 3)
    nominal = np.eye(3)
    across = aside - (aside * nominal).sum(axis=-1, keepdims=True) * nominal
    across = across / np.linalg.norm(across, axis=-1, keepdims=True)
    coning = np.deg2rad(world.coning_deg)
    matrix = gain * (np.cos(coning) * nominal + np.sin(coning) * across)
    offset = 30.0 * sensors.standard_normal((campaigns, 3))
    dip = np.deg2rad(setup.inclination_deg)
    earth = setup.earth_ut * np.array([np.cos(dip), 0.0, np.sin(dip)])
    down = np.array([0.0, 0.0, setup.coil_ut])
    coil_turn = turn_matrix(np.broadcast_to(world.coil_turn_rad, (campaigns, 3)))
    coil = turned(np.swapaxes(coil_turn, -1, -2), down)
    current = np.array(setup.levels) * np.asarray(world.supply_ratio)
    laboratory = world.earth_ratio * earth + world.earth_change_ut + current[..., None] * coil[:, None, None, None]
    shape = (campaigns, setup.replications, 6, len(setup.levels), 3)
    in_package = np.einsum("pij,nrplj->nrpli", six_positions(), np.broadcast_to(laboratory, shape))
    counts = np.einsum("nij,nrplj->nrpli", matrix, in_package) + offset[:, None, None, None]
    counts = counts + setup.noise_counts * noise.standard_normal(shape)
    nominal_coil = np.array(setup.levels)[:, None] * down
    true_earth = world.earth_ratio * earth
    return FieldReadings(setup, six_positions(), earth, nominal_coil, counts, matrix, offset, true_earth, coil)


def _scene(
    name: str,
    build: Callable[..., FieldWorld],
    unit: str,
    sizes: tuple[float, ...],
    cause: str | None = None,
    **more: object,
) -> Scene:
    return Scene(name, build, unit, sizes, cause, draws=draw_field, setup=FieldSetup, **more)  # type: ignore[arg-type]


CONED = {"coning_deg": 0.5}
FIELD_SCENES = (
    _scene("field-coned", coned_triad, "deg", (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0), declared_up_to=5.0),
    _scene(
        "field-cross",
        cross_field,
        "× 46.6 µT",
        (0.0, 0.01, 0.03, 0.1, 0.3, 1.0),
        declared_up_to=1.0,
        design=CONED,
        zero_is_clean=False,
    ),
    _scene(
        "field-undeclared",
        undeclared_field,
        "%",
        (0.0, 0.02, 0.05, 0.1, 0.3, 1.0, 10.0),
        "field-contradicted",
        design=CONED,
    ),
    _scene(
        "field-coil-direction",
        coil_direction,
        "deg",
        (0.0, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0),
        "field-contradicted",
        design=CONED,
    ),
    _scene("field-earth-wanders", earth_wanders, "µT", (0.0, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0), design=CONED),
    _scene("field-coil-current", coil_current, "%", (0.0, 0.01, 0.02, 0.05, 0.1, 0.5, 2.0), "drift", design=CONED),
)
