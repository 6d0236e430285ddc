"""Two packages of CR: one in the sting, which pitches and yaws, one in the model, which rolls as well.

Tunnel axes have z down and gravity (0, 0, −1) g there; half a turn about y comes first (CR III-B.2). A coefficient
vector here is B and k = S·u with output = B + k·(gravity in package axes), CR's convention.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physics_scenes.rotations import (
    ARCSEC,
    FloatArray,
    gimbal_matrix,
    pitch_matrix,
    roll_matrix,
    turned,
    yaw_matrix,
)
from physics_scenes.scene import Scene

PACKAGES = ("sting", "model")
GRAVITY_IN_TUNNEL = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class GimbalSetup:
    """What is chosen before two packages are calibrated on a gimbal and used."""

    pitch_limit_deg: float = 60.0
    pitch_count: int = 7
    yaw_limit_deg: float = 30.0
    yaw_count: int = 3
    roll_count: int = 12
    replications: int = 4
    noise_arcsec: float = 1.65
    use_rows: int = 50
    use_limits_deg: tuple[float, float, float] = (30.0, 20.0, 180.0)
    """Of pitch, yaw and roll."""

    def calibration_euler_deg(self) -> FloatArray:
        """(K, 3) pitch, yaw, roll."""
        pitch = np.linspace(-self.pitch_limit_deg, self.pitch_limit_deg, self.pitch_count)
        yaw = np.linspace(-self.yaw_limit_deg, self.yaw_limit_deg, self.yaw_count)
        roll = -180.0 + 360.0 / self.roll_count * np.arange(self.roll_count)
        return np.stack([angle.ravel() for angle in np.meshgrid(pitch, yaw, roll, indexing="ij")], axis=1)


@dataclass(frozen=True)
class GimbalReadings:
    """n pairs of packages: calibrated, then used. Arrays are campaigns, (replications,) rows, packages, axes."""

    setup: GimbalSetup
    calibration_euler_deg: FloatArray
    """(K, 3) true and indicated pitch, yaw, roll"""
    calibration_v: FloatArray
    """(n, R, K, 2, 3)"""
    use_euler_deg: FloatArray
    """(J, 3) true"""
    use_v: FloatArray
    """(n, J, 2, 3)"""
    offset_v: FloatArray
    """(n, 2, 3)"""
    vector_v_per_g: FloatArray
    """(n, 2, 3, 3)"""
    faulty_package: np.ndarray
    faulty_axis: np.ndarray
    """(n,); −1 where none is."""


@dataclass(frozen=True)
class GimbalWorld:
    """What a scene may change."""

    setup: GimbalSetup
    campaigns: int
    lost: FloatArray | float = 0.0
    """(n, 2, 3) share of the signal that is lost in use"""
    faulty_package: np.ndarray | int = -1
    faulty_axis: np.ndarray | int = -1


def gravity_in_packages(euler_deg: FloatArray) -> FloatArray:
    """Return gravity (K, 2, 3) in the axes of sting and model package, in g."""
    pitch, yaw, roll = np.deg2rad(euler_deg).T
    matrices = [gimbal_matrix(pitch, yaw, np.zeros_like(roll)), gimbal_matrix(pitch, yaw, roll)]
    return np.stack([turned(matrix, GRAVITY_IN_TUNNEL) for matrix in matrices], axis=1)


def coned_axis(axis: str, coning_rad: FloatArray, azimuth_rad: FloatArray) -> FloatArray:
    """Return u (..., 3) in CR's convention, azimuth turned first. Source: CR (III-B.7) to (III-B.12)."""
    if axis == "x":
        return (pitch_matrix(coning_rad) @ roll_matrix(azimuth_rad))[..., 0, :]
    if axis == "y":
        return (yaw_matrix(coning_rad) @ pitch_matrix(azimuth_rad))[..., 1, :]
    return (roll_matrix(coning_rad) @ yaw_matrix(azimuth_rad))[..., 2, :]


def both_good(world: GimbalWorld, size: float, chance: np.random.Generator) -> GimbalWorld:
    """Nothing is wrong with either package: a row that is flagged here is a false alarm."""
    return world


def dead_axis(world: GimbalWorld, size: float, chance: np.random.Generator) -> GimbalWorld:
    """One axis of one of the packages has lost the size of its signal in use; at 1 it reads its offset."""
    package, axis = chance.integers(0, 2, world.campaigns), chance.integers(0, 3, world.campaigns)
    return _dead(world, size, package, axis)


def dead_model_y(world: GimbalWorld, size: float, chance: np.random.Generator) -> GimbalWorld:
    """The y axis of the model package has lost the size of its signal: roll depends on it."""
    return _dead(world, size, np.ones(world.campaigns, dtype=int), np.ones(world.campaigns, dtype=int))


def sting_without_yaw(world: GimbalWorld, size: float, chance: np.random.Generator) -> GimbalWorld:
    """The gimbal yaws by no more than ± the size in degrees while the packages are calibrated.

    At 0 the sting package never sees gravity along y: its y axis has no sensitivity that data could tell, and the third
    component of no axis; an offset along y and what is missing are one.
    """
    return replace(world, setup=replace(world.setup, yaw_limit_deg=size, yaw_count=3 if size else 1))


def draw_gimbal(
    build: Callable[..., GimbalWorld], size: float, setup: GimbalSetup, campaigns: int, chance: np.random.Generator
) -> GimbalReadings:
    """Draw n pairs of packages, their calibrations and their readings in use."""
    rows, packages, scene, noise = chance.spawn(4)
    limits = np.array(setup.use_limits_deg)
    use_euler = rows.uniform(-limits, limits, (setup.use_rows, 3))
    shape = (campaigns, 2, 3)
    sensitivity = 2.5 * (1.0 + 0.01 * packages.uniform(-1.0, 1.0, shape))
    coning, azimuth = np.deg2rad(packages.uniform(0.05, 1.0, shape)), packages.uniform(-np.pi, np.pi, shape)
    units = [coned_axis(axis, coning[..., i], azimuth[..., i]) for i, axis in enumerate("xyz")]
    vector = sensitivity[..., None] * np.stack(units, axis=-2)
    offset = 0.01 * packages.standard_normal(shape)
    world = build(GimbalWorld(setup, campaigns), size, scene)
    calibration_euler = world.setup.calibration_euler_deg()
    noise_v = setup.noise_arcsec * ARCSEC * sensitivity
    calibration = offset[:, None] + _signal(calibration_euler, vector)
    calibration_shape = (campaigns, setup.replications, *calibration.shape[1:])
    calibration_v = calibration[:, None] + noise_v[:, None, None] * noise.standard_normal(calibration_shape)
    lost = np.broadcast_to(world.lost, shape)[:, None]
    used = offset[:, None] + (1.0 - lost) * _signal(use_euler, vector)
    use_v = used + noise_v[:, None] * noise.standard_normal(used.shape)
    faulty = [np.broadcast_to(which, campaigns) for which in (world.faulty_package, world.faulty_axis)]
    return GimbalReadings(world.setup, calibration_euler, calibration_v, use_euler, use_v, offset, vector, *faulty)


def _signal(euler_deg: FloatArray, vector: FloatArray) -> FloatArray:
    """(n, K, 2, 3)"""
    return np.einsum("kpc,npac->nkpa", gravity_in_packages(euler_deg), vector)


def _dead(world: GimbalWorld, size: float, package: np.ndarray, axis: np.ndarray) -> GimbalWorld:
    lost = np.zeros((world.campaigns, 2, 3))
    lost[np.arange(world.campaigns), package, axis] = size
    return replace(world, lost=lost, faulty_package=package, faulty_axis=axis)


LOST = (0.0, 1e-5, 3e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0)
GIMBAL_SCENES = (
    Scene("two-packages-good", both_good, "none", (0.0,), declared_up_to=0.0, draws=draw_gimbal, setup=GimbalSetup),
    Scene("two-packages-dead-axis", dead_axis, "share", LOST, flags_rows=True, draws=draw_gimbal, setup=GimbalSetup),
    Scene(
        "two-packages-dead-model-y", dead_model_y, "share", LOST, flags_rows=True, draws=draw_gimbal, setup=GimbalSetup
    ),
    Scene(
        "sting-without-yaw",
        sting_without_yaw,
        "deg",
        (0.0, 0.01, 0.1, 1.0, 5.0, 30.0),
        declared_up_to=30.0,
        draws=draw_gimbal,
        setup=GimbalSetup,
        zero_is_clean=False,
    ),
)
