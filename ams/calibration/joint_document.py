"""The joint fit of package and table from a file of one or two mountings, and its JSON document.

The file's angles are the table's. A column of mounts says ``upright`` or ``reversed`` (half round on its seat) for
every row; replications are numbered on from one mount to the next, so that every (replication, point) stands once.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from ams.analysis.calibration_budget import AxisBudget
from ams.calibration.document import Document, degrees_of_freedom, number
from ams.calibration.findings_document import budget_document, findings_document
from ams.calibration.joint_diagnosis import JointDiagnosis
from ams.calibration.solving.model_choice import NOT_DETERMINED, WHICH_OFFSET
from ams.calibration_result import (
    METHOD_VERSION,
    AxisCalibration,
    Calibration,
    PackageCovariance,
    ParameterEstimate,
)
from ams.errors import DesignError
from ams.findings import Finding, significant_texts
from ams.frames import AXES
from ams.inputs.csv_table import PLAIN, CsvForm, parse_csv, refuse_cell, refuse_missing_columns
from ams.inputs.observations_csv import read_csv
from ams.inputs.request import select_rows
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll
from ams.parameter_words import not_determined
from ams.solve.derived import halfwidths_95
from ams.solve.joint import JointFit, Nuisance
from ams.solve.joint_sensor import JointSensor
from ams.solve.table_errors import REVERSED, SEAT, UPRIGHT, WHOLE_TABLE, Mounting
from ams.statistics.intervals import combined_dof, t_quantile
from ams.units import RAD_PER_ARCSEC, dof_words

MOUNTS: Final = {"upright": UPRIGHT, "reversed": REVERSED}


def read_mountings(
    path: str | Path, axes: Mapping[str, str], mount_column: str | None, form: CsvForm = PLAIN
) -> list[Mounting]:
    """Return one mounting, or one for each word of the mount column, in the order of their first rows.

    Raises: ObservationsError as :func:`ams.inputs.observations_csv.read_csv`, and for a mount that is none.
    """
    observations = read_csv(path, axes, form=form)
    if mount_column is None:
        return [Mounting(observations)]
    table = parse_csv(Path(path), form)
    refuse_missing_columns(table, (mount_column,))
    words = table.column(mount_column)
    for line, word in zip(table.lines, words, strict=True):
        if word not in MOUNTS:
            refuse_cell(table, mount_column, line, word, " or ".join(MOUNTS))
    named = np.array(words)
    return [Mounting(select_rows(observations, named == word), MOUNTS[word]) for word in dict.fromkeys(words)]


def joint_document(fit: JointFit, solved: Calibration, budgets: Mapping[str, AxisBudget]) -> Document:
    """Return ``{"axes": …, "nuisances": …, "confounded": […]}``, axes and verdict in the shape of any fit.

    ``solved``: what :func:`joint_calibration` made of the fit, with what its caller says beside. Angles of the table
    are in arc seconds.
    """
    return {
        "axes": {
            label: {**_axis(axis), "budget": budget_document(budgets[label])} for label, axis in solved.axes.items()
        },
        "verdict": solved.verdict,
        "warnings": list(solved.warnings),
        "remarks": list(solved.remarks),
        "nuisances": {nuisance.name: _nuisance(nuisance) for nuisance in fit.nuisances},
        "confounded": list(fit.confounded),
        "method_version": METHOD_VERSION,
        "package_covariance": _package(fit) if len(fit.axes) > 1 else None,
    }


def _package(fit: JointFit) -> Document:
    """Return the covariance of all axes' primary parameters together, as the table's errors that were left tie them."""
    return {
        "order": [list(entry) for entry in _order(fit)],
        "covariance": [[float(cell) if np.isfinite(cell) else None for cell in row] for row in fit.covariance],
    }


def _order(fit: JointFit) -> tuple[tuple[str, str], ...]:
    return tuple((axis, name) for axis in fit.axes for name in fit.sensors[axis].model.primary_names)


def joint_calibration(
    fit: JointFit, diagnosis: JointDiagnosis, doubts: Sequence[str] = (), remarks: Sequence[str] = ()
) -> Calibration:
    """Return the package of a joint fit as a coefficient set takes it, the table's errors in its covariance.

    ``doubts``: what the caller warns of beside, for every axis; ``remarks``: what it says beside. Raises: DesignError
    where a sensitivity is not determined.
    """
    solved = {axis: joint_axis(fit, axis, diagnosis.findings[axis]) for axis in fit.axes}
    axes = {axis: replace(found, warnings=(*found.warnings, *doubts)) for axis, found in solved.items()}
    warnings = dict.fromkeys(sentence for axis in axes.values() for sentence in axis.warnings)
    package = PackageCovariance(_order(fit), fit.components) if len(fit.axes) > 1 else None
    said = (*diagnosis.untested, *contained(fit), *remarks)
    return Calibration(axes, PitchRoll.name, PitchRoll.convention, tuple(warnings), said, package)


def joint_axis(fit: JointFit, axis: str, findings: tuple[Finding, ...]) -> AxisCalibration:
    """Return one axis of a joint fit. Raises: DesignError where a sensitivity is not determined."""
    model, primary = fit.sensors[axis].model, fit.primary[axis]
    lost = [name for name, value in zip(model.primary_names, primary, strict=True) if not np.isfinite(value)]
    if lost:
        raise DesignError(
            f"joint fit: axis {axis}: the points cannot determine {' and '.join(lost)}; nothing is reported; "
            "add attitudes at other pitch and roll angles"
        )
    axis_covariance = fit.axis_covariance(axis)
    undetermined = model.undetermined(primary, axis_covariance)
    directions = model.parameters_jacobian(primary)
    directions[[name in undetermined for name in model.parameter_names]] = np.nan
    parts = fit.axis_components(axis)
    spreads = np.stack([directions @ part.covariance @ directions.T for part in parts])
    covariance = spreads.sum(axis=0)
    part_dofs = np.array([part.dof for part in parts])[:, None]
    dof = combined_dof(np.diagonal(spreads, axis1=1, axis2=2), part_dofs)
    uncertainty = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    halves = halfwidths_95(model.parameter_names, t_quantile(0.95, dof) * uncertainty)
    columns = zip(
        model.parameter_names, *(column.tolist() for column in (model.parameters(primary), uncertainty, dof, halves)),
        strict=True,
    )  # fmt: skip
    nothing, none = np.empty(0), np.full_like(axis_covariance, np.nan)
    return AxisCalibration(
        axis=axis,
        model=model.name,
        nominal_axis=axis,
        parameters=tuple(_parameter(name in undetermined, name, *numbers) for name, *numbers in columns),
        covariance=covariance,
        primary_names=model.primary_names,
        primary=primary,
        primary_covariance=axis_covariance,
        tp_primary_covariance=none,
        primary_dof=combined_dof(np.stack([np.diag(part.covariance) for part in parts]), part_dofs),
        standard_error_v=fit.standard_error_v[axis],
        degrees_of_freedom=fit.degrees_of_freedom // len(fit.axes),
        sensitive_axis_v_per_g=(float(primary[1]), float(primary[2]), float(primary[3])),
        fitted_v=nothing,
        residuals_v=nothing,
        replication=None,
        warnings=(
            *joint_warnings(fit),
            *(f"axis {axis}: {not_determined([name])}: {reason}" for name, reason in undetermined.items()),
            *significant_texts(findings),
        ),
        findings=findings,
        remarks=_of_the_terms(fit.sensors[axis]),
        variance_components=parts,
        centring=model.centring if isinstance(model, ExtendedPitchRoll) else (),
    )


def _of_the_terms(sensor: JointSensor) -> tuple[str, ...]:
    """Return which offset stands beside terms of second order, or that the points determine none, as any fit does."""
    if sensor.centring:
        return (WHICH_OFFSET,)
    return (NOT_DETERMINED,) if sensor.is_blind else ()


def _parameter(
    is_null: bool, name: str, value: float, uncertainty: float, dof: float, half: float
) -> ParameterEstimate:
    if is_null:
        return ParameterEstimate(name, None, uncertainty, None, dof, None)
    return ParameterEstimate(name, value, uncertainty, None, dof, (value - half, value + half))


def _axis(found: AxisCalibration) -> Document:
    return {
        "parameters": {
            parameter.name: {
                "value": number(parameter.value),
                "standard_uncertainty": number(parameter.standard_uncertainty),
                "tp_standard_uncertainty": None,
                "interval_95": None
                if parameter.interval_95 is None
                else [number(end) for end in parameter.interval_95],
            }
            for parameter in found.parameters
        },
        "covariance": [[number(cell) for cell in row] for row in found.covariance.tolist()],
        "standard_error_v": number(found.standard_error_v),
        "degrees_of_freedom": found.degrees_of_freedom,
        "effective_degrees_of_freedom": {
            parameter.name: degrees_of_freedom(parameter.effective_degrees_of_freedom) for parameter in found.parameters
        },
        "sensitive_axis_v_per_g": dict(zip(AXES, map(number, found.sensitive_axis_v_per_g), strict=True)),
        "replication": None,
        "warnings": list(found.warnings),
        "remarks": list(found.remarks),
        "findings": findings_document(found),
    }


def joint_warnings(fit: JointFit) -> Iterator[str]:
    """Return what stands behind the intervals of every axis."""
    if fit.replication_dof == 0:
        yield "one replication only: precision, lack of fit and drift cannot be told apart; measure two or more"
    elif fit.replication_dof < 3:
        yield (
            f"intervals rest on {dof_words(fit.replication_dof)} between replications and are wide; four "
            "replications or more make them much narrower"
        )
    yield from (sentence for sentence in fit.confounded if _is_whole(sentence))


def contained(fit: JointFit) -> tuple[str, ...]:
    """Return what is not told of the index errors: it stays as uncertain as it was declared, no reservation."""
    return tuple(sentence for sentence in fit.confounded if not _is_whole(sentence))


def _is_whole(sentence: str) -> bool:
    """Return whether a sentence on what the rows cannot tell names an error of the whole table or of a seat."""
    return any(name in sentence for name in (*WHOLE_TABLE, SEAT))


def _nuisance(nuisance: Nuisance) -> Document:
    return {
        "estimate_arcsec": nuisance.estimate_rad / RAD_PER_ARCSEC,
        "standard_deviation_arcsec": nuisance.standard_deviation_rad / RAD_PER_ARCSEC,
        "prior_arcsec": nuisance.prior_rad / RAD_PER_ARCSEC,
        "is_observed": nuisance.is_observed,
    }
