"""Scenes of one place: a sensor reads otherwise at one index of an axis, or at one attitude, every time it is there.

Sizes in µg; a dwell's noise of 1.65″ is 8 µg. The truth is the sensor elsewhere.
"""

from dataclasses import replace

import numpy as np

from physics_scenes.rotations import FloatArray
from physics_scenes.scene import Scene
from physics_scenes.world import World

MICRO = 1e-6
SIZES = (0.0, 0.5, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


def vibration_at_pitch(world: World, size: float, chance: np.random.Generator) -> World:
    """The arm resonates at one pitch index: vibration rectification adds K₂ times the mean square of it along the axis.

    The arm swings across its own length, in the vertical plane of the plate when it is level: the roll plate turns the
    sensors in it, so that y and z see it by cos² and sin² of roll and x by what is left, of either sign for each axis.
    """
    pitch = _drawn_from(world.setup.pitches_deg(), world, chance)
    there = world.schedule.pitch_deg[None] == pitch[:, None]
    roll = np.deg2rad(world.schedule.roll_deg)
    share = {"x": np.full_like(roll, 0.5), "y": np.sin(roll) ** 2, "z": np.cos(roll) ** 2}
    seen = np.stack([share[axis] for axis in world.setup.axes], axis=-1)
    each = size * MICRO * _signs(world, chance)
    return _added(world, there[:, :, None, None] * seen[None, :, None, :] * each[:, None])


def output_at_pitch(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis reads off by the size at one pitch index: a magnet in the base, a cable that touches there."""
    pitch = _drawn_from(world.setup.pitches_deg(), world, chance)
    there = world.schedule.pitch_deg[None] == pitch[:, None]
    return _added(world, there[:, :, None, None] * _of_an_axis(world, size, chance))


def output_at_roll(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis reads off by the size at one roll index."""
    roll = _drawn_from(world.setup.rolls_deg(), world, chance)
    there = world.schedule.roll_deg[None] == roll[:, None]
    return _added(world, there[:, :, None, None] * _of_an_axis(world, size, chance))


def output_at_attitude(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis reads off by the size at one attitude."""
    points = world.setup.points_deg()
    point = chance.integers(0, len(points), world.campaigns)
    there = (world.schedule.point[None] == point[:, None]) & world.schedule.is_point
    return _added(world, there[:, :, None, None] * _of_an_axis(world, size, chance))


def output_at_attitudes(world: World, size: float, chance: np.random.Generator) -> World:
    """Every axis reads off at every attitude, each by another amount, normal with the size: errors that differ."""
    each = size * MICRO * chance.standard_normal((world.campaigns, len(world.setup.points_deg()), *_shape(world)[1:]))
    return _added(world, np.where(world.schedule.is_point[None, :, None, None], each[:, world.schedule.point], 0.0))


def wave_along_pitch(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis is off by a wave of seven periods in a turn of pitch, its amplitude the size: smooth, and of no term."""
    phase = chance.uniform(-np.pi, np.pi, world.campaigns)
    wave = np.sin(7.0 * np.deg2rad(world.schedule.pitch_deg)[None] + phase[:, None])
    return _added(world, wave[:, :, None, None] * _of_an_axis(world, size, chance))


def wave_of_a_row(world: World, size: float, chance: np.random.Generator) -> World:
    """Each axis is off by a wave with the order of the dwells in their row, the size its amplitude: a chamber that
    cycles once a row, or whatever begins anew with every pitch."""
    order = _order_in_row(world)
    length = order.max() + 1.0
    phase = chance.uniform(-np.pi, np.pi, (world.campaigns, *_shape(world)[1:]))
    wave = np.sin(2.0 * np.pi * (order / length)[None, :, None, None] + phase[:, None])
    return _added(world, size * MICRO * wave)


def windup_of_a_row(world: World, size: float, chance: np.random.Generator) -> World:
    """Each axis is off by an even course from −½ to ½ of the size over each row: a cable winds up and is let go."""
    order = _order_in_row(world)
    course = order / order.max() - 0.5
    return _added(world, size * MICRO * course[None, :, None, None] * _signs(world, chance)[:, None])


def _order_in_row(world: World) -> FloatArray:
    """(D,) place of each dwell since the last move of pitch."""
    moved = np.append(True, np.diff(world.schedule.pitch_deg) != 0.0)
    dwells = np.arange(moved.size)
    return np.asarray(dwells - np.maximum.accumulate(np.where(moved, dwells, 0)), dtype=np.float64)


def _drawn_from(indices_deg: FloatArray, world: World, chance: np.random.Generator) -> FloatArray:
    return np.asarray(indices_deg[chance.integers(0, indices_deg.size, world.campaigns)])


def _of_an_axis(world: World, size: float, chance: np.random.Generator) -> FloatArray:
    """(n, 1, S, A) the size, either way, of one axis of every sensor."""
    axes = world.shape[3]
    is_it = np.arange(axes) == chance.integers(0, axes, (world.campaigns, 1))
    return np.asarray((size * MICRO * _signs(world, chance) * is_it[:, None])[:, None])


def _added(world: World, change_g: FloatArray) -> World:
    return replace(world, added_g=world.added_g + change_g)


def _shape(world: World) -> tuple[int, int, int]:
    campaigns, _, sensors, axes = world.shape
    return campaigns, sensors, axes


def _signs(world: World, chance: np.random.Generator) -> FloatArray:
    return chance.choice([-1.0, 1.0], _shape(world))


INDEX_SCENES = (
    Scene("vibration-at-pitch", vibration_at_pitch, "µg", SIZES, "lack-of-fit"),
    Scene("output-at-pitch", output_at_pitch, "µg", SIZES, "lack-of-fit"),
    Scene("output-at-roll", output_at_roll, "µg", SIZES, "lack-of-fit"),
    Scene("output-at-attitude", output_at_attitude, "µg", SIZES, "lack-of-fit"),
    Scene("output-at-attitudes", output_at_attitudes, "µg", SIZES, "lack-of-fit"),
    Scene("wave-along-pitch", wave_along_pitch, "µg", SIZES, "lack-of-fit"),
    Scene("wave-of-a-row", wave_of_a_row, "µg", SIZES, "lack-of-fit"),
    Scene("windup-of-a-row", windup_of_a_row, "µg", SIZES, "lack-of-fit"),
)
