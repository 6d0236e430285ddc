"""What the solution of a planned run will say of its uncertainties, sensor by sensor: the one forecaster of solutions.

The rows are those of the plan, at outputs that a sensor without errors would give; request, model, weights and
covariance are those of :mod:`procedures.solution.by_model`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np

from ams.analysis.angle_uncertainty import KnownAxis, UsageBox, angle_uncertainties
from ams.arrays import FloatArray
from ams.calibration.solving.expectation import Expectation, expect_each
from ams.models.registry import MODELS
from ams.observations import Observations
from ams.units import RAD_PER_ARCSEC
from procedures.description.procedure_file import Solve
from procedures.plan.channels import temperature_source
from procedures.plan.designs import DesignPoint
from procedures.plan.specific_force import attitude_of, package_specific_force
from procedures.solution.beliefs import AxisBelief
from procedures.solution.crosstalk import with_scanned_volts
from procedures.solution.request import request_of
from rig.description.rig_file import RigDescription, Sensor

PARTS: Mapping[str, str] = {
    "replications": "noise and drift",
    "whole plots": "visits of plateaus",
    "residuals": "noise",
    "lack-of-fit": "lack of fit",
}
"""Part of the covariance to words; every other part is told by its own name."""


@dataclass(frozen=True)
class PlannedRows:
    """The rows that a run will have."""

    points: Sequence[DesignPoint]
    replications: int
    temperature_degc: Sequence[float] | None = None
    """Of every replication."""
    replication_s: float = 3600.0
    """How long one replication takes."""
    visited: Sequence[Sequence[int]] | None = None
    """Of every replication, the places of ``points`` in the order of their visits; None: as they stand."""

    def time_s(self) -> FloatArray:
        """Return (n × K) when each row is measured, replication by replication."""
        count = len(self.points)
        indices = np.tile(np.arange(count), (self.replications, 1))
        if self.visited is not None:
            np.put_along_axis(indices, np.array(self.visited), np.arange(count)[None, :], axis=1)
        start = np.arange(self.replications)[:, None] * count
        return np.asarray((start + indices).ravel() * self.replication_s / count)


@dataclass(frozen=True)
class ExpectedAngle:
    """U95 of one angle, degrees."""

    u95_deg: float
    calibration_deg: float
    """The same at use with readings that do not scatter."""
    shares_deg: Mapping[str, float]
    """Source to what it takes of U95; squares add up, and what is below zero takes off."""
    counted: float
    """Share of the usage range where the angle is told well enough to be counted."""


@dataclass(frozen=True)
class ExpectedSensor:
    """One sensor as it will be solved."""

    solution: Expectation
    angles: Mapping[str, ExpectedAngle]
    """``pitch`` and ``roll``, where its outputs tell them."""


@dataclass(frozen=True)
class Usage:
    """Where and how a sensor will be used."""

    pitch_deg: tuple[float, float]
    noise_arcsec: float | None = None
    """Standard deviation of one reading at use; None: that of one dwell of the calibration."""


@dataclass(frozen=True)
class Believed:
    """What is believed of the axes of one sensor, and how many readings a dwell takes of them."""

    axes: Mapping[str, AxisBelief]
    samples: int

    def noise_v(self, axis: str) -> float:
        """Return the standard deviation of the mean of one dwell."""
        return self.axes[axis].noise_v(self.samples)


def expected_sensor(
    rig: RigDescription,
    solve: Solve,
    serial: str,
    sensor: Sensor,
    rows: PlannedRows,
    believed: Believed,
    usage: Usage,
) -> ExpectedSensor:
    """Return what is to be expected of one sensor. Raises: ams.errors.AmsError where the rows cannot be solved."""
    (only,) = expected_each(rig, solve, serial, sensor, rows, [believed], usage)
    return only


def expected_each(
    rig: RigDescription,
    solve: Solve,
    serial: str,
    sensor: Sensor,
    rows: PlannedRows,
    beliefs: Sequence[Believed],
    usage: Usage,
) -> list[ExpectedSensor]:
    """Return the same for several beliefs that differ in noise, lack of fit and drift only. Raises: as one does."""
    axes = beliefs[0].axes
    tempered = at_use(rig, solve, sensor, rows)
    planned = planned_observations(solve.model_of(serial, rolls=sensor.rolls), tempered, axes, rolls=sensor.rolls)
    observations = with_scanned_volts(planned, rig, sensor)
    request = request_of(serial, rig, sensor, solve, observations)
    found = expect_each(
        observations,
        request,
        [
            {
                axis: axis_belief.belief(sensor_beliefs.samples, len(rows.points))
                for axis, axis_belief in sensor_beliefs.axes.items()
            }
            for sensor_beliefs in beliefs
        ],
    )
    temperature = observations.temperature_degc
    low, high = usage.pitch_deg
    box = UsageBox((radians(low), radians(high)), None if temperature is None else float(temperature.mean()))
    return [
        ExpectedSensor(expectation, _angles(expectation, sensor_beliefs, usage, box))
        for expectation, sensor_beliefs in zip(found, beliefs, strict=True)
    ]


def _angles(found: Expectation, believed: Believed, usage: Usage, box: UsageBox) -> dict[str, ExpectedAngle]:
    known = [
        KnownAxis(expected_axis.model, expected_axis.primary, _reading_v(axis, believed, usage), expected_axis.added)
        for axis, expected_axis in found.axes.items()
    ]
    return {
        name: ExpectedAngle(
            degrees(angle.u95_rad),
            degrees(angle.calibration_rad),
            {PARTS.get(source, source): degrees(share) for source, share in angle.shares_rad.items()},
            angle.counted,
        )
        for name, angle in angle_uncertainties(known, found.package.components, box).items()
    }


def _reading_v(axis: str, believed: Believed, usage: Usage) -> float:
    if usage.noise_arcsec is None:
        return believed.noise_v(axis)
    return usage.noise_arcsec * RAD_PER_ARCSEC * float(np.linalg.norm(believed.axes[axis].k_v_per_g))


def at_use(rig: RigDescription, solve: Solve, sensor: Sensor, rows: PlannedRows) -> PlannedRows:
    """Return the rows at the temperature that the sensor is taken to be calibrated at, where the plan sets none."""
    degc = assumed_degc(rig, solve, sensor)
    if degc is None or rows.temperature_degc is not None:
        return rows
    return replace(rows, temperature_degc=[degc] * rows.replications)


def assumed_degc(rig: RigDescription, solve: Solve, sensor: Sensor) -> float | None:
    """Return the middle of the range of use, from which its ends are nearest: the least that use can do.

    None where the solution will not count use, for it has a model of temperature or nothing that measures it.
    """
    used = sensor.use_temperature_degc
    if used is None or solve.temperature != "none" or temperature_source(rig, sensor) is None:
        return None
    return 0.5 * (used[0] + used[1])


def planned_observations(
    model: str, rows: PlannedRows, believed: Mapping[str, AxisBelief], *, rolls: bool
) -> Observations:
    """Return the rows, replication by replication, at the outputs of a sensor without errors."""
    count, n = len(rows.points), rows.replications
    attitude, columns = attitude_of(rows.points), MODELS[model].columns
    is_on_sting = not rolls or ("yaw" in columns and "roll" not in columns)
    force = package_specific_force(rows.points, "sting" if is_on_sting else "model")
    yaw = attitude.yaw_rad
    assert yaw is not None
    has_yaw = bool(yaw.any()) or "yaw" in columns
    return Observations(
        replication=np.repeat(np.arange(1, n + 1), count),
        point=np.tile(np.arange(1, count + 1), n),
        pitch_rad=np.tile(attitude.pitch_rad, n),
        roll_rad=np.tile(attitude.roll_rad, n) if rolls else np.zeros(n * count),
        yaw_rad=np.tile(yaw, n) if has_yaw else None,
        outputs={axis: np.tile(belief.offset_v + force @ belief.k_v_per_g, n) for axis, belief in believed.items()},
        temperature_degc=None if rows.temperature_degc is None else np.repeat(rows.temperature_degc, count),
        time_s=rows.time_s(),
        source="plan",
    )
