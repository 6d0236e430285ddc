"""What a calibration will say of its uncertainties before anything is measured: the solver's own way, without outputs.

The same model is chosen, linearised and weighted as :func:`ams.calibration.calibrate.calibrate` does, and the
covariance is that of the same estimate, at the variances that are believed beforehand (:class:`~ams.solve.expected.
Belief`) instead of those that observations show.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.solving.columns import expect_linearised, plots_of, solve_linearised
from ams.calibration.solving.model_choice import base_model, requested_model
from ams.calibration_result import PackageCovariance, ParameterEstimate
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import corrected
from ams.models.model import Model
from ams.observations import Observations
from ams.solve.expected import Belief
from ams.solve.layout import Layout, layout_of
from ams.solve.linearised import linearise
from ams.solve.package import SolvedAxis, package_covariance


@dataclass(frozen=True)
class PlannedPoints:
    """Points as they will follow one another: what the findings on their order look at."""

    rows: Observations
    layout: Layout
    models: Sequence[Model]
    basis: FloatArray
    """(K, P) at the points."""


@dataclass(frozen=True)
class ExpectedSolution:
    """One sensor axis as it will be solved."""

    model: Model
    primary: FloatArray
    """(P,)"""
    parameters: tuple[ParameterEstimate, ...]
    """As they will be stated: uncertainties, degrees of freedom and 95 % intervals."""
    degrees_of_freedom: int
    added: tuple[str, ...]
    """Primary parameters beside those of the model that was asked for: terms of low order, of temperature, of time."""
    points: PlannedPoints


@dataclass(frozen=True)
class Expectation:
    """All axes of one package."""

    axes: Mapping[str, ExpectedSolution]
    package: PackageCovariance
    """Of the primary parameters of all axes, part by part."""


@dataclass(frozen=True)
class Shown:
    """What replications have shown of one axis without looking at its estimates."""

    belief: Belief
    """Precision inside the replications, lack of fit, and what samples show."""
    drifting: tuple[str, ...]
    """Quantities whose drift is significant."""


def shown(observations: Observations, request: CalibrationRequest) -> dict[str, Shown]:
    """Return what the axes have shown in two replications or more.

    Precision and lack of fit are independent of the spread between the replications, from which intervals are made: who
    decides by them whether to go on leaves the intervals their coverage.

    Raises: AmsError where the rows cannot be solved.
    """
    rows = corrected(observations, request.table)
    layout = layout_of(rows)
    found = {}
    for label in request.axes_of(rows):
        model, errors = requested_model(label, rows, layout, request), request.shared_errors.get(label, ())
        sampled = [rows.sampled.get(label)]
        problem = linearise([model], rows, layout, rows.outputs[label][:, None], None, sampled)
        solved = solve_linearised(problem, layout, plots_of(model, rows, layout), request.table, errors)
        precision, lack_of_fit = (
            float(np.sqrt(np.nan_to_num(variance[0])))
            for variance in (solved.mixed.precision_variance, solved.mixed.lack_of_fit_variance)
        )
        tests = {} if solved.replication is None else solved.replication.drift
        drifting = tuple(name for name, test in tests.items() if test.of(0).is_significant)
        found[label] = Shown(Belief(precision, lack_of_fit, sampled=sampled[0]), drifting)
    return found


def expect(observations: Observations, request: CalibrationRequest, beliefs: Mapping[str, Belief]) -> Expectation:
    """Return what :func:`ams.calibration.calibrate.calibrate` will say on the average.

    ``observations`` are the rows as they are planned, with the outputs that a sensor without errors would give.

    Raises: DesignError where the rows cannot determine the model, SolveError where its iteration does not converge.
    """
    (only,) = expect_each(observations, request, [beliefs])
    return only


def expect_each(
    observations: Observations, request: CalibrationRequest, beliefs: Sequence[Mapping[str, Belief]]
) -> list[Expectation]:
    """Return the same for several beliefs about the same rows: everything that the rows decide is made once.

    Raises: as :func:`expect`.
    """
    rows = corrected(observations, request.table)
    layout = layout_of(rows)
    parts: list[list[SolvedAxis]] = [[] for _ in beliefs]
    axes: list[dict[str, ExpectedSolution]] = [{} for _ in beliefs]
    for label in request.axes_of(rows):
        model, errors = requested_model(label, rows, layout, request), request.shared_errors.get(label, ())
        base = base_model(label, rows, request).primary_names
        added = tuple(name for name in model.primary_names if name not in base)
        is_iterated = model.basis_key is None
        for rows_together in [[index] for index in range(len(beliefs))] if is_iterated else [range(len(beliefs))]:
            outputs = np.tile(rows.outputs[label][:, None], (1, len(rows_together)))
            problem = linearise([model] * len(rows_together), rows, layout, outputs, None)
            points = PlannedPoints(rows, layout, [model], problem.basis_at_points(layout))
            axis_beliefs = [beliefs[index][label] for index in rows_together]
            solved = expect_linearised(
                problem, layout, plots_of(model, rows, layout), axis_beliefs, request.table, errors
            )
            for row, index in enumerate(rows_together):
                axes[index][label] = ExpectedSolution(
                    model,
                    solved.primary[row],
                    solved.parameters.estimates(row),
                    solved.degrees_of_freedom,
                    added,
                    points,
                )
                parts[index].append(SolvedAxis(label, model.primary_names, solved.components, row, errors))
    return [Expectation(axis, package_covariance(part)) for axis, part in zip(axes, parts, strict=True)]
