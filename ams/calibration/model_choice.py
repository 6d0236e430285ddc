"""Which model a request and the observations themselves ask for: base, extension, temperature terms."""

from dataclasses import dataclass, replace

import numpy as np

from ams.errors import DesignError
from ams.inputs.request import CalibrationRequest
from ams.models.drifting import with_time
from ams.models.extended import ExtendedPitchRoll
from ams.models.model import Model
from ams.models.registry import model_named
from ams.models.thermal import WithTemperature, refuse_unless_estimable
from ams.observations import Observations
from ams.solve.extension import Extension, judge_extension

DEFAULT_REFERENCE_DEGC = 20.0


@dataclass(frozen=True)
class ModelChoice:
    """The model of one sensor axis and how it came to be chosen."""

    model: Model
    extension: Extension | None = None
    """The F-test on the extended model, where it was made."""
    warnings: tuple[str, ...] = ()


def base_model(label: str, observations: Observations, request: CalibrationRequest) -> Model:
    """Return the model without extension and temperature terms.

    Raises:
        DesignError: there is no such model or axis.
    """
    return request.models.get(label) or model_named(request.model, request.axes_of(observations)[label])


def choose_model(label: str, rows: Observations, request: CalibrationRequest) -> ModelChoice:
    """Return the model of one sensor axis for the rows that are solved.

    Raises:
        DesignError: no such model, or terms that were asked for are not known, not estimable or do not exist for it.
    """
    choice = _with_extension(label, rows, request, base_model(label, rows, request))
    if request.temperature != "none":
        choice = replace(choice, model=_with_temperature(label, rows, request, choice.model))
    return replace(choice, model=with_time(choice.model, rows)) if request.time_term else choice


def _with_extension(label: str, rows: Observations, request: CalibrationRequest, base: Model) -> ModelChoice:
    if request.extended == "no":
        return ModelChoice(base)
    if base.name != "pitch-roll":
        if request.extended == "test":
            return ModelChoice(base, None, (f"axis {label}: extended model not tested: it extends pitch-roll only",))
        raise DesignError(
            f"extended: axis {label}: got yes for model {base.name}, allowed with pitch-roll only; "
            "nothing was solved; ask for no"
        )

    if request.extended == "yes":
        return ModelChoice(ExtendedPitchRoll(base.nominal_axis))
    return _tested(label, rows, request, base)


def _tested(label: str, rows: Observations, request: CalibrationRequest, base: Model) -> ModelChoice:
    if request.temperature != "none":
        return ModelChoice(base, None, (f"axis {label}: extended model not tested: temperature terms are asked for",))
    try:
        extension = judge_extension(rows, label, request.table)
    except DesignError as refusal:
        return ModelChoice(base, None, (f"axis {label}: extended model not tested: {refusal}",))
    if not extension.is_accepted:
        return ModelChoice(base, extension)
    accepted = (
        f"axis {label}: extended model accepted: F = {extension.test.t:.3g} above {extension.test.f_95:.3g}; "
        f"standard error {extension.standard_error_before_v:.3g} V to {extension.standard_error_after_v:.3g} V; "
        f"{extension.remark}"
    )
    return ModelChoice(ExtendedPitchRoll(base.nominal_axis), extension, (accepted,))


def _with_temperature(label: str, rows: Observations, request: CalibrationRequest, base: Model) -> Model:
    reference_degc = _reference_degc(rows, request)
    if request.temperature == "estimate":
        refuse_unless_estimable(rows)
        return WithTemperature(base, reference_degc)
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
