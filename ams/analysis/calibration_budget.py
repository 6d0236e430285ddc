"""The uncertainty budget of a solved sensor axis: what scatter (type A) and certificates (type B) put into its results.

The lines are the independent parts of the covariance that the solution already has, so the budget adds up to what is
reported, degrees of freedom by Welch-Satterthwaite. Sensitivities are per local g: gravity enters only where they are
told per m/s², which is what another site needs, and stands there with its own uncertainty. The Monte Carlo check draws
every part from its distribution and evaluates the parameters themselves, not their derivatives (GUM supplement 1).
Source: GUM 5.1, G.4, H.2.
"""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from ams.analysis.predictions import model_of_solution
from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration, VarianceComponent
from ams.frames import wrap_deg
from ams.gravity import Gravity
from ams.inputs.shared_errors import COUNTED_AS_SHOWN, SharedError
from ams.models.model import Model
from ams.solve.derived import halfwidths_95
from ams.statistics.budget import Budget, Input
from ams.statistics.intervals import INFINITE_DOF, combined_dof, t_quantile
from ams.statistics.monte_carlo import summarise

SENSITIVITY = "sensitivity_v_per_g"
PER_SI = "sensitivity_v_per_mps2"
GRAVITY = "local gravity"
SOURCES: Mapping[str, tuple[str, Literal["A", "B"]]] = MappingProxyType(
    {
        "replications": ("scatter between replications (precision and drift)", "A"),
        "whole plots": ("scatter between visits of temperature plateaus", "A"),
        "lack-of-fit": ("lack of fit", "A"),
        "residuals": ("residuals of one replication", "A"),
        "field across": ("field across the coil, by the scatter of all axes", "A"),
        "resolution": ("steps of the meter, which all replications share", "B"),
        "recorded temperature": ("temperature, recorded and not modelled", "A"),
        "table": ("indices of the table", "B"),
        "temperature": ("known temperature coefficients", "B"),
    }
)
"""Part of the covariance to words and type; every other part is an error that all rows share."""


@dataclass(frozen=True)
class BudgetLine:
    """One source of uncertainty."""

    source: str
    type: Literal["A", "B"]
    degrees_of_freedom: float
    """Infinite for what a certificate states."""
    contributions: Mapping[str, float]
    """Parameter to the standard uncertainty that this source alone would leave, in the parameter's unit."""
    stated: str = ""
    """What was declared, and where."""


@dataclass(frozen=True)
class CheckedParameter:
    """One parameter in the Monte Carlo check."""

    standard_uncertainty: float
    interval_95: tuple[float, float]
    """Equal tails."""
    is_confirmed: bool
    """The budget's 95 % interval agrees to one digit of the standard uncertainty (GUM S1 8.1)."""


@dataclass(frozen=True)
class MonteCarloCheck:
    trials: int
    seed: int
    parameters: Mapping[str, CheckedParameter]


@dataclass(frozen=True)
class AxisBudget:
    """Lines, what they combine to, and the check where it was asked for."""

    lines: tuple[BudgetLine, ...]
    combined: Mapping[str, float]
    """Parameter to combined standard uncertainty."""
    effective_degrees_of_freedom: Mapping[str, float]
    expanded_95: Mapping[str, float]
    coverage_factor_95: Mapping[str, float]
    """Student's, at the effective degrees of freedom."""
    sensitivity_v_per_mps2: float | None
    """None where no gravity is stated or the model has no sensitivity."""
    monte_carlo: MonteCarloCheck | None = None


def axis_budget(
    axis: AxisCalibration,
    shared: Sequence[SharedError] = (),
    gravity: Gravity | None = None,
    *,
    stated: Mapping[str, str] = MappingProxyType({}),
    model: Model | None = None,
    trials: int = 0,
    seed: int = 0,
) -> AxisBudget:
    """Return the budget of one axis; ``trials`` above 0 adds the Monte Carlo check, drawn from ``seed``.

    ``stated``: part of the covariance to what was declared of it, for parts that ``shared`` does not tell of.

    ``model``: of the solution, where it is one of the caller's own, such as a straight line.

    Raises: DesignError where the solution is of a model that has no name and was not given.
    """
    solved_by = model or model_of_solution(axis)
    shown = _shown(axis)
    statements = {
        **stated,
        **{error.name: error.stated for error in shared},
        **{name: error["stated"] for name, error in shown.items()},
    }
    limits = {error.name for error in shared if error.kind == "limit"}
    limits |= {name for name, error in shown.items() if error["distribution"] == "limit"}
    if gravity is not None:
        statements[GRAVITY] = f"u {gravity.standard_uncertainty_mps2:g} m/s²"
    names, values, directions = _results(axis, solved_by, gravity)
    budget = _combined(axis.variance_components, names, values, directions, gravity)
    lines = tuple(
        _line(line, names, contributions, statements)
        for line, contributions in zip(budget.inputs, budget.contributions.T, strict=True)
    )
    return AxisBudget(
        lines,
        dict(zip(names, budget.standard_uncertainties.tolist(), strict=True)),
        dict(zip(names, budget.degrees_of_freedom.tolist(), strict=True)),
        dict(zip(names, _expanded(names, budget).tolist(), strict=True)),
        dict(zip(names, t_quantile(0.95, budget.degrees_of_freedom).tolist(), strict=True)),
        float(values[names.index(PER_SI)]) if PER_SI in names else None,
        _checked(axis, solved_by, names, budget, limits, gravity, trials, seed) if trials > 0 else None,
    )


def _shown(axis: AxisCalibration) -> Mapping[str, Mapping[str, str]]:
    """Return what nobody declared, by name: the rows of the calibration showed it, and its covariance holds it."""
    noted = axis.notes.get(COUNTED_AS_SHOWN)
    return noted if isinstance(noted, Mapping) else {}


def _results(axis: AxisCalibration, model: Model, gravity: Gravity | None) -> tuple[list[str], FloatArray, FloatArray]:
    """Return the names and values of the results, with their (m, P) derivatives by the primary parameters."""
    rows = model.parameters_jacobian(axis.primary)
    kept = [
        (item.name, item.value, row)
        for item, row in zip(axis.parameters, rows, strict=True)
        if item.value is not None and row.any()
    ]
    sensitivity = next(((value, row) for name, value, row in kept if name == SENSITIVITY), None)
    if gravity is not None and sensitivity is not None:
        kept.append((PER_SI, sensitivity[0] / gravity.value_mps2, sensitivity[1] / gravity.value_mps2))
    names, values, directions = zip(*kept, strict=True)
    return list(names), np.array(values), np.stack(directions)


def _combined(
    parts: Sequence[VarianceComponent],
    names: list[str],
    values: FloatArray,
    directions: FloatArray,
    gravity: Gravity | None,
) -> Budget:
    """Return a budget whose inputs are the parts, each with unit uncertainty: sensitivities are contributions."""
    covariances = [directions @ part.covariance @ directions.T for part in parts]
    dof = [part.dof for part in parts]
    labels = [part.name for part in parts]
    if PER_SI in names and gravity is not None and gravity.standard_uncertainty_mps2 > 0.0:
        effect = np.zeros(len(names))
        effect[names.index(PER_SI)] = (
            values[names.index(PER_SI)] / gravity.value_mps2 * gravity.standard_uncertainty_mps2
        )
        covariances.append(np.outer(effect, effect))
        dof.append(np.inf)
        labels.append(GRAVITY)
    variances = np.stack([np.diag(covariance) for covariance in covariances])
    degrees = combined_dof(variances, np.array(dof)[:, None])
    inputs = tuple(Input(label, 0.0, 1.0, part_dof) for label, part_dof in zip(labels, dof, strict=True))
    spread = np.sqrt(np.maximum(variances, 0.0)).T
    degrees = np.where(degrees >= INFINITE_DOF, np.inf, degrees)
    return Budget(inputs, values, spread, np.asarray(sum(covariances)), degrees)


def _line(part: Input, names: list[str], contributions: FloatArray, statements: Mapping[str, str]) -> BudgetLine:
    words, kind = SOURCES.get(part.name, (part.name, "B"))
    by_parameter = dict(zip(names, contributions.tolist(), strict=True))
    return BudgetLine(words, kind, part.degrees_of_freedom, by_parameter, statements.get(part.name, ""))


def _checked(
    axis: AxisCalibration,
    model: Model,
    names: list[str],
    budget: Budget,
    limits: Set[str],
    gravity: Gravity | None,
    trials: int,
    seed: int,
) -> MonteCarloCheck:
    """Check a budget by Monte Carlo: parts drawn, parameters evaluated anew in every trial. Source: S1 6.4, 7."""
    rng = np.random.default_rng(seed)
    primary = axis.primary + sum(_drawn(part, limits, rng, trials) for part in axis.variance_components)
    trial = dict(zip(model.parameter_names, model.parameters(primary).T, strict=True))
    if gravity is not None and SENSITIVITY in trial:
        g = gravity.value_mps2 + gravity.standard_uncertainty_mps2 * rng.standard_normal(trials)
        trial[PER_SI] = trial[SENSITIVITY] / g
    results = np.stack([_unwrapped(name, trial[name], value) for name, value in zip(names, budget.values, strict=True)])
    found = summarise(results)
    half, ends = _expanded(names, budget), found.symmetric_interval
    tolerance = 0.5 * 10.0 ** np.floor(np.log10(budget.standard_uncertainties))
    off = np.maximum(np.abs(budget.values - half - ends[:, 0]), np.abs(budget.values + half - ends[:, 1]))
    within = off <= tolerance
    columns = zip(
        names, found.standard_uncertainty.tolist(), found.symmetric_interval.tolist(), within.tolist(), strict=True
    )
    return MonteCarloCheck(
        trials, seed, {name: CheckedParameter(u, (low, high), bool(good)) for name, u, (low, high), good in columns}
    )


def _unwrapped(name: str, values: FloatArray, about: float) -> FloatArray:
    return about + wrap_deg(values - about) if name == "azimuth_deg" else values


def _expanded(names: Sequence[str], budget: Budget) -> FloatArray:
    """Return the expanded uncertainties: Student's factor at the effective degrees of freedom, these not rounded."""
    return halfwidths_95(names, t_quantile(0.95, budget.degrees_of_freedom) * budget.standard_uncertainties)


def _drawn(part: VarianceComponent, limits: Set[str], rng: np.random.Generator, trials: int) -> FloatArray:
    """Draw (trials, P) of one part.

    Student's t with its degrees of freedom, normal, or what the certificate states.
    """
    values, vectors = np.linalg.eigh(part.covariance)
    kept = values > 1e-14 * values[-1]
    root = vectors[:, kept] * np.sqrt(values[kept])
    if part.name in limits:
        return np.asarray(rng.uniform(-(3**0.5), 3**0.5, (trials, root.shape[1])) @ root.T)
    normal = rng.standard_normal((trials, root.shape[1]))
    if np.isfinite(part.dof) and part.dof < INFINITE_DOF:
        normal *= np.sqrt(part.dof / rng.chisquare(part.dof, trials))[:, None]
    return np.asarray(normal @ root.T)
