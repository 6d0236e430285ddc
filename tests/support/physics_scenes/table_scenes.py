"""Scenes of the table: what the certificate's limit stands for, and what it does not."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from physics_scenes.scene import Scene
from physics_scenes.tables import (
    Curve,
    arcsec,
    eight_harmonics,
    once_per_turn,
    sawtooth,
    white_teeth,
    zeroed,
)
from physics_scenes.world import Build, World

BACKLASH_ARCSEC = (0.0, 0.5, 1.0, 2.0, 4.0, 10.0, 20.0)
LIMITS_ARCSEC = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 2.0, 5.0)
CurveOf = Callable[[float, int, np.random.Generator], Curve]


def once(world: World, size: float, chance: np.random.Generator) -> World:
    """The axis of each scale turns off its centre: error·sin(a + φ), one phase for pitch and one for roll.

    All sensors, axes and replications see it. Source: MATH 10, "Index errors of a table".
    """
    return with_curves(world, size, chance, once_per_turn)


def twice(world: World, size: float, chance: np.random.Generator) -> World:
    """An elliptic scale or a bent shaft: error·sin(2a + φ). In pitch it looks like the sensor's own second order."""
    return with_curves(world, size, chance, partial(once_per_turn, times=2))


def harmonics(world: World, size: float, chance: np.random.Generator) -> World:
    """A calibrated table's usual curve: eight harmonics, nowhere more than the size."""
    return with_curves(world, size, chance, eight_harmonics)


def teeth(world: World, size: float, chance: np.random.Generator) -> World:
    """Each tooth has an error of its own, the same whenever it is engaged: rectangular within the size."""
    return with_curves(world, size, chance, white_teeth)


def worm(world: World, size: float, chance: np.random.Generator) -> World:
    """A worm drive's periodic error: a sawtooth within the size."""
    return with_curves(world, size, chance, sawtooth)


def both(world: World, size: float, chance: np.random.Generator) -> World:
    """A smooth curve that takes 0.7 of the size and teeth that take the rest: what certificates mostly find."""

    def mixed(limit: float, campaigns: int, chance: np.random.Generator) -> Curve:
        smooth = eight_harmonics(0.7 * limit, campaigns, chance)
        tooth = white_teeth(0.3 * limit, campaigns, chance)
        return lambda angle: smooth(angle) + tooth(angle)

    return with_curves(world, size, chance, mixed)


def set_to_zero(build: Build) -> Build:
    """Zero both axes at index 0 after the curves are drawn."""

    def built(world: World, size: float, chance: np.random.Generator) -> World:
        curved = build(world, size, chance)
        table = curved.table
        return replace(
            curved,
            table=replace(table, pitch_curve=zeroed(table.pitch_curve), roll_curve=zeroed(table.roll_curve)),
        )

    built.__doc__ = f"{build.__doc__}\n\n    Zeroed at index 0: E(a) − E(0), which may reach twice the size."
    return built


def wrong_zero(world: World, size: float, chance: np.random.Generator) -> World:
    """Both axes were set to zero with an error of the size, either way: a constant of the whole campaign.

    In the data it is a rotation of the package: no test of one mounting finds it, the level's reading has to.
    """
    signs = chance.choice([-1.0, 1.0], (2, world.campaigns, 1))
    return replace(world, table=world.table.moved(pitch_rad=arcsec(size) * signs[0], roll_rad=arcsec(size) * signs[1]))


def base_tilt(world: World, size: float, chance: np.random.Generator) -> World:
    """The base stands off level by the size in any direction, for the whole campaign.

    Fore and aft it is a wrong zero of pitch; to the side it turns with roll: (0, cosR, −sinR) times the tilt.
    """
    return replace(
        world, table=world.table.moved(base_turn_rad=arcsec(size) * level_directions(world.campaigns, chance))
    )


def orthogonality(world: World, size: float, chance: np.random.Generator) -> World:
    """The roll axis lies off the right angle to the pitch axis by the size, either way."""
    sign = chance.choice([-1.0, 1.0], (world.campaigns, 1))
    return replace(world, table=world.table.moved(orthogonality_rad=arcsec(size) * sign))


def pitch_backlash(world: World, size: float, chance: np.random.Generator) -> World:
    """The pitch axis comes to rest on either side of where it says, the size apart, by the way it came.

    A worm or a gear with play: half the size to the side that its last move came from or went to, one and the same in
    a campaign. An axis that did not move stays where it lay. Not gravity decides, as with a loose fixture.
    """
    schedule = world.schedule
    side = last_way(schedule.pitch_deg, schedule.previous_pitch_deg)
    return replace(world, table=world.table.moved(pitch_rad=0.5 * arcsec(size) * side * _leading(world, chance)))


def roll_backlash(world: World, size: float, chance: np.random.Generator) -> World:
    """The roll axis comes to rest on either side of where it says, the size apart, by the way it came."""
    schedule = world.schedule
    side = last_way(schedule.roll_deg, schedule.previous_roll_deg)
    return replace(world, table=world.table.moved(roll_rad=0.5 * arcsec(size) * side * _leading(world, chance)))


def last_way(angle_deg: np.ndarray, previous_deg: np.ndarray) -> np.ndarray:
    """Return +1 or −1 for every dwell, the sense of the last move; upwards before the first one."""
    ways, way = [], 1.0
    for here, before in zip(angle_deg.tolist(), previous_deg.tolist(), strict=True):
        way = way if here == before else (1.0 if here > before else -1.0)
        ways.append(way)
    return np.array(ways)


def _leading(world: World, chance: np.random.Generator) -> np.ndarray:
    return chance.choice([-1.0, 1.0], (world.campaigns, 1))


def with_curves(world: World, size: float, chance: np.random.Generator, curve_of: CurveOf) -> World:
    """Draw a curve for pitch and another for roll."""
    pitch = curve_of(arcsec(size), world.campaigns, chance)
    roll = curve_of(arcsec(size), world.campaigns, chance)
    return replace(world, table=replace(world.table, pitch_curve=pitch, roll_curve=roll))


def level_directions(campaigns: int, chance: np.random.Generator) -> np.ndarray:
    """Draw horizontal unit vectors (n, 1, 3)."""
    azimuth = chance.uniform(0.0, 2.0 * np.pi, (campaigns, 1))
    return np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=-1)


CURVES: dict[str, Build] = {
    "table-once": once,
    "table-twice": twice,
    "table-harmonics": harmonics,
    "table-teeth": teeth,
    "table-worm": worm,
    "table-smooth-and-teeth": both,
}
TABLE_SCENES = (
    *(Scene(name, build, "arcsec", LIMITS_ARCSEC, "lack-of-fit", declared_up_to=1.0) for name, build in CURVES.items()),
    *(
        Scene(f"{name}-zeroed", set_to_zero(build), "arcsec", LIMITS_ARCSEC, "lack-of-fit", declared_up_to=1.0)
        for name, build in CURVES.items()
    ),
    Scene("table-wrong-zero", wrong_zero, "arcsec", (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0), "level-undeclared"),
    Scene(
        "table-base-tilt",
        base_tilt,
        "arcsec",
        (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0),
        "level-undeclared",
        also=("lack-of-fit",),
    ),
    Scene(
        "table-orthogonality",
        orthogonality,
        "arcsec",
        (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0),
        "lack-of-fit",
        also=("level-undeclared",),
    ),
    Scene("table-backlash-pitch", pitch_backlash, "arcsec", BACKLASH_ARCSEC, "table-rotation"),
    Scene("table-backlash-roll", roll_backlash, "arcsec", BACKLASH_ARCSEC, "table-rotation"),
)
