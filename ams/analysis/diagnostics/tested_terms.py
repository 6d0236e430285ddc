"""Which terms of low order a sensor is tested for, and what they are at the points of its calibration."""

from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import COLUMNS, COLUMNS_OF_GYROS, Column
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.low_order import TERMS, rate_columns, term_columns, term_columns_at
from ams.analysis.diagnostics.sensed_force import Accelerometer, sensed_force
from ams.arrays import FloatArray
from ams.models.added_parameters import WithAddedParameters
from ams.models.gyro import Gyro, GyroWithTerms, velocity_of_dps
from ams.models.model import Model
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.solve.extension import blocks_of_angles

AnyGyro = Gyro | GyroWithTerms
TestedSensor = Accelerometer | AnyGyro
"""A sensor whose terms of low order are tested."""
ASYMMETRY_OF_OFFSET: Final = [name for name, *_ in TERMS].index("K0'")
"""Column of K₀′ among the terms."""
_LEVEL: Final = 1e-5
"""Of the largest force along the axis: the sign of less is not known."""


def accelerometer_base(model: Model) -> Accelerometer | None:
    """Return the accelerometer that a model is built on, whatever axes carry it; None where it is another sensor."""
    base = tested_base(model)
    return base if isinstance(base, Accelerometer) else None


def tested_base(model: Model) -> TestedSensor | None:
    """Return the sensor that a model is built on, where terms of low order are tested; None where it is another."""
    if isinstance(model, TestedSensor):  # first: what the class of a base is costs least, and most models are one
        return model
    return tested_base(model.base) if isinstance(model, WithAddedParameters) else None


def columns_of(model: Model) -> tuple[Column, ...]:
    """Return what the means of the points of a sensor are tested for."""
    return COLUMNS_OF_GYROS if isinstance(tested_base(model), AnyGyro) else COLUMNS


def terms_at_points(evidence: Evidence, output: int, base: TestedSensor) -> FloatArray:
    """Return the (K, 8) terms of an output at the points."""
    if isinstance(base, AnyGyro):
        return terms_of_gyro(evidence, output, base)
    return terms_of_accelerometer(evidence, base)


def with_sign_of_axis(terms: FloatArray, evidence: Evidence, output: int, base: TestedSensor) -> FloatArray:
    """Return the (K, 8) terms, K₀′ by the sign of what the sensor senses along its axis as it is estimated.

    Where the nominal axis is level it senses nothing, and a coned one a positive force at some rolls and a negative one
    at others: K₀′ is whole there, and by the sign along the nominal axis it would look like a force across.
    """
    if isinstance(base, AnyGyro | PitchYawRoll):
        return terms
    along = evidence.layout.mean_by_point(sensed_force(base, evidence.rows) @ evidence.primary[output][1:4])
    found = terms.copy()
    found[:, ASYMMETRY_OF_OFFSET] = 0.5 * np.sign(np.where(np.abs(along) > _LEVEL * np.abs(along).max(), along, 0.0))
    return found


def terms_of_accelerometer(evidence: Evidence, base: Accelerometer) -> FloatArray:
    """Return the (K, 8) terms at the points."""
    rows, layout = evidence.rows, evidence.layout
    alike = None if isinstance(base, PitchYawRoll) else blocks_of_angles(rows, layout)
    if alike is not None:
        return term_columns_at(*alike, base.nominal_axis)
    return term_columns(layout.mean_by_point(sensed_force(base, rows)), base.nominal_axis)


def terms_of_gyro(evidence: Evidence, output: int, base: Model) -> FloatArray:
    """Return the (K, 8) terms at the points, volts a ppm of what the output is at the largest rate."""
    along = evidence.primary[output][1 + "xyz".index(base.nominal_axis)]
    velocity_dps = evidence.layout.mean_by_point(velocity_of_dps(evidence.rows))
    return rate_columns(velocity_dps, base.nominal_axis, float(along))
