"""Scenes of temperature: the sensor is not as warm as the record says, or does not answer as the model says.

The sensors' own coefficients are ordinary ones, 25 µg/°C of offset and 50 ppm/°C of sensitivity, either sign.
"""

from dataclasses import replace

import numpy as np

from physics_scenes.designs import Schedule
from physics_scenes.package import REFERENCE_DEGC, mounted_force
from physics_scenes.rotations import FloatArray, random_directions
from physics_scenes.scene import Scene
from physics_scenes.world import World

OFFSET_TC_G_PER_DEGC = 25e-6
SENSITIVITY_TC_PER_DEGC = 50e-6
PLATEAUS = {"plateaus_degc": (15.0, 25.0, 20.0, 25.0, 15.0, 20.0)}
"""Each is visited twice, 20 °C once from above and once from below; hardly correlated with time."""
SELF_HEATING_S = 1800.0


def lag(world: World, size: float, chance: np.random.Generator) -> World:
    """The sensor follows the chamber with a time constant of the size in hours; the record holds the chamber's.

    Ṫ = (T_chamber − T)/τ. Half an hour of soak leaves a fifth of a step of 5 °C with τ = 0.3 h.
    """
    warm = _warm(world, chance)
    true_degc = followed_degc(world.schedule, size * 3600.0)
    return replace(warm, sensor_degc=true_degc[None, :, None])


def curvature(world: World, size: float, chance: np.random.Generator) -> World:
    """Offset and sensitivity bend with temperature: the size in µg/°C² of offset and in ppm/°C² of sensitivity."""
    warm = _warm(world, chance)
    signs = chance.choice([-1.0, 1.0], (2, *_shape(world)))
    bend = size * 1e-6
    package = replace(
        warm.package,
        offset_tc2_v_per_degc2=bend * signs[0] * warm.package.sensitivity_v_per_g,
        sensitivity_tc2_per_degc2=bend * signs[1],
    )
    return replace(warm, package=package)


def in_step(world: World, size: float, chance: np.random.Generator) -> World:
    """The room's temperature swings by the size in °C with the period of one replication, recorded, not modelled.

    One phase in all replications: replications agree and all are wrong by the same. TP 28(a) is a case of it.
    """
    phase = chance.uniform(0.0, 2.0 * np.pi, (world.campaigns, 1))
    turns = world.schedule.replication_phase() * 2.0 * np.pi
    return _recorded(_warm(world, chance), size * np.sin(turns + phase))


def alternating(world: World, size: float, chance: np.random.Generator) -> World:
    """Replications are warmer and colder by turns by the size in °C (day and night shifts), recorded, not modelled."""
    sign = np.where(world.schedule.replication % 2 == 0, 1.0, -1.0)
    return _recorded(_warm(world, chance), size * sign[None])


def room_offset(world: World, size: float, chance: np.random.Generator) -> World:
    """The whole campaign is warmer than the reference by the size in °C, either way, recorded, not modelled.

    The truth is the sensor at 20 °C: without a model or a range of use in the budget the offset is wrong by tc·ΔT and
    no test of the residuals can know.
    """
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 1))
    return _recorded(_warm(world, chance), size * sign * np.ones((1, world.schedule.dwells)))


def daily(world: World, size: float, chance: np.random.Generator) -> World:
    """The room follows the day: a swing of the size in °C, period 24 h, any phase, recorded, not modelled."""
    phase = chance.uniform(0.0, 2.0 * np.pi, (world.campaigns, 1))
    swing = np.sin(2.0 * np.pi * world.schedule.time_s / 86400.0 + phase)
    return _recorded(_warm(world, chance), size * (swing - swing.mean(axis=1, keepdims=True)))


def stratified(world: World, size: float, chance: np.random.Generator) -> World:
    """The air in the chamber is layered: the sensor on its arm is warmer at the top by the size in °C, not recorded.

    ΔT = size·sinα. The offset's share has the form of a sensitivity along x and no residual shows it; the share of the
    sensitivity, sinα·f, is a second order. Only the budget can hold the first.
    """
    height = np.sin(np.deg2rad(world.schedule.pitch_deg))
    true_degc = world.schedule.chamber_degc + size * height
    return replace(_warm(world, chance), sensor_degc=true_degc[None, :, None])


def gradient(world: World, size: float, chance: np.random.Generator) -> World:
    """A gradient through the package turns with it: warm air rises around it, so that one axis' two ends differ.

    Its offset takes size (µg) times the square of the force along a direction of the housing, random for each sensor
    and axis: one face is heated whichever end is up.
    """
    warm = _warm(world, chance)
    force = mounted_force(world.setup, world.schedule.pitch_deg, world.schedule.roll_deg)
    across = np.einsum("dsc,nsac->ndsa", force, random_directions(chance, *_shape(world)))
    return replace(warm, added_g=world.added_g + size * 1e-6 * (across**2 - 1.0 / 3.0))


def self_heating(world: World, size: float, chance: np.random.Generator) -> World:
    """Power was switched on at the start: the sensor warms by the size in °C with half an hour's time constant.

    The chamber's record shows nothing of it. The truth is the warm sensor, at the end of it.
    """
    cold = -size * np.exp(-world.schedule.time_s / SELF_HEATING_S)
    true_degc = world.schedule.chamber_degc + cold
    return replace(_warm(world, chance), sensor_degc=true_degc[None, :, None])


def followed_degc(schedule: Schedule, time_constant_s: float) -> FloatArray:
    """Return the temperature (D,) of a body that follows the chamber; exact for a chamber that steps."""
    if time_constant_s == 0.0:
        return schedule.chamber_degc
    followed = np.empty(schedule.dwells)
    now = schedule.chamber_degc[0]
    kept = np.exp(-np.diff(schedule.time_s, prepend=0.0) / time_constant_s)
    for dwell, chamber in enumerate(schedule.chamber_degc):
        now = chamber + (now - chamber) * kept[dwell]
        followed[dwell] = now
    return followed


def _warm(world: World, chance: np.random.Generator) -> World:
    """Give the sensors their coefficients; the same draw in every scene of temperature."""
    signs = chance.choice([-1.0, 1.0], (2, *_shape(world)))
    package = replace(
        world.package,
        offset_tc_v_per_degc=OFFSET_TC_G_PER_DEGC * signs[0] * world.package.sensitivity_v_per_g,
        sensitivity_tc_per_degc=SENSITIVITY_TC_PER_DEGC * signs[1],
    )
    return replace(world, package=package)


def _recorded(world: World, above_degc: FloatArray) -> World:
    """Let sensors and record both stand at 20 °C plus a column (n, D)."""
    true_degc = REFERENCE_DEGC + np.broadcast_to(above_degc, world.shape[:2])
    return replace(world, sensor_degc=true_degc[..., None], recorded_degc=true_degc)


def _shape(world: World) -> tuple[int, int, int]:
    campaigns, _, sensors, axes = world.shape
    return campaigns, sensors, axes


SWINGS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
TEMPERATURE_SCENES = (
    Scene(
        "temperature-lag",
        lag,
        "h",
        (0.0, 0.05, 0.1, 0.12, 0.15, 0.2, 0.3, 0.5, 1.0),
        "temperature-lag",
        design=PLATEAUS,
        zero_is_clean=False,
    ),
    Scene(
        "temperature-curvature",
        curvature,
        "µg/°C²",
        (0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.3, 1.0),
        "temperature-curvature",
        design=PLATEAUS,
        zero_is_clean=False,
    ),
    Scene("temperature-in-step", in_step, "°C", SWINGS, "temperature-residual", also=("lack-of-fit",)),
    Scene("temperature-alternating", alternating, "°C", SWINGS, "temperature-residual", also=("drift",)),
    Scene("temperature-daily", daily, "°C", SWINGS, "temperature-residual", also=("drift",)),
    Scene("temperature-room", room_offset, "°C", SWINGS),
    Scene("temperature-stratified", stratified, "°C", (*SWINGS, 2.0)),
    Scene(
        "temperature-gradient",
        gradient,
        "µg",
        (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0),
        "quadratic",
        also=("cross-coupling", "lack-of-fit"),
    ),
    Scene(
        "temperature-self-heating",
        self_heating,
        "°C",
        (*SWINGS, 2.0),
        "drift",
        also=("autocorrelation", "temperature-lag"),
    ),
)
