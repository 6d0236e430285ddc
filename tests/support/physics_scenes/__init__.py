"""Simulated calibration campaigns whose truth is known, from physics and by numpy alone: nothing of calrig is used.

    >>> import numpy as np
    >>> from physics_scenes import SCENES, campaigns
    >>> drawn = campaigns("table-once", 1.0, np.random.default_rng(1), 400, pitch_limit_deg=30.0)
    >>> drawn.grid(drawn.output_v).shape  # campaigns, replications, points, sensors, axes
    (400, 6, 156, 1, 3)
    >>> drawn.package.vector_v_per_g.shape  # the truth: k = S·u of every axis
    (400, 1, 3, 3)

`used_later(drawn, chance)` reads the same packages at new attitudes, for predictions and inferred angles.
`mixed({"table-harmonics": 0.7, "drift-replications": 0.5}, chance, 400)` lets several happen at once.
Every scene has one size, from nothing through the threshold of detection to obvious: `SCENES[name].sizes`.
"""

from physics_scenes.designs import FINE, REPEATED_ROLL, WITHOUT_ROLL, Schedule, Setup
from physics_scenes.field_scenes import FieldReadings, FieldSetup
from physics_scenes.gimbal_scenes import GimbalReadings, GimbalSetup
from physics_scenes.gyro_scenes import GyroRates, GyroSetup, GyroStream
from physics_scenes.package import Package
from physics_scenes.registry import SCENES, campaigns, mixed, scene
from physics_scenes.scene import CAUSES, Scene
from physics_scenes.world import Campaign, Event, UseReadings, used_later

__all__ = [
    "CAUSES", "FINE", "REPEATED_ROLL", "SCENES", "WITHOUT_ROLL", "Campaign", "Event", "FieldReadings", "FieldSetup",
    "GimbalReadings", "GimbalSetup", "GyroRates", "GyroSetup", "GyroStream", "Package", "Scene", "Schedule", "Setup",
    "UseReadings", "campaigns", "mixed", "scene", "used_later",
]  # fmt: skip
