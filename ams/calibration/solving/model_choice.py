"""Which model a request and the observations themselves ask for: base, extension, temperature terms."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import Centring
from ams.errors import DesignError, ObservationsError
from ams.frames import Attitude
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import PitchOnly, PitchRoll
from ams.models.added_parameters import WithAddedParameters
from ams.models.drifting import with_time
from ams.models.extended import ExtendedPitchRoll, centring_of, extended_model
from ams.models.gyro import Gyro, GyroWithTerms, with_rate_terms
from ams.models.model import Model
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.models.registry import model_named
from ams.models.thermal import WithTemperature, refuse_unless_estimable
from ams.observations import Observations
from ams.sets.verdict_conditions import (
    NO_COEFFICIENTS_U,
    RATE_TERMS_NOT_DETERMINED,
    TERMS_NOT_DETERMINED,
    TERMS_NOT_TESTED,
)
from ams.solve.extension import Extension, blocks_of_angles, judge_extension, judge_rate_terms
from ams.solve.layout import Layout

DEFAULT_REFERENCE_DEGC = 20.0
"""°C where no temperature was recorded and none is asked for."""
NOT_DETERMINED = (
    f"{TERMS_NOT_DETERMINED} and not in the uncertainty: a soft mount or a "
    "nonlinearity of the sensor would bend the offset; add pitch and roll angles (five or more of each, past ±45°)"
)
RATES_NOT_ENOUGH = (
    f"{RATE_TERMS_NOT_DETERMINED} and not in the uncertainty: turn "
    "each axis at four rates or more, standing still and both senses among them"
)
WHICH_LINE = (
    "offset and scale factor are those of the straight line that comes closest over these rates; how far the output "
    "lies from it, its nonlinearity, stands beside them"
)
WHICH_OFFSET = (
    "offset and sensitivities are those of the linear sensor that comes closest over these points; the offset beside "
    "terms of second order with tr Q = 0 is given too"
)


@dataclass(frozen=True)
class ModelChoice:
    """The model of one sensor axis and how it came to be chosen."""

    model: Model
    extension: Extension | None = None
    """The F-test on the extended model, where it was made."""
    warnings: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def centring(self) -> Centring:
        """Of the extended model's terms; empty without them."""
        model = self.model
        while isinstance(model, WithAddedParameters):
            model = model.base
        return model.centring if isinstance(model, ExtendedPitchRoll | GyroWithTerms) else ()


def base_model(label: str, observations: Observations, request: CalibrationRequest) -> Model:
    """Return the model without extension and temperature terms.

    Raises:
        DesignError: there is no such model or axis.
    """
    return request.models.get(label) or model_named(request.model, request.axes_of(observations)[label])


def choose_model(label: str, rows: Observations, layout: Layout, request: CalibrationRequest) -> ModelChoice:
    """Return the model of one sensor axis for the rows that are solved.

    Raises:
        DesignError: no such model, or terms that were asked for are not known, not estimable or do not exist for it.
    """
    if rows.is_of_levels:
        _refuse_temperature_of_lines(label, rows, request)
    choice = _with_extension(label, rows, layout, request, base_model(label, rows, request))
    if request.temperature != "none":
        model = _with_temperature(label, rows, request, choice.model)
        choice = replace(choice, model=model, remarks=(*choice.remarks, *_of_the_coefficients(model)))
    return replace(choice, model=with_time(choice.model, rows)) if request.time_term else choice


def _refuse_temperature_of_lines(label: str, rows: Observations, request: CalibrationRequest) -> None:
    """Refuse temperature beside a straight line of known levels. Raises: DesignError."""
    if request.temperature == "none":
        return
    raise DesignError(
        f"{rows.source}: axis {label}: got temperature = {request.temperature!r}, and a straight line of known levels "
        "has no term of it; nothing was solved; leave it out and hold the temperature, or solve by a model of the "
        "sensor"
    )


def requested_model(label: str, rows: Observations, layout: Layout, request: CalibrationRequest) -> Model:
    """Return the model that is asked for whatever the outputs are: terms that a test decides on do not stand in it.

    Raises: DesignError as :func:`choose_model` does.
    """
    base = base_model(label, rows, request)
    model = (_extended(rows, layout, base) if request.extended == "yes" else None) or base
    if request.temperature != "none":
        model = _with_temperature(label, rows, request, model)
    return with_time(model, rows) if request.time_term else model


def _with_extension(
    label: str, rows: Observations, layout: Layout, request: CalibrationRequest, base: Model
) -> ModelChoice:
    """``yes``: wherever the points determine the terms; ``test``: where the F-test accepts them."""
    if request.extended == "no":
        is_blind = base.name == PitchRoll.name and _extended(rows, layout, base) is None
        return ModelChoice(base, remarks=(NOT_DETERMINED,) if is_blind else ())
    if isinstance(base, Gyro):
        return _with_rate_terms(label, rows, layout, request, base)
    if base.name != PitchRoll.name:
        return ModelChoice(base, remarks=_not_of_this_model(label, request, base))
    extended = _extended(rows, layout, base)
    extension, refusal = _judged(label, rows, layout, request)
    if extended is None:
        return ModelChoice(base, extension, remarks=(NOT_DETERMINED,))
    if request.extended == "yes":
        return ModelChoice(extended, extension, remarks=(WHICH_OFFSET,))
    if extension is None:
        return ModelChoice(base, None, (f"axis {label}: extended model not tested: {refusal}",))
    if not extension.is_accepted:
        return ModelChoice(base, extension)
    return ModelChoice(extended, extension, _found(label, extension), (WHICH_OFFSET,))


def _with_rate_terms(
    label: str, rows: Observations, layout: Layout, request: CalibrationRequest, base: Gyro
) -> ModelChoice:
    bent = with_rate_terms(base, rows, layout.points)
    if bent is None:
        return ModelChoice(base, remarks=(RATES_NOT_ENOUGH,))
    if request.extended == "yes":
        return ModelChoice(bent, remarks=(WHICH_LINE,))
    if request.temperature != "none" or request.time_term:
        return ModelChoice(
            base, None, (f"axis {label}: nonlinearity not tested: temperature or time terms are asked for",)
        )
    extension = judge_rate_terms(rows, label, bent, layout=layout)
    if not extension.is_accepted:
        return ModelChoice(base, extension)
    return ModelChoice(bent, extension, _found(label, extension), (WHICH_LINE,))


def _extended(rows: Observations, layout: Layout, base: Model) -> ExtendedPitchRoll | GyroWithTerms | None:
    if isinstance(base, Gyro):
        return with_rate_terms(base, rows, layout.points)
    if base.name != PitchRoll.name:
        return None
    design = Attitude(*(blocks_of_angles(rows, layout) or (rows.pitch_rad, rows.roll_rad)))
    centring = centring_of(design, layout.points, base.nominal_axis)
    return None if centring is None else extended_model(base.nominal_axis, centring)


def _not_of_this_model(label: str, request: CalibrationRequest, base: Model) -> tuple[str, ...]:
    if request.extended == "test":
        return (f"axis {label}: extended model not tested: it extends pitch-roll and gyro only", *_not_tested(base))
    return (*((NOT_DETERMINED,) if base.name == PitchOnly.name else ()), *_not_tested(base))


def _not_tested(base: Model) -> tuple[str, ...]:
    """Return what the data are not asked for a sensor of force of another model than pitch and roll."""
    return () if isinstance(base, PitchYawRoll) or base.convention == "SR" else (TERMS_NOT_TESTED,)


def _judged(
    label: str, rows: Observations, layout: Layout, request: CalibrationRequest
) -> tuple[Extension | None, str]:
    """Return the F-test, or why there is none."""
    if request.temperature != "none" or request.time_term:
        return None, "temperature or time terms are asked for"
    try:
        return judge_extension(rows, label, request.table, layout=layout), ""
    except DesignError as refusal:
        return None, str(refusal)


def _found(label: str, extension: Extension | None) -> tuple[str, ...]:
    """Tell what the F-test says of terms that stand in the model, where it is significant."""
    if extension is None or not extension.is_accepted:
        return ()
    return (
        f"axis {label}: {extension.terms} are significant: F = {extension.test.t:.3g} above "
        f"{extension.test.f_95:.3g}; standard error {extension.standard_error_before_v:.3g} V to "
        f"{extension.standard_error_after_v:.3g} V with them; {extension.remark}",
    )


def _of_the_coefficients(model: WithTemperature) -> tuple[str, ...]:
    """Return what nobody declared of coefficients that are applied."""
    if model.known is None or model.known.has_uncertainties:
        return ()
    return (
        f"{NO_COEFFICIENTS_U}: they count as exact, and what they are wrong by is in no figure stated here; "
        "declare offset_tc_uncertainty_v_per_degc and "
        "sensitivity_tc_uncertainty_per_degc beside them (calrig fit: two more numbers)",
    )


def _with_temperature(label: str, rows: Observations, request: CalibrationRequest, base: Model) -> WithTemperature:
    reference_degc = _reference_degc(rows, request)
    if request.temperature == "estimate":
        refuse_unless_estimable(rows, request.temperature_order)
        return WithTemperature(base, reference_degc, estimated_order=request.temperature_order)
    if label not in request.known_temperature:
        raise DesignError(
            f"temperature apply: axis {label}: no coefficients given: got those of "
            f"{', '.join(request.known_temperature) or 'no axis'}; nothing was solved; "
            "give offset and sensitivity coefficients"
        )
    return WithTemperature(base, reference_degc, request.known_temperature[label])


def _reference_degc(rows: Observations, request: CalibrationRequest) -> float:
    if request.reference_temperature_degc is not None:
        return request.reference_temperature_degc
    if rows.temperature_degc is None:
        return DEFAULT_REFERENCE_DEGC
    return float(np.round(rows.temperature_degc.mean()))


def refuse_foreign_units(labels: Sequence[str], observations: Observations, request: CalibrationRequest) -> None:
    """Refuse outputs of another unit than their models state.

    Raises:
        ObservationsError: which axis, its unit, and what to do.
    """
    for label in labels:
        model, unit = base_model(label, observations, request), observations.unit_of(label)
        if unit != model.measured_unit:
            raise ObservationsError(
                f"{observations.source}: axis {label}: got readings in {unit}, the model {model.name!r} states "
                f"{_in_words(model.measured_unit)}; nothing was solved; declare the channel in that unit (for a "
                'stream: counts_per_unit and unit = "v"), or ask for straight lines, solve.model = "linear"'
            )


def _in_words(unit: str) -> str:
    return "volts" if unit == "v" else unit
