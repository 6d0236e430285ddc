"""Confidence and prediction intervals of a solved sensor axis at any attitude, TP (72) to (74).

The confidence interval holds the calibrated output, the prediction interval one new reading. The new reading's own
standard deviation is that of the place where the sensor is used (the tunnel's), not of the calibration.
"""

from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration
from ams.errors import DesignError
from ams.frames import Attitude
from ams.models.drifting import DRIFT_NAME, REFERENCE_NAME, WithTime
from ams.models.extended import ExtendedPitchRoll
from ams.models.gyro import Gyro, GyroWithTerms
from ams.models.model import Model
from ams.models.registry import MODELS, model_named
from ams.models.thermal import SECOND_ORDER_NAMES, TEMPERATURE_NAMES, Order, WithTemperature
from ams.statistics.intervals import confidence_halfwidth, prediction_halfwidth


def model_of_solution(axis: AxisCalibration) -> Model:
    """Return the model that a solution belongs to, temperature and time terms included.

    Raises:
        DesignError: the solution is of a model of the caller's own; its object is needed to predict.
    """
    if axis.model not in MODELS:
        raise DesignError(
            f"axis {axis.axis}: no model is known by the name {axis.model!r}; allowed {', '.join(MODELS)}"
        )
    model = _timeless(axis)
    references = {item.name: item.value for item in axis.parameters}
    if TEMPERATURE_NAMES[0] in axis.primary_names:
        reference_degc = references["reference_temperature_degc"]
        assert reference_degc is not None
        order: Order = 2 if SECOND_ORDER_NAMES[0] in axis.primary_names else 1
        model = WithTemperature(model, reference_degc, estimated_order=order)
    if DRIFT_NAME in axis.primary_names:
        reference_s = references[REFERENCE_NAME]
        assert reference_s is not None
        model = WithTime(model, reference_s)
    return model


def _timeless(axis: AxisCalibration) -> Model:
    if axis.model == ExtendedPitchRoll.name and axis.centring:
        return ExtendedPitchRoll(axis.nominal_axis, axis.centring)
    if axis.model == Gyro.name and axis.centring:
        return GyroWithTerms(axis.nominal_axis, axis.centring)
    return model_named(axis.model, axis.nominal_axis)


def confidence_halfwidth_v(axis: AxisCalibration, attitude: Attitude, level: float = 0.95) -> FloatArray:
    """Return the (N,) half-width of the interval for the calibrated output, volts. Source: TP (72)."""
    directions = model_of_solution(axis).jacobian(axis.primary, attitude)
    return confidence_halfwidth(directions, axis.variance_components, level)


def prediction_halfwidth_v(
    axis: AxisCalibration,
    attitude: Attitude,
    reading_standard_deviation_v: float,
    reading_dof: float = float("inf"),
    level: float = 0.95,
    roll_standard_uncertainty_rad: float = 0.0,
) -> FloatArray:
    """Return the (N,) half-width for one new reading, volts.

    With a roll angle measured independently, its uncertainty counts too.

    Source: TP (73), (74) with the divisor σ_E² and (75) with the sign −, which print has otherwise.
    """
    model = model_of_solution(axis)
    return prediction_halfwidth(
        model.jacobian(axis.primary, attitude),
        axis.variance_components,
        reading_standard_deviation_v,
        reading_dof,
        level,
        model.angle_jacobian(axis.primary, attitude)["roll"],
        roll_standard_uncertainty_rad,
    )
