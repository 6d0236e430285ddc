"""Scenes of use: the calibration is good, and afterwards a reading, the site or the tunnel is not.

Rows are drawn over the box of use, all roll angles; every row has noise of its own. A row that is grossly wrong ought
to be flagged; none of these is a finding of the calibration.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from physics_scenes.rotations import ARCSEC, FloatArray, random_directions
from physics_scenes.scene import Scene
from physics_scenes.world import Event, World, draw_use, of_axis, of_sensor

STANDARD_GRAVITY_MPS2 = 9.80665


def good(world: World, size: float, chance: np.random.Generator) -> World:
    """Nothing is wrong: flags here are false alarms, 0.05 to 0.2 % of the rows are asked for."""
    return world


def dead_axis(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis has lost the size of its signal; at 1 it is unplugged and reads its offset."""
    event, where = _one_axis(world, chance)
    return replace(world, event=event, gain=1.0 - size * where)


def clipped_z(world: World, size: float, chance: np.random.Generator) -> World:
    """The last axis is clipped by the size in percent below its full scale of 1 g, both ways."""
    if size == 0.0:
        return world
    axes = world.shape[3]
    offset = world.package.offset_v[:, None]
    span = (1.0 - size / 100.0) * world.package.sensitivity_v_per_g[:, None]
    span = np.where(np.arange(axes) == axes - 1, span, np.inf)
    return _before_noise(world, lambda output_v: np.clip(output_v, offset - span, offset + span))


def all_high(world: World, size: float, chance: np.random.Generator) -> World:
    """All outputs are high by the size in percent: a supply, a load resistor, a wrong range."""
    return replace(world, meter_gain=1.0 + size / 100.0)


def swapped(world: World, size: float, chance: np.random.Generator) -> World:
    """The wires of the last two axes are exchanged (size 1), as after a repair of the plug."""
    if size == 0.0:
        return world
    order = [*range(world.shape[3] - 2), world.shape[3] - 1, world.shape[3] - 2]
    return _before_noise(world, lambda output_v: output_v[..., order])


def reversed_axis(world: World, size: float, chance: np.random.Generator) -> World:
    """The two wires of one axis are exchanged (size 1): its output has the other sign, offset and all."""
    event, where = _one_axis(world, chance)
    return _before_noise(replace(world, event=event), lambda output_v: (1.0 - 2.0 * size * where) * output_v)


def noisy_axis(world: World, size: float, chance: np.random.Generator) -> World:
    """One axis has noise of one plus the size times the ordinary."""
    event, where = _one_axis(world, chance)
    return replace(world, event=event, noise_factor=1.0 + size * where)


def shifted_offset(world: World, size: float, chance: np.random.Generator) -> World:
    """A shock in transport has moved the offset of one axis by the size in arc seconds, either way."""
    event, where = _one_axis(world, chance)
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 1, 1, 1))
    return replace(world, event=event, added_g=size * ARCSEC * sign * where)


def stuck_axis(world: World, size: float, chance: np.random.Generator) -> World:
    """One channel hangs at its first reading for the size of the rows, from a share of 0 to all."""
    event, where = _one_axis(world, chance)
    hangs = np.arange(world.shape[1]) >= (1.0 - size) * world.shape[1]
    stuck = hangs[None, :, None, None] & (where > 0.0)

    def held(output_v: FloatArray) -> FloatArray:
        return np.where(stuck, output_v[:, :1], output_v)

    return replace(world, event=event, faults_after_noise=(held,))


def site_gravity(world: World, size: float, chance: np.random.Generator) -> World:
    """Gravity at the tunnel is higher by the size in m/s² than the set says; 1° of latitude is 0.0009 at 45°."""
    return replace(world, gravity_ratio=1.0 + size / STANDARD_GRAVITY_MPS2)


def tunnel_acceleration(world: World, size: float, chance: np.random.Generator) -> World:
    """The model is accelerated by the size in percent of g, in every row in another direction: a sting that swings."""
    direction = random_directions(chance, world.campaigns, world.schedule.dwells, 1)
    return replace(world, acceleration_g=size / 100.0 * direction)


def _one_axis(world: World, chance: np.random.Generator) -> tuple[Event, FloatArray]:
    sensors, axes = world.shape[2:]
    none = np.full(world.campaigns, -1)
    event = Event(none, chance.integers(0, sensors, world.campaigns), chance.integers(0, axes, world.campaigns))
    return event, of_sensor(world, event)[:, None, :, None] * of_axis(world, event)[:, None, None, :]


def _before_noise(world: World, fault: Callable[[FloatArray], FloatArray]) -> World:
    return replace(world, faults_before_noise=(*world.faults_before_noise, fault))


def _scene(name: str, build: Callable[..., World], unit: str, sizes: tuple[float, ...]) -> Scene:
    return Scene(name, build, unit, sizes, flags_rows=True, draws=draw_use)


USE_SCENES = (
    Scene("use-good", good, "none", (0.0,), declared_up_to=0.0, draws=draw_use),
    _scene("use-dead-axis", dead_axis, "share", (0.0, 1e-5, 3e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0)),
    _scene("use-clipped-z", clipped_z, "%", (0.0, 0.001, 0.003, 0.01, 0.1, 0.5, 1.5, 5.0)),
    _scene("use-all-high", all_high, "%", (0.0, 0.0005, 0.001, 0.002, 0.005, 0.02, 0.1, 2.0)),
    _scene("use-swapped", swapped, "none or one", (0.0, 1.0)),
    _scene("use-reversed", reversed_axis, "none or one", (0.0, 1.0)),
    _scene("use-noisy-axis", noisy_axis, "σ", (0.0, 1.0, 3.0, 10.0, 100.0)),
    _scene("use-shifted-offset", shifted_offset, "arcsec", (0.0, 1.0, 2.0, 5.0, 10.0, 30.0, 300.0)),
    _scene("use-stuck-axis", stuck_axis, "share", (0.0, 0.1, 0.5, 0.9)),
    _scene("use-site-gravity", site_gravity, "m/s²", (0.0, 0.0001, 0.0005, 0.0015, 0.003, 0.005, 0.03)),
    _scene("use-acceleration", tunnel_acceleration, "% g", (0.0, 0.0005, 0.001, 0.002, 0.005, 0.05, 0.5)),
)
