"""The Earth turns under a gyro that is calibrated: its rate is taken off where the rig file says how the table stands.

A gyro senses the stage's rate and the Earth's together (15.04 °/h: MATH of the page on attitudes). Known latitude and
heading of the table tell what the Earth adds along every axis at every dwell; the rates of the rows are then those
against the stars. What is not declared is an error of unknown direction, of a run (:func:`earth_errors`) as of a file
whose rates are not stated to include it (:func:`earth_of_any_direction`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import cos, degrees, radians, sqrt
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.earth_rate import EARTH_RATE_RAD_S, EarthRate
from ams.frames import ANGLES, body_rates_rad_s, euler_rates_rad_s, from_level_axes
from ams.inputs.shared_errors import SharedError
from ams.observations import Observations
from procedures.plan.plan import Plan
from procedures.plan.steps import Turn
from procedures.records.dwells import DwellRecord
from rig.description.rig_file import RigDescription, Sensor

EARTH_DPS: Final = degrees(EARTH_RATE_RAD_S)
_NAME: Final = "Earth's rotation"
_HORIZONTAL, _VERTICAL = (0, 1), (2,)
_STEPS: Final = 180
"""Of an axis that turns while it is read; equally spaced, they are exact for whole turns."""


def with_turned_earth(
    rows: Observations, rig: RigDescription, sensor: Sensor, turned: FloatArray | None = None
) -> Observations:
    """Return the rows with what is known of the Earth's rate among their rates; sensors of rates only.

    ``turned``: (N, 3, 3) mean rotation from level axes into those of the stage; None: that of the rows' attitudes.
    """
    if sensor.measures != "rate" or rows.euler_rate_rad_s is None:
        return rows
    yaw = np.zeros(rows.rows) if rows.yaw_rad is None else rows.yaw_rad
    from_level = from_level_axes(rows.pitch_rad, yaw, rows.roll_rad) if turned is None else turned
    euler = np.stack([rows.pitch_rad, yaw, rows.roll_rad], axis=-1)
    of_stage = body_rates_rad_s(euler, rows.euler_rate_rad_s)
    rates = euler_rates_rad_s(euler, of_stage + from_level @ _known_rad_s(rig))
    return replace(rows, from_level=from_level, euler_rate_rad_s=rates)


def _known_rad_s(rig: RigDescription) -> FloatArray:
    """Return what is known of the Earth's rate in level axes: all of it, its vertical part, or nothing."""
    latitude, heading = rig.rig.latitude_deg, rig.rig.heading_deg
    if latitude is None:
        return np.zeros(3)
    rate = EarthRate(latitude, heading or 0.0).rate_rad_s
    return rate if heading is not None else rate * np.array([0.0, 0.0, 1.0])


def earth_errors(rig: RigDescription, sensor: Sensor) -> Iterator[SharedError]:
    """Yield what is not known of it, in °/s: a vector of known length that points anywhere has a third of its square
    along each axis, one that points anywhere on the horizon a half.
    """
    if sensor.measures != "rate":
        return
    latitude, heading = rig.rig.latitude_deg, rig.rig.heading_deg
    if latitude is None:
        yield earth_of_any_direction("rig.latitude_deg, rig.heading_deg")
    elif heading is None:
        level_dps = EARTH_DPS * cos(radians(latitude))
        stated = f"{level_dps:.4f} °/s along a horizon where north is not declared (rig.heading_deg)"
        yield SharedError(_NAME, "rotation", level_dps / sqrt(2.0), stated=stated, columns=_HORIZONTAL)


def earth_of_any_direction(declared_by: str) -> SharedError:
    """Return the Earth's rate where nothing of it is known but its length; ``declared_by``: what would tell it."""
    stated = f"{EARTH_DPS:.4f} °/s in a direction that is not declared ({declared_by})"
    return SharedError(_NAME, "rotation", EARTH_DPS / sqrt(3.0), stated=stated, columns=(*_HORIZONTAL, *_VERTICAL))


def earth_remarks(rig: RigDescription, sensor: Sensor) -> tuple[str, ...]:
    """Tell what was taken off."""
    latitude, heading = rig.rig.latitude_deg, rig.rig.heading_deg
    if sensor.measures != "rate" or latitude is None:
        return ()
    if heading is None:
        part = f"the vertical part of the Earth's rotation (latitude {latitude:g}°) is taken off; its horizontal part"
        return (f"{part} is in the uncertainty: rig.heading_deg would tell it",)
    return (f"the Earth's rotation is taken off: latitude {latitude:g}°, heading of the table {heading:g}°",)


def mean_rotations(rows: tuple[DwellRecord, ...], plan: Plan, at: Mapping[str, FloatArray]) -> FloatArray:
    """Return the (N, 3, 3) mean rotation from level axes into those of the stage while every dwell was read.

    ``at``: angles of the rows, where an axis that turned stood when it began.
    """
    motions = {step.step: step.motion for step in plan.dwells}
    found = []
    for index, row in enumerate(rows):
        angles = {name: np.full(_STEPS, at[name][index]) for name in ANGLES}
        motion = motions.get(row.step)
        if isinstance(motion, Turn):
            low, high = (0.0, 360.0) if motion.sweep_deg is None else sorted(motion.sweep_deg)
            angles[motion.turned_axis] = np.deg2rad(low + (high - low) * (np.arange(_STEPS) + 0.5) / _STEPS)
        found.append(from_level_axes(angles["pitch"], angles["yaw"], angles["roll"]).mean(axis=0))
    return np.stack(found)
