"""Scenes of a change in mid-run: the table or its base, the meter, the supply, one sensor; and of a common fixture.

By default three sensors stand on one fixture (fewer have no majority, MATH 10), a check set frames the run, and two
reference attitudes are visited every 25 dwells. What changes does so at a dwell among the points and stays.
"""

from dataclasses import replace

import numpy as np

from physics_scenes.rotations import FloatArray, random_directions, specific_force, turn_matrix, turned
from physics_scenes.scene import Scene
from physics_scenes.table_scenes import level_directions
from physics_scenes.tables import Table, arcsec
from physics_scenes.world import Event, World, chosen_event, of_axis, of_sensor, since_event


def pitch_slip(world: World, size: float, chance: np.random.Generator) -> World:
    """The pitch axis slips on its shaft by the size, either way; the read-back does not tell."""
    known, since = _common(world, chance)
    return replace(known, table=world.table.moved(pitch_rad=arcsec(size) * _either(world, chance) * since))


def roll_slip(world: World, size: float, chance: np.random.Generator) -> World:
    """The roll axis slips by the size, either way. At one attitude a tilt of the base about x looks the same."""
    known, since = _common(world, chance)
    return replace(known, table=world.table.moved(roll_rad=arcsec(size) * _either(world, chance) * since))


def base_change(world: World, size: float, chance: np.random.Generator) -> World:
    """The base goes out of level by the size towards any side: a foot settles, someone leans on it."""
    known, since = _common(world, chance)
    return replace(known, table=_tilted(world, size, since, chance))


def base_change_sideways(world: World, size: float, chance: np.random.Generator) -> World:
    """The base tilts by the size about its forward axis: no slip of a table's axis looks like it at all attitudes."""
    known, since = _common(world, chance)
    turn = arcsec(size) * _either(world, chance) * since
    still = np.zeros_like(turn)
    return replace(known, table=world.table.moved(base_turn_rad=np.stack([turn, still, still], axis=-1)))


def meter_gain(world: World, size: float, chance: np.random.Generator) -> World:
    """The meter's gain changes by the size in ppm for all channels, either way."""
    known, since = _common(world, chance)
    return replace(known, meter_gain=world.meter_gain * (1.0 + size * 1e-6 * _either(world, chance) * since))


def meter_offset(world: World, size: float, chance: np.random.Generator) -> World:
    """The meter's zero changes by the size in µV for all channels, either way."""
    known, since = _common(world, chance)
    return replace(known, meter_offset_v=world.meter_offset_v + size * 1e-6 * _either(world, chance) * since)


def supply(world: World, size: float, chance: np.random.Generator) -> World:
    """The supply of all ratiometric sensors changes by the size in ppm: offsets and sensitivities scale together.

    The meter's gain does the same to every channel; only a reference channel tells meter and supply apart.
    """
    return meter_gain(world, size, chance)


def sensor_rotation(world: World, size: float, chance: np.random.Generator) -> World:
    """One sensor turns on its mount by the size about any direction; the others stay."""
    known, since, sensor = _single(world, chance)
    turn = arcsec(size) * random_directions(chance, world.campaigns)
    turns = since[..., None, None] * sensor[:, None, :, None] * turn[:, None, None, :]
    return replace(known, mount_turn_rad=world.mount_turn_rad + turns)


def sensor_gain(world: World, size: float, chance: np.random.Generator) -> World:
    """The sensitivity of one axis of one sensor changes by the size in ppm, either way."""
    known, where = _single_axis(world, chance)
    change = size * 1e-6 * _either(world, chance)[..., None, None] * where
    return replace(known, gain=world.gain * (1.0 + change))


def sensor_offset_change(world: World, size: float, chance: np.random.Generator) -> World:
    """The offset of one axis of one sensor changes by the size, either way."""
    known, where = _single_axis(world, chance)
    change = arcsec(size) * _either(world, chance)[..., None, None] * where
    return replace(known, added_g=world.added_g + change)


def remount(world: World, size: float, chance: np.random.Generator) -> World:
    """One sensor is taken off and put back between two replications: it stands turned by the size about any direction.

    The truth is the sensor before.
    """
    sensors = world.shape[2]
    later = chance.integers(1, world.setup.replications, world.campaigns)
    schedule = world.schedule
    first = np.array([np.flatnonzero(schedule.is_point & (schedule.replication == r))[0] for r in later])
    event = Event(first, chance.integers(0, sensors, world.campaigns), np.full(world.campaigns, -1))
    turn = arcsec(size) * random_directions(chance, world.campaigns)
    turns = since_event(world, event)[..., None, None] * of_sensor(world, event)[:, None, :, None]
    return replace(world, event=event, mount_turn_rad=world.mount_turn_rad + turns * turn[:, None, None, :])


def individual_mounts(world: World, size: float, chance: np.random.Generator) -> World:
    """Three sensors stand on the fixture in ways of their own, one reversed, one turned by a right angle.

    Each is turned by a further error of the size, which is part of its k: nothing is to be found.
    """
    turn = arcsec(size) * random_directions(chance, *world.shape[:1], world.shape[2], 1)
    vectors = turned(np.swapaxes(turn_matrix(turn), -1, -2), world.package.vector_v_per_g)
    return replace(world, package=replace(world.package, vector_v_per_g=vectors))


def loose(world: World, size: float, chance: np.random.Generator) -> World:
    """One sensor has play on the fixture: gravity lays it against one stop or the other, the size apart.

    It turns about a random direction by ±size/2, by the sign of the force across its play.
    """
    event = _nowhere(world, chance, keep_sensor=True)
    schedule = world.schedule
    force = specific_force(np.deg2rad(schedule.pitch_deg), np.deg2rad(schedule.roll_deg))
    side = np.sign(random_directions(chance, world.campaigns) @ force.T)
    turn = 0.5 * arcsec(size) * random_directions(chance, world.campaigns)
    turns = side[..., None, None] * of_sensor(world, event)[:, None, :, None] * turn[:, None, None, :]
    return replace(world, event=event, mount_turn_rad=world.mount_turn_rad + turns)


def rattling(world: World, size: float, chance: np.random.Generator) -> World:
    """One sensor is loose without stops: at every dwell it stands turned anew, normal with the size about each axis."""
    event = _nowhere(world, chance, keep_sensor=True)
    turn = arcsec(size) * chance.standard_normal((world.campaigns, world.schedule.dwells, 1, 3))
    return replace(
        world, event=event, mount_turn_rad=world.mount_turn_rad + turn * of_sensor(world, event)[:, None, :, None]
    )


def _common(world: World, chance: np.random.Generator) -> tuple[World, FloatArray]:
    """Draw the dwell of a change that all sensors see; return also zero before and one since, (n, D)."""
    event = _nowhere(world, chance)
    return replace(world, event=event), since_event(world, event)


def _nowhere(world: World, chance: np.random.Generator, keep_sensor: bool = False) -> Event:
    drawn = chosen_event(world, chance, inner=0.1)
    none = np.full(world.campaigns, -1)
    return Event(none, drawn.sensor, none) if keep_sensor else Event(drawn.dwell, none, none)


def _single(world: World, chance: np.random.Generator) -> tuple[World, FloatArray, FloatArray]:
    drawn = chosen_event(world, chance, inner=0.1)
    event = Event(drawn.dwell, drawn.sensor, np.full(world.campaigns, -1))
    return replace(world, event=event), since_event(world, event), of_sensor(world, event)


def _single_axis(world: World, chance: np.random.Generator) -> tuple[World, FloatArray]:
    event = chosen_event(world, chance, inner=0.1)
    where = of_sensor(world, event)[:, None, :, None] * of_axis(world, event)[:, None, None, :]
    return replace(world, event=event), since_event(world, event)[..., None, None] * where


def _either(world: World, chance: np.random.Generator) -> FloatArray:
    return chance.choice([-1.0, 1.0], (world.campaigns, 1))


def _tilted(world: World, size: float, since: FloatArray, chance: np.random.Generator) -> Table:
    return world.table.moved(base_turn_rad=arcsec(size) * since[..., None] * level_directions(world.campaigns, chance))


WATCHED = {"sensors": 3, "reference_every": 25, "check_set": True}
SLIPS_ARCSEC = (0.0, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 72.0, 720.0)
RATTLES_ARCSEC = (0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0, 72.0)
PPM = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 200.0, 2000.0)
SLIP_SCENES = (
    Scene("slip-pitch", pitch_slip, "arcsec", SLIPS_ARCSEC, "table-rotation", design=WATCHED),
    Scene("slip-roll", roll_slip, "arcsec", SLIPS_ARCSEC, "table-rotation", design=WATCHED),
    Scene("slip-base", base_change, "arcsec", SLIPS_ARCSEC, "table-rotation", design=WATCHED),
    Scene("slip-base-sideways", base_change_sideways, "arcsec", SLIPS_ARCSEC, "table-rotation", design=WATCHED),
    Scene("meter-gain", meter_gain, "ppm", PPM, "meter-gain", design=WATCHED),
    Scene("meter-offset", meter_offset, "µV", PPM, "meter-offset", design=WATCHED),
    Scene("supply", supply, "ppm", PPM, "meter-gain", design=WATCHED),
    Scene("sensor-rotation", sensor_rotation, "arcsec", SLIPS_ARCSEC, "sensor-change", design=WATCHED),
    Scene("sensor-gain", sensor_gain, "ppm", PPM, "sensor-change", also=("drift",), design=WATCHED),
    Scene(
        "sensor-offset", sensor_offset_change, "arcsec", SLIPS_ARCSEC, "sensor-change", also=("drift",), design=WATCHED
    ),
    Scene("remount", remount, "arcsec", SLIPS_ARCSEC, "sensor-change", also=("drift",), design=WATCHED),
    Scene(
        "fixture-mounts",
        individual_mounts,
        "arcsec",
        (0.0, 10.0, 100.0, 1000.0),
        declared_up_to=1000.0,
        design={**WATCHED, "mounts": ("+x+y+z", "-x-y+z", "+y-x+z")},
    ),
    Scene(
        "fixture-play",
        loose,
        "arcsec",
        SLIPS_ARCSEC,
        "asymmetry",
        also=("lack-of-fit", "quadratic", "cross-coupling", "cubic"),
        design=WATCHED,
    ),
    Scene(
        "fixture-rattle",
        rattling,
        "arcsec",
        RATTLES_ARCSEC,
        "sensor-change",
        also=("wrong-dwell",),
        design=WATCHED,
    ),
)
