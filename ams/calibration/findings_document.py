"""What a solved axis says beyond its numbers, as additions to its JSON document: advice, F-test, H_E and budget."""

from collections.abc import Mapping
from math import isfinite

from ams.analysis.advice import Advice, DriftRate, ResidualTerm, advise
from ams.analysis.calibration_budget import AxisBudget, MonteCarloCheck
from ams.calibration.document import Document, number, to_document
from ams.calibration_result import METHOD_VERSION, AxisCalibration, Calibration, PackageCovariance
from ams.observations import Observations
from ams.solve.extension import Extension
from ams.solve.residual_curvature import ResidualCurvature


def full_document(
    calibration: Calibration, observations: Observations, budgets: Mapping[str, AxisBudget] | None = None
) -> Document:
    """Return the document of ``ams.calibration.document`` with model, convention and findings.

    Every axis has ``advice``, where it was tried or asked for ``extension`` and ``residual_curvature``, and its
    ``budget`` where one is given.
    """
    base = to_document(calibration)
    sections = base["axes"]
    assert isinstance(sections, dict)
    for label, axis in calibration.axes.items():
        sections[label]["advice"] = advice_document(advise(axis, observations))
        sections[label]["findings"] = findings_document(axis)
        sections[label] |= noted_findings(axis)
        if budgets is not None:
            sections[label]["budget"] = budget_document(budgets[label])
    return {
        **base,
        "verdict": calibration.verdict,
        "method_version": METHOD_VERSION,
        "model": calibration.model,
        "convention": calibration.convention,
        "package_covariance": None if calibration.package is None else _package(calibration.package),
    }


def findings_document(axis: AxisCalibration) -> list[Document]:
    """Return every finding of an axis, numbers finite or null."""
    return [
        {name: number(value) if isinstance(value, float) else value for name, value in finding.to_document().items()}
        for finding in axis.findings
    ]


def _package(package: PackageCovariance) -> Document:
    return {
        "order": [list(entry) for entry in package.order],
        "covariance": [[number(value) for value in row] for row in package.covariance.tolist()],
    }


def advice_document(advice: Advice) -> Document:
    """Return the largest repeating terms, drifting parameters, and both as sentences."""
    return {
        "lack_of_fit": [_term(term) for term in advice.lack_of_fit],
        "drift": [_rate(rate) for rate in advice.drift],
        "sentences": list(advice.sentences),
    }


def noted_findings(axis: AxisCalibration) -> Document:
    """Return what was asked for and tried: ``extension`` and ``residual_curvature``; nothing where neither was."""
    found: Document = {}
    extension, curvature = axis.notes.get("extension"), axis.notes.get("residual_curvature")
    if isinstance(extension, Extension):
        found["extension"] = {
            "terms": extension.terms,
            "is_accepted": extension.is_accepted,
            "f": number(extension.test.t),
            "f_95": number(extension.test.f_95),
            "p_value": number(extension.test.p_value),
            "standard_error_before_v": number(extension.standard_error_before_v),
            "standard_error_after_v": number(extension.standard_error_after_v),
            "remark": extension.remark,
        }
    if isinstance(curvature, ResidualCurvature):
        found["residual_curvature"] = {
            "names": list(curvature.names),
            "h_e": [[number(value) for value in row] for row in curvature.h_e.tolist()],
            "standard_uncertainty_ratio": _numbers(curvature.standard_uncertainty_ratio),
        }
    return found


def budget_document(budget: AxisBudget) -> Document:
    """Return every source with what it puts into every parameter."""
    document: Document = {
        "lines": [
            {
                "source": line.source,
                "type": line.type,
                "stated": line.stated,
                "degrees_of_freedom": number(line.degrees_of_freedom),
                "standard_uncertainty": _numbers(line.contributions),
            }
            for line in budget.lines
        ],
        "combined_standard_uncertainty": _numbers(budget.combined),
        "effective_degrees_of_freedom": _numbers(budget.effective_degrees_of_freedom),
        "coverage_factor_95": _numbers(budget.coverage_factor_95),
        "expanded_uncertainty_95": _numbers(budget.expanded_95),
        "sensitivity_v_per_mps2": number(budget.sensitivity_v_per_mps2),
    }
    if budget.monte_carlo is not None:
        document["monte_carlo"] = _check(budget.monte_carlo)
    return document


def _check(check: MonteCarloCheck) -> Document:
    return {
        "trials": check.trials,
        "seed": check.seed,
        "parameters": {
            name: {
                "standard_uncertainty": number(found.standard_uncertainty),
                "interval_95": [number(end) for end in found.interval_95],
                "is_confirmed": found.is_confirmed,
            }
            for name, found in check.parameters.items()
        },
    }


def _term(term: ResidualTerm) -> Document:
    return {
        "name": term.name,
        "amplitude_v": number(term.amplitude_v),
        "interval_95_v": [number(end) for end in term.interval_95_v],
        "amplitude_deg": number(term.amplitude_deg),
        "interval_95_deg": [number(end) for end in term.interval_95_deg],
        "cause": term.cause,
    }


def _rate(rate: DriftRate) -> Document:
    return {
        "parameter": rate.parameter,
        "per_replication": number(rate.per_replication),
        "interval_95": _interval(rate.interval_95),
        "per_hour": number(rate.per_hour),
        "per_hour_interval_95": _interval(rate.per_hour_interval_95),
    }


def _interval(interval: tuple[float, float] | None) -> list[float | None] | None:
    return None if interval is None else [number(end) for end in interval]


def _numbers(values: Mapping[str, float]) -> dict[str, float | None]:
    return {name: float(value) if isfinite(value) else None for name, value in values.items()}
