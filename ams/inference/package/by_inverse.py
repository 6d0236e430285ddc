"""Pitch from one output by the inverse that a model brings, its standard deviation by the model's own slopes."""

import numpy as np

from ams.arrays import FloatArray
from ams.attitude import flag_codes
from ams.attitude.static import Angles
from ams.frames import Attitude
from ams.inference.package.calibrated import CalibratedSensor
from ams.models.registry import model_named
from ams.models.sensor_model import ModelOutput
from ams.statistics.intervals import reading_halfwidth

LARGEST_SD_RAD = np.deg2rad(10.0)


def pitch_by_inverse(
    model: str, nominal_axis: str, formula: ModelOutput, sensor: CalibratedSensor, output_v: FloatArray
) -> Angles:
    """Find pitch at no roll, NaN where there is none or where the output hardly depends on it."""
    assert formula.pitch_rad is not None, "models without an inverse were refused"
    values = dict(zip(sensor.names, sensor.primary.tolist(), strict=True))
    pitch = np.asarray(formula.pitch_rad(values, output_v))
    known, level = np.nan_to_num(pitch), np.zeros_like(pitch)
    solver = model_named(model, nominal_axis)
    rows = solver.jacobian(sensor.primary, Attitude(known, level))
    slope = np.abs(solver.angle_jacobian(sensor.primary, Attitude(known, level))["pitch"])
    reading_v2 = np.broadcast_to(np.square(sensor.reading_sd_v), pitch.shape)
    calibration_v2 = np.einsum("ni,ij,nj->n", rows, sensor.covariance, rows)
    parts = [(np.einsum("ni,ij,nj->n", rows, part.covariance, rows), part.dof) for part in sensor.components]
    variances, dofs = [v for v, _ in parts] or [calibration_v2], [dof for _, dof in parts] or [np.inf]
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt(calibration_v2 + reading_v2) / slope
        half_95 = reading_halfwidth(variances, dofs, reading_v2) / slope
    lost = np.isnan(pitch) | ~(sd <= LARGEST_SD_RAD)
    codes = np.where(lost, flag_codes.NO_PITCH, 0).astype(np.uint32)
    pitch, sd, half_95 = (np.where(lost, np.nan, values) for values in (pitch, sd, half_95))
    return Angles(pitch, sd, level, level, codes, half_95, level)
