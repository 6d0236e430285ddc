"""Gyros: constant rates on a table in all positions, and a stream of samples through a known motion.

v = B + K·(ω + nonlinearity) + G·f + bias that wanders + noise; K = rows S·u, f the specific force in g. Volts, °/s.
CR table 4's assumed gyros: 0.05 V, 1.25 V/(°/s). Earth turns with 15.041 °/h: (cosφ, 0, −sinφ) in north, east, down.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physics_scenes.field_scenes import six_positions
from physics_scenes.gimbal_scenes import coned_axis
from physics_scenes.rotations import FloatArray, gimbal_matrix, roll_matrix, turned, yaw_matrix
from physics_scenes.scene import Scene

EARTH_DPH = 15.041


@dataclass(frozen=True)
class GyroSetup:
    """What a laboratory chooses: constant rates, or the profile of CR table 4."""

    rates_dps: tuple[float, ...] = (-100.0, -50.0, -20.0, 0.0, 20.0, 50.0, 100.0)
    replications: int = 3
    latitude_deg: float = 37.09
    heading_deg: float = 30.0
    """Of the table's forward axis, where it stands still."""
    dwell_noise_v: float = 20e-6
    duration_s: float = 10.0
    sample_hz: float = 100.0
    sample_noise_v: float = 200e-6
    amplitude_deg: float = 10.0


@dataclass(frozen=True)
class GyroWorld:
    """What is true of n triads of gyros."""

    setup: GyroSetup
    campaigns: int
    earth_dph: float = 0.0
    g_sensitivity_v_per_g: FloatArray | float = 0.0
    """(n, 3, 3): G"""
    cubic_per_dps2: FloatArray | float = 0.0
    """(n, 3): relative change of sensitivity is this times the rate squared"""
    asymmetry: FloatArray | float = 0.0
    """(n, 3): ½ of it times |ω| is added to ω"""
    bias_wander_v: FloatArray | float = 0.0
    """(n, …, 3) in the shape of the readings"""
    spoiled: Callable[[FloatArray, np.random.Generator], FloatArray] | None = None


@dataclass(frozen=True)
class GyroTruth:
    """B, K and G of n triads."""

    offset_v: FloatArray
    """(n, 3)"""
    matrix_v_per_dps: FloatArray
    """(n, 3, 3)"""


@dataclass(frozen=True)
class GyroRates:
    """Means of dwells at constant rates about the vertical: six positions, P rates, three outputs."""

    setup: GyroSetup
    to_package: FloatArray
    """(6, 3, 3) from table axes: x up, x down, y up, y down, z up, z down; the table turns about its down axis"""
    rates_dps: FloatArray
    """(P,) about down"""
    output_v: FloatArray
    """(n, R, 6, P, 3)"""
    truth: GyroTruth
    mean_earth_dps: FloatArray
    """(6, P, 3) Earth's rate in package axes, mean over the dwell (whole turns where the table turns)"""


@dataclass(frozen=True)
class GyroStream:
    """Samples through a known motion; a value that is lost is NaN."""

    setup: GyroSetup
    time_s: FloatArray
    """(T,)"""
    true_euler_deg: FloatArray
    """(T, 3) pitch, yaw, roll"""
    true_rate_dps: FloatArray
    """(T, 3) in package axes, against the laboratory"""
    output_v: FloatArray
    """(n, T, 3)"""
    truth: GyroTruth


def earth_rate(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """Earth turns under the table with the size times 15.041 °/h: a vertical part in every dwell."""
    return replace(world, earth_dph=size * EARTH_DPH)


def g_sensitivity(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """Gravity acts on the gyros: the size in (°/h)/g, through a matrix of any direction."""
    volts = size / 3600.0 * 1.25
    return replace(world, g_sensitivity_v_per_g=volts * chance.standard_normal((world.campaigns, 3, 3)))


def nonlinearity(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """The scale factor changes with rate: the size in ppm of it at 100 °/s, as the square, either way."""
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 3))
    return replace(world, cubic_per_dps2=size * 1e-6 / 100.0**2 * sign)


def asymmetry(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """The scale factor differs between both senses of rotation by the size in ppm, either way."""
    return replace(world, asymmetry=size * 1e-6 * chance.choice([-1.0, 1.0], (world.campaigns, 3)))


def bias_instability(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """The bias flickers: the size in °/h, as the sum of processes with memories of 1, 4, 16 and 64 readings."""
    count, volts = _readings(world), size / 3600.0 * 1.25
    wander = sum(_remembering(chance, world.campaigns, count, memory) for memory in (1.0, 4.0, 16.0, 64.0))
    return replace(world, bias_wander_v=0.5 * volts * wander)


def bias_walk(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """The bias walks at random: the size in °/h is its standard deviation at the end of the run."""
    count, volts = _readings(world), size / 3600.0 * 1.25
    walk = np.cumsum(chance.standard_normal((world.campaigns, count, 3)), axis=1) / np.sqrt(count)
    return replace(world, bias_wander_v=volts * walk)


def missing_samples(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """Single values are NaN: the size is their share, each axis on its own."""

    def spoiled(output_v: FloatArray, chance: np.random.Generator) -> FloatArray:
        return np.where(chance.uniform(size=output_v.shape) < size, np.nan, output_v)

    return replace(world, spoiled=spoiled)


def dropout(world: GyroWorld, size: float, chance: np.random.Generator) -> GyroWorld:
    """The link is lost once for the size in seconds, in the middle eight tenths: all axes are NaN there."""

    def spoiled(output_v: FloatArray, chance: np.random.Generator) -> FloatArray:
        count = output_v.shape[1]
        gap = round(size * world.setup.sample_hz)
        first = chance.integers(count // 10, max(9 * count // 10 - gap, count // 10 + 1), (world.campaigns, 1))
        lost = (np.arange(count) >= first) & (np.arange(count) < first + gap)
        return np.where(lost[..., None], np.nan, output_v)

    return replace(world, spoiled=spoiled)


def draw_rates(
    build: Callable[..., GyroWorld], size: float, setup: GyroSetup, campaigns: int, chance: np.random.Generator
) -> GyroRates:
    """Draw n calibrations at constant rates."""
    sensors, scene, noise = chance.spawn(3)
    world, truth = build(GyroWorld(setup, campaigns), size, scene), _draw_truth(campaigns, sensors)
    positions, rates = six_positions(), np.array(setup.rates_dps)
    earth = _mean_earth_dps(world, rates)
    spin = np.array([0.0, 0.0, 1.0]) * rates[:, None]
    omega = np.einsum("pij,qj->pqi", positions, spin) + earth
    force = np.einsum("pij,j->pi", positions, np.array([0.0, 0.0, -1.0]))[:, None]
    clean = _output_v(world, truth, omega.reshape(-1, 3), np.broadcast_to(force, omega.shape).reshape(-1, 3))
    shape = (campaigns, setup.replications, *omega.shape)
    wander = np.broadcast_to(world.bias_wander_v, (campaigns, int(np.prod(shape[1:4])), 3)).reshape(shape)
    output = clean.reshape(campaigns, 1, *omega.shape) + wander + setup.dwell_noise_v * noise.standard_normal(shape)
    return GyroRates(setup, positions, rates, output, truth, earth)


def draw_stream(
    build: Callable[..., GyroWorld], size: float, setup: GyroSetup, campaigns: int, chance: np.random.Generator
) -> GyroStream:
    """Draw n streams through the harmonic motion of CR table 4."""
    sensors, scene, noise, loss = chance.spawn(4)
    world, truth = build(GyroWorld(setup, campaigns), size, scene), _draw_truth(campaigns, sensors)
    time = np.arange(round(setup.duration_s * setup.sample_hz) + 1) / setup.sample_hz
    euler, euler_rate = harmonic_motion(time, setup.amplitude_deg)
    omega = package_rate_dps(euler, euler_rate)
    force = turned(gimbal_matrix(*np.deg2rad(euler).T), np.array([0.0, 0.0, -1.0]))
    shape = (campaigns, time.size, 3)
    output = _output_v(world, truth, omega, force) + np.broadcast_to(world.bias_wander_v, shape)
    output = output + setup.sample_noise_v * noise.standard_normal(shape)
    if world.spoiled is not None:
        output = world.spoiled(output, loss)
    return GyroStream(setup, time, euler, omega, output, truth)


def harmonic_motion(time_s: FloatArray, amplitude_deg: float) -> tuple[FloatArray, FloatArray]:
    """Return pitch, yaw, roll (T, 3) in degrees and their rates: 0.125, 0.0625 and 0.25 Hz. Source: CR IV-C."""
    turning = 2.0 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * turning
    return amplitude_deg * np.sin(phase), amplitude_deg * turning * np.cos(phase)


def package_rate_dps(euler_deg: FloatArray, euler_rate_dps: FloatArray) -> FloatArray:
    """Return the angular velocity (T, 3) in package axes: each axis' rate turned by what comes after it."""
    _, yaw, roll = np.deg2rad(euler_deg).T
    unit = np.eye(3)
    by_pitch = turned(roll_matrix(roll) @ yaw_matrix(yaw), unit[1])
    by_yaw = turned(roll_matrix(roll), unit[2])
    return euler_rate_dps[:, :1] * by_pitch + euler_rate_dps[:, 1:2] * by_yaw + euler_rate_dps[:, 2:] * unit[0]


def _mean_earth_dps(world: GyroWorld, rates_dps: FloatArray) -> FloatArray:
    """(6, P, 3): where the table turns, whole turns leave only the vertical part of Earth's rate."""
    rate, latitude = world.earth_dph / 3600.0, np.deg2rad(world.setup.latitude_deg)
    vertical = np.array([0.0, 0.0, -rate * np.sin(latitude)])
    north = turned(yaw_matrix(np.deg2rad(world.setup.heading_deg)), np.array([rate * np.cos(latitude), 0.0, 0.0]))
    seen = vertical + np.where(rates_dps[:, None] == 0.0, north, 0.0)
    return np.einsum("pij,qj->pqi", six_positions(), seen)


def _draw_truth(campaigns: int, chance: np.random.Generator) -> GyroTruth:
    shape = (campaigns, 3)
    sensitivity = 1.25 * (1.0 + 0.01 * chance.uniform(-1.0, 1.0, shape))
    coning, azimuth = np.deg2rad(chance.uniform(0.05, 0.3, shape)), chance.uniform(-np.pi, np.pi, shape)
    units = [coned_axis(axis, coning[:, i], azimuth[:, i]) for i, axis in enumerate("xyz")]
    return GyroTruth(0.05 + 0.002 * chance.standard_normal(shape), sensitivity[..., None] * np.stack(units, axis=-2))


def _output_v(world: GyroWorld, truth: GyroTruth, omega_dps: FloatArray, force_g: FloatArray) -> FloatArray:
    """(n, T, 3) for (T, 3): along each gyro's own axis, bent there."""
    sensitivity = np.linalg.norm(truth.matrix_v_per_dps, axis=-1)
    units = truth.matrix_v_per_dps / sensitivity[..., None]
    along = np.einsum("nai,ti->nta", units, omega_dps)
    cubic = np.broadcast_to(world.cubic_per_dps2, sensitivity.shape)[:, None]
    uneven = np.broadcast_to(world.asymmetry, sensitivity.shape)[:, None]
    bent = along + cubic * along**3 + 0.5 * uneven * np.abs(along)
    by_gravity = np.einsum("nai,ti->nta", np.broadcast_to(world.g_sensitivity_v_per_g, units.shape), force_g)
    return truth.offset_v[:, None] + sensitivity[:, None] * bent + by_gravity


def _readings(world: GyroWorld) -> int:
    """Readings of each gyro at constant rates, in order of time."""
    return world.setup.replications * 6 * len(world.setup.rates_dps)


def _remembering(chance: np.random.Generator, campaigns: int, count: int, memory: float) -> FloatArray:
    kept = np.exp(-1.0 / memory)
    noise = chance.standard_normal((campaigns, count, 3))
    state = noise.copy()
    for reading in range(1, count):
        state[:, reading] = kept * state[:, reading - 1] + np.sqrt(1.0 - kept**2) * noise[:, reading]
    return state


def _rates(
    name: str, build: Callable[..., GyroWorld], unit: str, sizes: tuple[float, ...], cause: str | None = None
) -> Scene:
    return Scene(name, build, unit, sizes, cause, draws=draw_rates, setup=GyroSetup)


def _stream(name: str, build: Callable[..., GyroWorld], unit: str, sizes: tuple[float, ...]) -> Scene:
    return Scene(name, build, unit, sizes, draws=draw_stream, setup=GyroSetup)


GYRO_SCENES = (
    _rates("gyro-earth-rate", earth_rate, "× 15.041 °/h", (0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)),
    _rates("gyro-g-sensitivity", g_sensitivity, "(°/h)/g", (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0), "lack-of-fit"),
    _rates("gyro-nonlinearity", nonlinearity, "ppm", (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0), "cubic"),
    _rates("gyro-asymmetry", asymmetry, "ppm", (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0), "asymmetry"),
    _rates("gyro-bias-instability", bias_instability, "°/h", (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0), "autocorrelation"),
    _rates("gyro-bias-walk", bias_walk, "°/h", (0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0), "drift"),
    _stream("gyro-missing-samples", missing_samples, "share", (0.0, 0.001, 0.01, 0.05, 0.2)),
    _stream("gyro-dropout", dropout, "s", (0.0, 0.02, 0.05, 0.1, 0.5, 2.0)),
)
