"""The annex of a certificate: the uncertainty budget of every axis, and how its coefficients correlate.

Both are read from the set: the parts of its covariance are the lines, carried to the coefficients that are reported.
Source: JCGM 100:2008, 5.2, 7.2.3, 7.2.7; EA-4/02 M:2022, 4 and 6.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ams.analysis.calibration_budget import SOURCES, AxisBudget, BudgetLine
from ams.analysis.predictions import model_with_terms
from ams.arrays import FloatArray
from ams.models.registry import MODELS
from ams.parameter_words import words_of
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.solve.derived import halfwidths_95
from ams.statistics.intervals import combined_dof, t_quantile
from procedures.solution.budget_view import BudgetView, budget_view


@dataclass(frozen=True)
class Correlations:
    """Of the coefficients of one axis, below the diagonal."""

    symbols: tuple[str, ...]
    rows: tuple[tuple[str, tuple[str, ...]], ...]
    """Symbol, and the correlation with each coefficient before it."""


@dataclass(frozen=True)
class AxisAnnex:
    """What the annex says of one axis."""

    axis: str
    budget: BudgetView
    correlations: Correlations


def annex_of(coefficients: CoefficientSet) -> Iterator[AxisAnnex]:
    """Yield every axis of a set."""
    for axis, stated in table(coefficients.document["axes"]).items():
        section = table(stated)
        yield AxisAnnex(axis, budget_view(_budget(coefficients.axes[axis], section)), _correlations(section))


def _budget(numbers: AxisNumbers, section: Document) -> AxisBudget:
    primary = table(section["primary"])
    parts = table(primary["components"])
    names, directions = _reported(numbers, [str(name) for name in listed(primary["order"])], section)
    covariances = [_matrix(table(part)["covariance"]) for part in parts.values()]
    variances = np.array([np.diag(directions @ part @ directions.T) for part in covariances]).clip(min=0.0)
    dof = np.array([_dof(table(part)["degrees_of_freedom"]) for part in parts.values()])
    u, effective = np.sqrt(variances.sum(axis=0)), combined_dof(variances, dof[:, None])
    factors = t_quantile(0.95, effective)

    def by_name(values: FloatArray) -> dict[str, float]:
        return dict(zip(names, values.tolist(), strict=True))

    lines = tuple(
        BudgetLine(*SOURCES.get(part, (part, "B")), float(dof_of_part), by_name(np.sqrt(of_part)))
        for part, dof_of_part, of_part in zip(parts, dof, variances, strict=True)
    )
    return AxisBudget(
        lines,
        combined=by_name(u),
        effective_degrees_of_freedom=by_name(effective),
        expanded_95=by_name(np.asarray(halfwidths_95(names, factors * u))),
        coverage_factor_95=by_name(factors),
        sensitivity_v_per_mps2=None,
    )


def _reported(numbers: AxisNumbers, order: Sequence[str], section: Document) -> tuple[list[str], FloatArray]:
    """Return the names of the coefficients with an uncertainty, and their (L, P) derivatives by primary parameters.

    Of lines, and of a model that is not registered here, the primary parameters themselves.
    """
    if numbers.units is not None or numbers.model not in MODELS:
        return list(order), np.eye(len(order))
    centring = (
        ()
        if numbers.centring is None
        else tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in numbers.centring)
    )
    model = model_with_terms(numbers.model, numbers.nominal_axis, order, numbers.parameters, centring)
    rows = model.parameters_jacobian(np.array([numbers.primary[name] for name in order]))
    stated = table(section["parameters"])
    kept = [
        (name, row)
        for name, row in zip(model.parameter_names, rows, strict=True)
        if name in stated and table(stated[name])["standard_uncertainty"] is not None and row.any()
    ]
    return [name for name, _ in kept], np.stack([row for _, row in kept])


def _correlations(section: Document) -> Correlations:
    names, covariance = [str(name) for name in listed(section["covariance_order"])], _matrix(section["covariance"])
    u = np.sqrt(np.diag(covariance))
    known = np.flatnonzero(u > 0.0).tolist()  # NaN where nothing is stated
    symbols = [words_of(names[column]).symbol or words_of(names[column]).label for column in known]
    rows = tuple(
        (symbol, tuple(_printed(covariance[row, column] / (u[row] * u[column])) for column in known[:index]))
        for index, (row, symbol) in enumerate(zip(known, symbols, strict=True))
    )
    return Correlations(tuple(symbols[:-1]), rows[1:])


def _printed(correlation: float) -> str:
    text = f"{correlation:.2f}".replace("-", "−")
    return "0.00" if text == "−0.00" else text


def _matrix(stated: Json) -> FloatArray:
    """Return a matrix of a set; NaN where it states nothing."""
    return np.array([[np.nan if value is None else number(value) for value in listed(row)] for row in listed(stated)])


def _dof(stated: Json) -> float:
    return float("inf") if stated is None else number(stated)
