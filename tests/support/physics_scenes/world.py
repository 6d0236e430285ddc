"""The chain from a table's base to a meter's reading, and what a laboratory is given of it: the campaign.

Base, table, fixture, sensor, sensor's temperature, meter: each link is one field of `World`, and its default is a link
without fault. A scene takes the clean world and replaces the links that its physics touches. Chance comes in four
streams of one generator (order, package, scene, noise), so that a scene of size nothing is the clean campaign to the
last bit, and sizes of one scene are compared with the same sensors and the same noise.

What changes in the middle of a run leaves the truth where it was before; what drifts has its mean over the run as
truth.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from physics_scenes.designs import Schedule, Setup, schedule_of, use_schedule
from physics_scenes.package import REFERENCE_DEGC, Package, draw_package, mounted_force
from physics_scenes.rotations import ARCSEC, FloatArray, turn_matrix, turned
from physics_scenes.tables import Table


@dataclass(frozen=True)
class Event:
    """Where something happened in each campaign, all (n,); −1 is none or all."""

    dwell: np.ndarray
    sensor: np.ndarray
    axis: np.ndarray


@dataclass(frozen=True)
class World:
    """All that is true of n campaigns. Arrays broadcast over (n, D), (n, D, S) or (n, D, S, A) as their name says."""

    setup: Setup
    schedule: Schedule
    campaigns: int
    package: Package
    table: Table = field(default_factory=Table)
    mount_turn_rad: FloatArray | float = 0.0
    """(n, D, S, 3) rotation vector of each sensor from where it was mounted, in its own axes."""
    acceleration_g: FloatArray | float = 0.0
    """(n, D, S, 3) specific force beside gravity's, in package axes: a sting that swings."""
    gravity_ratio: float = 1.0
    """Gravity here against gravity where the sensor was calibrated."""
    sensor_degc: FloatArray | float = REFERENCE_DEGC
    """(n, D, S) true temperature of the sensors."""
    recorded_degc: FloatArray | None = None
    """(n, D) what stands in the record; None is the chamber's own."""
    added_g: FloatArray | float = 0.0
    """(n, D, S, A) change of a sensor's offset, against its sensitivity."""
    gain: FloatArray | float = 1.0
    """(n, D, S, A) change of a sensor's sensitivity, its offset unchanged."""
    meter_gain: FloatArray | float = 1.0
    """(n, D)"""
    meter_offset_v: FloatArray | float = 0.0
    """(n, D)"""
    noise_factor: FloatArray | float = 1.0
    """(n, D, S, A)"""
    faults_before_noise: tuple[Callable[[FloatArray], FloatArray], ...] = ()
    """What happens to outputs (n, D, S, A) in volts on their way to the meter."""
    faults_after_noise: tuple[Callable[[FloatArray], FloatArray], ...] = ()
    """What happens to readings in the meter or its scanner."""
    event: Event | None = None

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """(n, D, S, A)"""
        return self.campaigns, self.schedule.dwells, self.setup.sensors, len(self.setup.axes)

    @property
    def noise_v(self) -> FloatArray:
        """(n, 1, S, A) standard deviation of a dwell."""
        return (self.setup.noise_arcsec * ARCSEC * self.package.sensitivity_v_per_g)[:, None]


@dataclass(frozen=True)
class Campaign:
    """What n laboratories recorded, and the truth beside it. Columns are in order of time; `grid` shapes them."""

    setup: Setup
    schedule: Schedule
    output_v: FloatArray
    """(n, D, S, A)"""
    temperature_degc: FloatArray
    """(n, D) as recorded."""
    true_force_g: FloatArray
    """(n or 1, D, 3) in the axes of the roll plate"""
    package: Package
    """The truth: b and k in each sensor's own axes."""
    event: Event | None = None

    @property
    def campaigns(self) -> int:
        return self.output_v.shape[0]

    @property
    def true_pitch_deg(self) -> FloatArray:
        """(n or 1, D) of the roll plate against gravity."""
        across = np.hypot(self.true_force_g[..., 1], self.true_force_g[..., 2])
        return np.rad2deg(np.arctan2(self.true_force_g[..., 0], across))

    @property
    def true_roll_deg(self) -> FloatArray:
        """(n or 1, D); at ±90° pitch gravity does not tell it."""
        return np.rad2deg(np.arctan2(-self.true_force_g[..., 1], -self.true_force_g[..., 2]))

    @property
    def points_deg(self) -> FloatArray:
        """(K, 2) indicated pitch and roll of the design, in the order of `grid`."""
        return self.setup.points_deg()

    def true_output_v(self, pitch_deg: FloatArray, roll_deg: FloatArray) -> FloatArray:
        """Return the true outputs (n, D, S, A) at true attitudes of the plate (D,), at 20 °C, without noise."""
        return self.package.response_v(mounted_force(self.setup, pitch_deg, roll_deg)[None])

    def grid(self, column: np.ndarray, dwell_axis: int = 1) -> np.ndarray:
        """Shape a column with dwells (…, D, …) into replications and points (…, R, K, …)."""
        return np.take(column, self.schedule.grid_rows(), axis=dwell_axis)

    def visits(self, purpose: str) -> tuple[Schedule, FloatArray]:
        """Return the dwells of one purpose and their outputs (n, d, S, A)."""
        rows = self.schedule.rows(purpose)
        columns = {name: column[rows] for name, column in vars(self.schedule).items()}
        return Schedule(**columns), self.output_v[:, rows]


@dataclass(frozen=True)
class Streams:
    """Four independent generators drawn from one."""

    order: np.random.Generator
    package: np.random.Generator
    scene: np.random.Generator
    noise: np.random.Generator


def streams_of(chance: np.random.Generator) -> Streams:
    """Split a generator; the next call gives other streams."""
    return Streams(*chance.spawn(4))


def clean_world(setup: Setup, campaigns: int, streams: Streams) -> World:
    """Lay out a campaign in which nothing is wrong; sensors stand at the chamber's temperature."""
    schedule = schedule_of(setup, streams.order)
    package = draw_package(setup, campaigns, streams.package)
    return World(setup, schedule, campaigns, package, sensor_degc=schedule.chamber_degc[None, :, None])


def use_world(setup: Setup, package: Package, chance: np.random.Generator) -> World:
    """Lay out the same packages' use, without table or chamber: true attitudes are the indicated ones."""
    return World(setup, use_schedule(setup, chance), package.offset_v.shape[0], package)


def observe(world: World, chance: np.random.Generator) -> Campaign:
    """Read every sensor at every dwell."""
    force = world.table.force_g(world.schedule)
    at_sensor = np.einsum("sij,ndj->ndsi", world.setup.mount_matrices(), force)
    if np.any(world.mount_turn_rad):
        at_sensor = turned(turn_matrix(np.asarray(world.mount_turn_rad)), at_sensor)
    at_sensor = world.gravity_ratio * at_sensor + world.acceleration_g
    offset = world.package.offset_v[:, None]
    sensitivity = world.package.sensitivity_v_per_g[:, None]
    output = world.package.response_v(at_sensor, world.sensor_degc)
    output = offset + world.gain * (output - offset) + sensitivity * world.added_g
    output = _by_dwell(world.meter_gain) * output + _by_dwell(world.meter_offset_v)
    for fault in world.faults_before_noise:
        output = fault(output)
    output = output + world.noise_v * world.noise_factor * chance.standard_normal(world.shape)
    for fault in world.faults_after_noise:
        output = fault(output)
    recorded = world.schedule.chamber_degc[None] if world.recorded_degc is None else world.recorded_degc
    if world.setup.own_thermometer:
        recorded = np.broadcast_to(world.sensor_degc, world.shape[:3])[..., 0]
    temperature = np.broadcast_to(recorded, world.shape[:2])
    return Campaign(world.setup, world.schedule, output, temperature, force, world.package, world.event)


def used_later(campaign: Campaign, chance: np.random.Generator) -> Campaign:
    """Read the packages of a campaign at new attitudes in which nothing is wrong: whether predictions and inferred
    angles keep their intervals. The sensors are as the campaign's truth has them, at 20 °C.
    """
    rows, noise = chance.spawn(2)
    return observe(use_world(campaign.setup, campaign.package, rows), noise)


@dataclass(frozen=True)
class UseReadings:
    """A good calibration, and the same package in use afterwards with something wrong."""

    calibration: Campaign
    use: Campaign


Build = Callable[[World, float, np.random.Generator], World]
"""A scene: from the clean world, a size and chance to the world in which it has happened."""


def draw_campaign(build: Build, size: float, setup: Setup, campaigns: int, chance: np.random.Generator) -> Campaign:
    """Draw n campaigns of a scene."""
    streams = streams_of(chance)
    return observe(build(clean_world(setup, campaigns, streams), size, streams.scene), streams.noise)


def draw_use(build: Build, size: float, setup: Setup, campaigns: int, chance: np.random.Generator) -> UseReadings:
    """Draw n clean calibrations, each followed by readings in use to which the scene happens."""
    streams = streams_of(chance)
    world = clean_world(setup, campaigns, streams)
    calibration = observe(world, streams.noise)
    used = build(use_world(setup, world.package, streams.order), size, streams.scene)
    return UseReadings(calibration, observe(used, streams.noise))


def chosen_event(world: World, chance: np.random.Generator, inner: float = 0.0) -> Event:
    """Draw a dwell among the points of every campaign, a sensor and an axis; `inner` spares that part at both ends."""
    rows, (campaigns, _, sensors, axes) = world.schedule.rows("point"), world.shape
    spared = int(inner * rows.size)
    dwell = rows[chance.integers(spared, rows.size - spared, campaigns)]
    return Event(dwell, chance.integers(0, sensors, campaigns), chance.integers(0, axes, campaigns))


def at_event(world: World, event: Event, each: bool = True) -> FloatArray:
    """Return one where the event is and zero elsewhere, (n, D, S, A); with `each` false, (n, D)."""
    where = (np.arange(world.schedule.dwells) == event.dwell[:, None]).astype(np.float64)
    if not each:
        return where
    return where[..., None, None] * of_sensor(world, event)[:, None, :, None] * of_axis(world, event)[:, None, None, :]


def since_event(world: World, event: Event) -> FloatArray:
    """Return zero before the event and one from it on, (n, D)."""
    return (np.arange(world.schedule.dwells) >= event.dwell[:, None]).astype(np.float64)


def of_sensor(world: World, event: Event) -> FloatArray:
    """Return one for the event's sensor, (n, S)."""
    return (np.arange(world.shape[2]) == event.sensor[:, None]).astype(np.float64)


def of_axis(world: World, event: Event) -> FloatArray:
    """Return one for the event's axis, (n, A)."""
    return (np.arange(world.shape[3]) == event.axis[:, None]).astype(np.float64)


def centred(world: World, column: FloatArray) -> FloatArray:
    """Take from a column (n, D) its mean over the points, so that the truth is the mean over the run."""
    return column - column[:, world.schedule.is_point].mean(axis=1, keepdims=True)


def _by_dwell(value: FloatArray | float) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    return array[..., None, None] if array.ndim else array
