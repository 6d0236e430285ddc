"""What a calibration will say of its uncertainties before anything is measured: the solver's own way, without outputs.

The same model is chosen, linearised and weighted as :func:`ams.calibration.calibrate.calibrate` does, and the
covariance is that of the same estimate, at the variances that are believed beforehand (:class:`~ams.solve.expected.
Belief`) instead of those that observations show.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from ams.arrays import FloatArray
from ams.calibration.columns import expect_linearised, plots_of
from ams.calibration.model_choice import asked_model, base_model
from ams.calibration_result import PackageCovariance, ParameterEstimate
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import corrected
from ams.models.model import Model
from ams.observations import Observations
from ams.solve.expected import Belief
from ams.solve.layout import layout_of
from ams.solve.linearised import linearise
from ams.solve.package import SolvedAxis, package_covariance


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


@dataclass(frozen=True)
class Expectation:
    """All axes of one package."""

    axes: Mapping[str, ExpectedSolution]
    package: PackageCovariance
    """Of the primary parameters of all axes, part by part."""


def expect(observations: Observations, request: CalibrationRequest, beliefs: Mapping[str, Belief]) -> Expectation:
    """Return what :func:`ams.calibration.calibrate.calibrate` will say on the average.

    ``observations`` are the rows as they are planned, with the outputs that a sensor without errors would give.

    Raises: DesignError where the rows cannot determine the model, SolveError where its iteration does not converge.
    """
    rows = corrected(observations, request.table)
    layout = layout_of(rows)
    axes: dict[str, ExpectedSolution] = {}
    parts: list[SolvedAxis] = []
    for label in request.axes_of(rows):
        model, errors = asked_model(label, rows, layout, request), request.shared_errors.get(label, ())
        problem = linearise([model], rows, layout, rows.outputs[label][:, None], None)
        plots = plots_of(model, rows, layout)
        solved = expect_linearised(problem, layout, plots, [beliefs[label]], request.table, errors)
        base = base_model(label, rows, request).primary_names
        axes[label] = ExpectedSolution(
            model,
            solved.primary[0],
            solved.parameters.estimates(0),
            solved.degrees_of_freedom,
            tuple(name for name in model.primary_names if name not in base),
        )
        parts.append(SolvedAxis(label, model.primary_names, solved.components, 0, errors))
    return Expectation(axes, package_covariance(parts))
