"""Which terms of low order a sensor is tested for, and what they are at the points of its calibration."""

from ams.analysis.diagnostics.beliefs import COLUMNS, COLUMNS_OF_GYROS, Column
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.low_order import rate_columns, term_columns, term_columns_at
from ams.arrays import FloatArray
from ams.frames import specific_force
from ams.models.accelerometer import PitchRoll
from ams.models.added_parameters import WithAddedParameters
from ams.models.extended import ExtendedPitchRoll
from ams.models.gyro import Gyro, GyroWithTerms, velocity_of_dps
from ams.models.model import Model
from ams.solve.extension import blocks_of_angles


def linear_base(model: Model) -> PitchRoll | ExtendedPitchRoll | None:
    """Return the accelerometer of pitch and roll that a model is built on; None where it is another."""
    base = tested_base(model)
    return base if isinstance(base, PitchRoll | ExtendedPitchRoll) else None


def tested_base(model: Model) -> PitchRoll | ExtendedPitchRoll | Gyro | GyroWithTerms | None:
    """Return the sensor that a model is built on, where terms of low order are tested; None where it is another."""
    while isinstance(model, WithAddedParameters):
        model = model.base
    return model if isinstance(model, PitchRoll | ExtendedPitchRoll | Gyro | GyroWithTerms) else None


def columns_of(model: Model) -> tuple[Column, ...]:
    """Return what the means of the points of a sensor are tested for."""
    return COLUMNS_OF_GYROS if isinstance(tested_base(model), Gyro | GyroWithTerms) else COLUMNS


def terms_of_accelerometer(evidence: Evidence, base: Model) -> FloatArray:
    """Return the (K, 8) terms at the points."""
    rows, layout = evidence.rows, evidence.layout
    alike = blocks_of_angles(rows, layout)
    if alike is not None:
        return term_columns_at(*alike, base.nominal_axis)
    force = layout.mean_by_point(specific_force(rows.pitch_rad, rows.roll_rad))
    return term_columns(force, base.nominal_axis)


def terms_of_gyro(evidence: Evidence, output: int, base: Model) -> FloatArray:
    """Return the (K, 8) terms at the points, volts a ppm of what the output is at the largest rate."""
    along = evidence.primary[output][1 + "xyz".index(base.nominal_axis)]
    velocity_dps = evidence.layout.mean_by_point(velocity_of_dps(evidence.rows))
    return rate_columns(velocity_dps, base.nominal_axis, float(along))
