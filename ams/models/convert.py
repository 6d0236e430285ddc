"""Between the conventions of TP and CR for the same physical sensor.

TP's specific force and CR's gravity in model axes are the same vector with opposite sign, and TP counts the azimuth
from the next axis where CR counts it from minus the one after: at Ψ = 0, Θ = α, Φ = R both models give the same outputs
at every attitude when

    B = b,   C = Ω,   A_CR = A_TP + 90°,   S_CR·G = −S_TP.

CR's S·G is the sensitivity per local g used throughout this package, so no value of g enters. A sensitivity per
standard g, as some sets state it, is another matter: see :func:`sensitivity_per_local_g`.

For users of the library who have numbers in the other convention: calrig itself solves each model in its own.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.frames import wrap_rad
from ams.models.cr import CrSensor

STANDARD_GRAVITY_MPS2: Final = 9.80665


@dataclass(frozen=True)
class TpSensor:
    """One accelerometer in TP's convention."""

    axis: str
    offset_v: float
    sensitivity_v_per_g: float
    """Signed, per local g of specific force."""
    coning_rad: float
    azimuth_rad: float


def cr_from_tp(sensor: TpSensor) -> CrSensor:
    """Return the same sensor in CR's convention, sensitivity per local g of gravity."""
    azimuth = float(wrap_rad(np.asarray(sensor.azimuth_rad + np.pi / 2)))
    return CrSensor(sensor.axis, sensor.offset_v, -sensor.sensitivity_v_per_g, azimuth, sensor.coning_rad)


def tp_from_cr(sensor: CrSensor) -> TpSensor:
    """Return the same sensor in TP's convention, sensitivity per local g of specific force."""
    azimuth = float(wrap_rad(np.asarray(sensor.azimuth_rad - np.pi / 2)))
    return TpSensor(sensor.axis, sensor.bias_v, -sensor.sensitivity, sensor.coning_rad, azimuth)


def sensitivity_per_local_g(sensitivity_v_per_standard_g: float, gravity_mps2: float) -> float:
    """Return the sensitivity per local g where the sensor is used, from one per 9.80665 m/s²."""
    return sensitivity_v_per_standard_g * gravity_mps2 / STANDARD_GRAVITY_MPS2
