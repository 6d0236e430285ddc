"""Confidence and prediction intervals of a solved sensor axis at any attitude, TP (72) to (74).

The confidence interval holds the calibrated output, the prediction interval one new reading. The new reading's own
standard deviation is that of the place where the sensor is used (the tunnel's), not of the calibration.
"""

from collections.abc import Mapping, Sequence

from ams.arrays import Centring, FloatArray
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
    references = {item.name: item.value for item in axis.parameters}
    return model_with_terms(axis.model, axis.nominal_axis, axis.primary_names, references, axis.centring)


def model_with_terms(
    name: str,
    nominal_axis: str,
    primary_names: Sequence[str],
    parameters: Mapping[str, float | None],
    centring: Centring,
) -> Model:
    """Return a registered model with the terms of temperature and time that its primary parameters have.

    ``parameters``: stated, for where these terms are zero. Raises: DesignError.
    """
    model = _timeless(name, nominal_axis, centring)
    if TEMPERATURE_NAMES[0] in primary_names:
        reference_degc = parameters["reference_temperature_degc"]
        assert reference_degc is not None
        order: Order = 2 if SECOND_ORDER_NAMES[0] in primary_names else 1
        model = WithTemperature(model, reference_degc, estimated_order=order)
    if DRIFT_NAME in primary_names:
        reference_s = parameters[REFERENCE_NAME]
        assert reference_s is not None
        model = WithTime(model, reference_s)
    return model


def _timeless(name: str, nominal_axis: str, centring: Centring) -> Model:
    if name == ExtendedPitchRoll.name and centring:
        return ExtendedPitchRoll(nominal_axis, centring)
    if name == Gyro.name and centring:
        return GyroWithTerms(nominal_axis, centring)
    return model_named(name, nominal_axis)


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
) -> FloatArray:
    """Return the (N,) half-width for one new reading, volts. Source: TP (73), (74) with the divisor σ_E²."""
    directions = model_of_solution(axis).jacobian(axis.primary, attitude)
    return prediction_halfwidth(directions, axis.variance_components, reading_standard_deviation_v, reading_dof, level)
