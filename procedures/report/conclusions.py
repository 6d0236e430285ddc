"""What the numbers of one sensor axis say, in plain words: parameters as rows, tests as sentences.

Pure functions of the solution and the observations it was made from. Source: TP 8, table 2.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from ams.analysis.advice import advise
from ams.analysis.calibration_budget import AxisBudget
from ams.analysis.diagnostics.words.held_words import held_words
from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration, FTest, ParameterEstimate, Replication
from ams.findings import EXPLAINED_BY
from ams.frames import wrap_deg
from ams.observations import Observations
from ams.parameter_words import words_of
from ams.rounding import two_digits
from ams.solve.extension import Extension
from ams.statistics.distributions import f_tail
from ams.statistics.intervals import t_quantile
from ams.units import ARCSEC_PER_DEG
from procedures.numbers import angle, arcsec, three_digits
from procedures.report.view import AxisView, ParameterRow, TestRow
from procedures.solution.budget_view import budget_view

_PLAIN: Final = 0.001
"""Chance, against precision alone, below which residuals are said to repeat though what is known explains them."""


def sensitivity_of(calibration: AxisCalibration) -> float:
    """Return what turns volts into angles: |k|, or the largest parameter per g of a model without a k of its own."""
    along = float(np.linalg.norm(np.nan_to_num(calibration.sensitive_axis_v_per_g)))
    per_g = (
        parameter.value
        for parameter in calibration.parameters
        if parameter.name.endswith("_v_per_g") and parameter.value is not None
    )
    return along or max(map(abs, per_g), default=along)


def axis_view(
    axis: str,
    channel: str,
    calibration: AxisCalibration,
    observations: Observations,
    truth: dict[str, float],
    budget: AxisBudget | None = None,
) -> AxisView:
    """Everything that is said about one axis. ``truth``: parameter name to the twin's value; empty at the bench."""
    sensitivity = sensitivity_of(calibration)
    rows = tuple(parameter_row(estimate, sensitivity, truth.get(estimate.name)) for estimate in calibration.parameters)
    tests = () if calibration.replication is None else _tests(calibration, calibration.replication, observations)
    return AxisView(
        axis,
        channel,
        calibration,
        sensitivity,
        rows,
        tests,
        (*_remarks(calibration, sensitivity), *calibration.remarks),
        advise(calibration, observations).sentences,
        None if budget is None else budget_view(budget),
    )


def parameter_row(estimate: ParameterEstimate, sensitivity: float, truth: float | None) -> ParameterRow:
    """Return one printed row. ``sensitivity``: magnitude, V/g, that turns an offset into an angle."""
    label, symbol, unit = words_of(estimate.name)
    factor, expanded = _expanded(estimate)
    return ParameterRow(
        name=estimate.name,
        label=label,
        symbol=symbol,
        unit=unit,
        value=estimate.value,
        standard_uncertainty=estimate.standard_uncertainty,
        degrees_of_freedom=estimate.effective_degrees_of_freedom,
        coverage_factor=factor,
        expanded_uncertainty=expanded,
        interval_95=estimate.interval_95,
        tp_standard_uncertainty=estimate.tp_standard_uncertainty,
        in_other_terms=_in_other_terms(estimate, expanded, sensitivity),
        truth=truth,
    )


def _expanded(estimate: ParameterEstimate) -> tuple[float | None, float | None]:
    """Return k from Student's t and U = k·u, or None twice."""
    u, dof = estimate.standard_uncertainty, estimate.effective_degrees_of_freedom
    if u is None or dof is None or not dof > 0.0:
        return None, None

    factor = float(t_quantile(0.95, dof))
    return factor, factor * u


def _in_other_terms(estimate: ParameterEstimate, expanded: float | None, sensitivity: float) -> str:
    if expanded is None or estimate.value is None:
        return ""
    if estimate.name == "offset_v" and sensitivity > 0.0:
        return f"{two_digits(arcsec(expanded, sensitivity))}″"
    if estimate.name.startswith("sensitivity_v") and estimate.value != 0.0:
        return f"{two_digits(1e6 * expanded / abs(estimate.value))} ppm"
    return f"{two_digits(ARCSEC_PER_DEG * expanded)}″" if estimate.name.endswith("_deg") else ""


def _remarks(calibration: AxisCalibration, sensitivity: float) -> tuple[str, ...]:
    """Return what was tried beside the model."""
    extension = calibration.notes.get("extension")
    if not isinstance(extension, Extension):
        return ()
    before, after = (
        two_digits(arcsec(error_v, sensitivity))
        for error_v in (extension.standard_error_before_v, extension.standard_error_after_v)
    )
    verdict = "are significant" if extension.is_accepted else "are not significant"
    return (
        f"Terms of second order (such as a soft mount inside the package) {verdict}: F = "
        f"{three_digits(extension.test.t)} against {three_digits(extension.test.f_95)}, standard error {before}″ "
        f"without and {after}″ with them.",
    )


def mean_residuals(
    calibration: AxisCalibration, observations: Observations
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the pitch (°), roll (°) and mean residual over the replications (V) of every design point, by label."""
    labels, index = np.unique(observations.point, return_inverse=True)
    visits = np.bincount(index, minlength=labels.size)
    columns = (np.rad2deg(observations.pitch_rad), np.rad2deg(observations.roll_rad), calibration.residuals_v)
    pitch, roll, residual = (np.bincount(index, column, labels.size) / visits for column in columns)
    return pitch, roll, residual


def by_replication(replication: Replication, parameter: str) -> dict[int, float]:
    """Return the estimates of one parameter from each replication alone, azimuths without a jump at ±180°."""
    values = {label: row.get(parameter, np.nan) for label, row in sorted(replication.per_replication.items())}
    values = {label: float(value) for label, value in values.items() if np.isfinite(value)}
    if parameter == "azimuth_deg" and values:
        first = next(iter(values.values()))
        return {label: first + wrap_deg(value - first) for label, value in values.items()}
    return values


def repeating_v(replication: Replication) -> float:
    """Return the standard deviation over the attitudes of what repeats in every replication, the table's part included.

    From the test value itself: s² = (MS_lof − MS_prec)/n with MS_lof = T·MS_prec.
    """
    share = max(0.0, (replication.lack_of_fit.t - 1.0) / replication.replications)
    return replication.precision_v * math.sqrt(share)


def _tests(calibration: AxisCalibration, replication: Replication, observations: Observations) -> tuple[TestRow, ...]:
    sensitivity = sensitivity_of(calibration)
    size = f"{two_digits(arcsec(repeating_v(replication), sensitivity))}″"
    tp = (replication.tp.t_bias, replication.tp.f_bias_95)
    sentence = _lack_of_fit_sentence(calibration, replication, observations, size)
    lack_of_fit = _row("lack of fit", "", replication.lack_of_fit, tp, size, sentence)
    lack_of_fit = replace(lack_of_fit, is_explained=_repeats_within_what_is_known(replication.lack_of_fit))
    return (lack_of_fit, *(_drift_row(calibration, replication, name, sensitivity) for name in replication.drift))


def _repeats_within_what_is_known(test: FTest) -> bool:
    """Return whether T, which is against precision alone, is plain, and p, beside the table and what is known, not."""
    alone = float(f_tail(test.t, test.numerator_dof, test.denominator_dof)) if test.t > test.f_95 else 1.0
    return not test.is_significant and alone <= _PLAIN


def _row(subject: str, parameter: str, test: FTest, tp: tuple[float, float], size: str, conclusion: str) -> TestRow:
    dof = (test.numerator_dof, test.denominator_dof)
    return TestRow(subject, parameter, test.t, test.f_95, test.p_value, dof, test.is_significant, size, conclusion, *tp)


def _explanation(calibration: AxisCalibration, test: str) -> str:
    """Return what explains a test that is significant by itself; empty where nothing is to explain."""
    found = next((finding.details for finding in calibration.findings if finding.details.get("test") == test), {})
    return f"explained by {found[EXPLAINED_BY]}" if EXPLAINED_BY in found else ""


def _lack_of_fit_sentence(
    calibration: AxisCalibration, replication: Replication, observations: Observations, size: str
) -> str:
    if not replication.lack_of_fit.is_significant:
        explanation = _explanation(calibration, "lack of fit")
        if not explanation and not _repeats_within_what_is_known(replication.lack_of_fit):
            return "No lack of fit found."
        within = explanation or (
            f"{size} (standard deviation over the attitudes), no more than the table’s index errors and what else is "
            f"known explain (p; T is against precision alone). {_held(calibration, is_drift=False)}"
        )
        return f"The residuals repeat from replication to replication: {within}."
    pitch, roll, residual = mean_residuals(calibration, observations)
    worst = int(np.argmax(np.abs(residual)))
    sensitivity = sensitivity_of(calibration)
    return (
        f"The residuals repeat from replication to replication: {size} (standard deviation over the attitudes), most "
        f"at pitch {angle(float(pitch[worst]))}, roll {angle(float(roll[worst]))} with "
        f"{two_digits(arcsec(abs(float(residual[worst])), sensitivity))}″. The table's own index errors are part of "
        f"it. {_held(calibration, is_drift=False)}."
    )


def _held(calibration: AxisCalibration, *, is_drift: bool) -> str:
    words = held_words(calibration.findings, is_drift=is_drift)
    return f"{words[0].upper()}{words[1:]}"


def _drift_row(calibration: AxisCalibration, replication: Replication, name: str, sensitivity: float) -> TestRow:
    test, tp = replication.drift[name], replication.tp.drift.get(name)
    parameter = next((row.name for row in calibration.parameters if row.name.startswith(name)), name)
    size = _size(parameter, float(np.ptp([*by_replication(replication, parameter).values()] or [np.nan])), sensitivity)
    conclusion = f"No change of {name} from replication to replication found."
    if test.is_significant:
        conclusion = (
            f"{name.capitalize()} changed between the replications by {size} (largest less smallest). "
            f"{_held(calibration, is_drift=True)}."
        )
    elif explanation := _explanation(calibration, f"drift of {name}"):
        conclusion = f"{name.capitalize()} changed between the replications by {size}: {explanation}."
    limits = (float("nan"), float("nan")) if tp is None else (tp.t, tp.f_95)
    return _row(f"drift of {name}", parameter, test, limits, size, conclusion)


def _size(parameter: str, span: float, sensitivity: float) -> str:
    if parameter == "offset_v":
        return f"{two_digits(span * 1e6)} µV or {two_digits(arcsec(span, sensitivity))}″"
    if parameter.startswith("sensitivity_v"):
        return f"{two_digits(1e6 * span / sensitivity)} ppm"
    return f"{two_digits(ARCSEC_PER_DEG * span)}″" if parameter.endswith("_deg") else three_digits(span)
