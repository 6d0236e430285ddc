"""All scenes by name, and the two calls that draw them."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from physics_scenes.designs import Setup
from physics_scenes.drift_scenes import DRIFT_SCENES
from physics_scenes.dwell_scenes import DWELL_SCENES
from physics_scenes.field_scenes import FIELD_SCENES
from physics_scenes.gimbal_scenes import GIMBAL_SCENES
from physics_scenes.gyro_scenes import GYRO_SCENES
from physics_scenes.index_scenes import INDEX_SCENES
from physics_scenes.scene import Scene
from physics_scenes.sensor_scenes import SENSOR_SCENES
from physics_scenes.slip_scenes import SLIP_SCENES
from physics_scenes.table_scenes import TABLE_SCENES
from physics_scenes.temperature_scenes import TEMPERATURE_SCENES
from physics_scenes.use_scenes import USE_SCENES
from physics_scenes.world import Campaign, World, draw_campaign


def clean(world: World, size: float, chance: np.random.Generator) -> World:
    """Nothing happens: white noise, an exact table, an exact model."""
    return world


_ALL = (
    Scene("clean", clean, "none", (0.0,), declared_up_to=0.0),
    *TABLE_SCENES,
    *SENSOR_SCENES,
    *INDEX_SCENES,
    *DWELL_SCENES,
    *TEMPERATURE_SCENES,
    *DRIFT_SCENES,
    *SLIP_SCENES,
    *USE_SCENES,
    *GIMBAL_SCENES,
    *FIELD_SCENES,
    *GYRO_SCENES,
)
SCENES = MappingProxyType({each.name: each for each in _ALL})
"""Name to scene, in the order of the files."""


def scene(name: str, size: float, chance: np.random.Generator, **design: Any) -> Any:
    """Draw one campaign of a scene; arrays keep their leading axis, of length one."""
    return campaigns(name, size, chance, 1, **design)


def mixed(sizes: Mapping[str, float], chance: np.random.Generator, count: int, **design: Any) -> Campaign:
    """Draw campaigns in which several scenes happen at once, each by name and size; the truth is of all together.

    Of scenes that tell an event the last one's is kept. Two scenes of temperature do not mix: a sensor has one.
    """
    entries = [SCENES[name] for name in sizes]
    if any(entry.draws is not draw_campaign for entry in entries):
        raise ValueError(f"scenes: {', '.join(sizes)}: only scenes of one calibration campaign mix")
    if sum(name.startswith("temperature") for name in sizes) > 1:
        raise ValueError(f"scenes: {', '.join(sizes)}: a sensor has one temperature, so only one of these")
    setup = Setup(**{key: value for entry in entries for key, value in entry.design.items()} | design)

    def build(world: World, size: float, chance: np.random.Generator) -> World:
        for entry, generator in zip(entries, chance.spawn(len(entries)), strict=True):
            world = entry.build(world, sizes[entry.name], generator)
        return world

    return draw_campaign(build, 1.0, setup, count, chance)


def campaigns(name: str, size: float, chance: np.random.Generator, count: int, **design: Any) -> Any:
    """Draw many campaigns of a scene at once: one schedule, and sensors, chance and noise of their own for each.

    A random order is one for all. A thousand campaigns of 13 × 12 × 6 dwells and three axes take about 0.25 GB and a
    second; draw some hundreds at a time.

    `design` are names of the scene's setup, `Setup` for all scenes of a table: ``pitch_limit_deg=30.0``.
    """
    if name not in SCENES:
        raise KeyError(f"scene: {name!r} is unknown; there are {', '.join(SCENES)}")
    return SCENES[name].draw(size, chance, count, **design)
