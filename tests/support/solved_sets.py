"""Coefficient sets solved from outputs of explicit rotations: TP's package, CR's two packages, gyros."""

from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, TABLE_4, accelerometer_v, gyro_v
from package_outputs import TRUTH as TP_TRUTH
from package_outputs import output_v

from ams.calibration.calibrate import calibrate
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance

EULER_DEG = [(p, y, r) for p in (-40.0, 5.0, 30.0) for y in (-20.0, 0.0, 25.0) for r in (-60.0, 0.0, 45.0)]
TRUTH = {"sting": TABLE_3_STING, "model": TABLE_3_MODEL}
SITE = {"gravity_mps2": 9.79826, "gravity_source": "survey", "simulated": False, "rig": "", "procedure": "fit",
         "created_utc": datetime(2026, 3, 1, tzinfo=UTC), "software_version": "0.1.0"}  # fmt: skip


def observations(outputs: dict[str, list[float]], rates_dps: np.ndarray | None = None) -> Observations:
    pitch, yaw, roll = np.deg2rad(np.array(EULER_DEG)).T
    count = len(EULER_DEG)
    return Observations(
        np.ones(count, dtype=int), np.arange(count), pitch, roll, {a: np.array(v) for a, v in outputs.items()},
        yaw_rad=yaw, euler_rate_rad_s=None if rates_dps is None else np.deg2rad(rates_dps),
    )  # fmt: skip


def package_set(package: str) -> CoefficientSet:
    outputs = {a: [accelerometer_v(a, t, e, package) for e in EULER_DEG] for a, t in TRUTH[package].items()}
    solved = calibrate(observations(outputs), CalibrationRequest(model=f"pitch-yaw-roll-{package}", extended="no"))
    ranges = {"pitch_range_deg": (-40.0, 30.0), "roll_range_deg": (-60.0, 45.0), "yaw_range_deg": (-20.0, 25.0)}
    return build_set(solved, Provenance(sensor="CR1", **SITE, **ranges))


def gyro_set(noise_v: float = 0.0, chance: np.random.Generator | None = None) -> CoefficientSet:
    """CR's assumed gyros of table 4, one replication."""
    rates = np.random.default_rng(1).uniform(-60, 60, (len(EULER_DEG), 3))
    outputs = {
        a: [gyro_v(a, t, e, r) for e, r in zip(EULER_DEG, rates, strict=True)] for a, t in TABLE_4.items()
    }  # fmt: skip
    if chance is not None:
        outputs = {a: list(np.array(v) + noise_v * chance.normal(size=len(v))) for a, v in outputs.items()}
    solved = calibrate(observations(outputs, rates), CalibrationRequest(model="gyro"))
    ranges = {"pitch_range_deg": (0.0, 0.0), "roll_range_deg": (-60.0, 45.0), "yaw_range_deg": (-20.0, 25.0)}
    return build_set(solved, Provenance(sensor="G1", **SITE, **ranges, rate_range_dps=(-80.0, 80.0)))


GRID_DEG = [(p, r) for p in range(-90, 91, 30) for r in range(-180, 180, 60)]
_CLEAN = {axis: np.array([output_v(axis, TP_TRUTH[axis], p, r) for p, r in GRID_DEG]) for axis in TP_TRUTH}


def tp_set(
    axes: Sequence[str] = "xyz",
    noise_v: float = 0.0,
    chance: np.random.Generator | None = None,
    gravity_uncertainty_mps2: float = 0.0,
) -> CoefficientSet:
    """TP's package of ``package_outputs.TRUTH``, one replication of 42 points."""
    pitch, roll = np.deg2rad(np.array(GRID_DEG, dtype=float)).T
    spread = {axis: noise_v * chance.normal(size=pitch.size) if chance else 0.0 for axis in axes}
    rows = Observations(
        np.ones(pitch.size, dtype=int), np.arange(pitch.size), pitch, roll, {a: _CLEAN[a] + spread[a] for a in axes}
    )
    ranges = {"pitch_range_deg": (-90.0, 90.0), "roll_range_deg": (-180.0, 180.0)}
    origin = Provenance(sensor="TP1", **SITE, **ranges, gravity_uncertainty_mps2=gravity_uncertainty_mps2)
    return build_set(calibrate(rows, CalibrationRequest(extended="no")), origin)


def bent_set(bend_v: float = 5e-4) -> CoefficientSet:
    """Return TP's package with a soft mount and a saturation of ``bend_v`` in every axis, its terms in the set."""
    pitch, roll = np.deg2rad(np.array(GRID_DEG, dtype=float)).T
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    bend = {a: bend_v * (f[i] * f[(i + 1) % 3] - 0.5 * f[i] ** 2 + 0.3 * f[i] ** 3) for i, a in enumerate(TP_TRUTH)}
    rows = Observations(
        np.ones(pitch.size, dtype=int), np.arange(pitch.size), pitch, roll, {a: _CLEAN[a] + bend[a] for a in TP_TRUTH}
    )
    ranges = {"pitch_range_deg": (-90.0, 90.0), "roll_range_deg": (-180.0, 180.0)}
    return build_set(calibrate(rows, CalibrationRequest(extended="yes")), Provenance(sensor="SN1047", **SITE, **ranges))
