"""Coefficient sets of straight lines whose numbers and covariance are given, and what a user is told by them.

The sets go the way that every set goes: read from a document, loaded, asked for angles with and without intervals.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from solved_sets import package_set, tp_set

from ams.attitude.flag_codes import AnswerCodes
from ams.calibration_result import Calibration
from ams.inference.inference import Package, inference
from ams.inference.package.calibrated import CalibratedSensor
from ams.sets.canonical import with_checksum
from ams.sets.coefficients import CoefficientSet, from_document
from ams.sets.sensed_quantity import PER_G

NAMES = ("offset_v", *PER_G)
ALL_ROUND = {"pitch_deg": [-90.0, 90.0], "roll_deg": [-180.0, 180.0], "yaw_deg": [-180.0, 180.0]}


def line_sensor(
    offset_v: float,
    k_v_per_g: np.ndarray,
    covariance: np.ndarray,
    reading_sd_v: float,
    components: tuple[Any, ...] = (),
) -> CalibratedSensor:
    """Return an accelerometer that is a straight line in the specific force; the covariance is (4, 4) of (b, k)."""
    primary = np.array([offset_v, *k_v_per_g])
    return CalibratedSensor(NAMES, primary, covariance, reading_sd_v, np.zeros(1), components)


def sensors_as_solved(solved: Calibration, reading_sd_v: float) -> list[CalibratedSensor]:
    """Return the axes of a solution of TP's straight lines, which senses specific force, without a set between."""
    return [
        CalibratedSensor(
            axis.primary_names, axis.primary, axis.primary_covariance, reading_sd_v, np.zeros(1),
            axis.variance_components,
        )
        for axis in solved.axes.values()
    ]  # fmt: skip


def stated_set(kind: str, offset_v: np.ndarray, k_v_per_g: np.ndarray, parameter_sd_v: float) -> CoefficientSet:
    """Return a set of x, y and z of the ``kind`` "tp", "sting" or "model" with lines as given in the specific force.

    ``parameter_sd_v``: of offset and of each sensitivity, independent and known as it stands; the axes share nothing.
    """
    document = copy.deepcopy(dict(_solved(kind).document))
    del document["checksum"]
    sense, variance = 1.0 if kind == "tp" else -1.0, parameter_sd_v**2
    for axis, offset, k in zip("xyz", offset_v.tolist(), k_v_per_g, strict=True):
        primary = document["axes"][axis]["primary"]
        primary["values"] = dict(zip(primary["order"], [offset, *(sense * k).tolist()], strict=True))
        primary["covariance"] = (variance * np.eye(4)).tolist()
        primary["components"] = {"stated": _part(variance, 4)}
    document["package"]["components"] = {"stated": _part(variance, 12)}
    document["validity"] |= {name: bounds for name, bounds in ALL_ROUND.items() if name in document["validity"]}
    return from_document(with_checksum(document), kind)


@cache
def _solved(kind: str) -> CoefficientSet:
    return tp_set() if kind == "tp" else package_set(kind)


def _part(variance: float, size: int) -> dict[str, Any]:
    return {"covariance": (variance * np.eye(size)).tolist(), "degrees_of_freedom": None}


@dataclass(frozen=True)
class Answered:
    """What a user is told of (N,) rows: angles by name in radians, and the codes of the flags."""

    angle_rad: Mapping[str, np.ndarray]
    sd_rad: Mapping[str, np.ndarray]
    half_95_rad: Mapping[str, np.ndarray]
    codes: AnswerCodes


def answered_in_both_ways(
    coefficients: CoefficientSet,
    outputs_v: np.ndarray,
    reading_sd_v: float,
    axes: str = "xyz",
    *,
    roll_rad: np.ndarray | None = None,
    model_set: CoefficientSet | None = None,
    model_v: np.ndarray | None = None,
) -> Answered:
    """Return what is told of (N, A) outputs with intervals, having seen that the same is told without them.

    Without intervals a package goes through kernels of its own: what holds of these angles holds of those.
    """
    readings = {f"{axis}_v": column for axis, column in zip(axes, outputs_v.T, strict=True)}
    second = None
    if model_set is not None and model_v is not None:
        second = Package(model_set, {axis: f"model_{axis}_v" for axis in "xyz"})
        readings |= {f"model_{axis}_v": column for axis, column in zip("xyz", model_v.T, strict=True)}
    if roll_rad is not None:
        readings["roll_deg"] = np.rad2deg(roll_rad)
    package = Package(coefficients, {axis: f"{axis}_v" for axis in axes})
    plain, wide = (inference(package, second, reading_sd_v, intervals=wish).answer(readings) for wish in (False, True))
    np.testing.assert_array_equal(plain.codes, wide.codes)
    for name, values in plain.columns.items():
        np.testing.assert_allclose(values, wide.columns[name], rtol=1e-6, atol=1e-9, err_msg=name)
    angles = [name for name in ("pitch", "roll", "yaw") if f"{name}_deg" in wide.columns]
    angle, sd, half = (
        {name: np.deg2rad(wide.columns[f"{name}{ending}_deg"]) for name in angles} for ending in ("", "_sd", "_half_95")
    )
    return Answered(angle, sd, half, wide.codes)
