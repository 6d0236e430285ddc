"""The joint fit of package and table from a file of one or two mountings, and its JSON document.

The file's angles are the table's. A column of mounts says ``upright`` or ``reversed`` (half round on its seat) for
every row; replications are numbered on from one mount to the next, so that every (replication, point) stands once.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from ams.calibration.document import Document, degrees_of_freedom, number
from ams.calibration_result import METHOD_VERSION
from ams.errors import DesignError
from ams.frames import AXES
from ams.inputs.csv_table import parse_csv, refuse_cell, refuse_missing_columns
from ams.inputs.observations_csv import read_csv
from ams.inputs.request import select_rows
from ams.models.accelerometer import PitchRoll
from ams.solve.derived import halfwidths_95
from ams.solve.joint import JointFit, Nuisance
from ams.solve.table_errors import REVERSED, UPRIGHT, Mounting
from ams.statistics.intervals import combined_dof, t_quantile
from ams.units import RAD_PER_ARCSEC

_LINEAR: Final = (
    "the joint fit has no terms of second and third order: a soft mount of the sensor is not in the uncertainty; fit "
    "without --joint for them"
)
MOUNTS: Final = {"upright": UPRIGHT, "reversed": REVERSED}


def read_mountings(path: str | Path, axes: Mapping[str, str], mount_column: str | None) -> list[Mounting]:
    """Return one mounting, or one for each word of the mount column, in the order of their first rows.

    Raises: ObservationsError as :func:`ams.inputs.observations_csv.read_csv`, and for a mount that is none.
    """
    observations = read_csv(path, axes)
    if mount_column is None:
        return [Mounting(observations)]
    table = parse_csv(Path(path))
    refuse_missing_columns(table, (mount_column,))
    words = table.column(mount_column)
    for line, word in zip(table.lines, words, strict=True):
        if word not in MOUNTS:
            refuse_cell(table, mount_column, line, word, " or ".join(MOUNTS))
    named = np.array(words)
    return [Mounting(select_rows(observations, named == word), MOUNTS[word]) for word in dict.fromkeys(words)]


def joint_document(fit: JointFit) -> Document:
    """Return ``{"axes": …, "nuisances": …, "confounded": […]}``, the axes in the shape of any fit.

    Angles of the table are in arc seconds.
    """
    return {
        "axes": {axis: _axis(fit, axis) for axis in fit.axes},
        "nuisances": {nuisance.name: _nuisance(nuisance) for nuisance in fit.nuisances},
        "confounded": list(fit.confounded),
        "method_version": METHOD_VERSION,
        "package_covariance": _package(fit) if len(fit.axes) > 1 else None,
    }


def _package(fit: JointFit) -> Document:
    """Return the covariance of all axes' primary parameters together, as the table's errors that were left tie them."""
    return {
        "order": [[axis, name] for axis in fit.axes for name in PitchRoll.primary_names],
        "covariance": [[float(cell) if np.isfinite(cell) else None for cell in row] for row in fit.covariance],
    }


def _axis(fit: JointFit, axis: str) -> Document:
    model, primary = PitchRoll(axis), fit.primary[axis]
    if not np.isfinite(primary).all():
        raise DesignError(
            f"joint fit: axis {axis}: no attitude excites all of its sensitivities; nothing is reported; "
            "add roll angles other than 0° and 180°"
        )
    undetermined = model.undetermined(primary, fit.axis_covariance(axis))
    directions = model.parameters_jacobian(primary)
    directions[[name in undetermined for name in model.parameter_names]] = np.nan
    parts = fit.axis_components(axis)
    spreads = np.stack([directions @ part.covariance @ directions.T for part in parts])
    covariance = spreads.sum(axis=0)
    variances = np.diagonal(spreads, axis1=1, axis2=2)
    dof = combined_dof(variances, np.array([part.dof for part in parts])[:, None])
    uncertainty = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    halves = halfwidths_95(model.parameter_names, t_quantile(0.95, dof) * uncertainty)
    columns = zip(model.parameters(primary).tolist(), uncertainty.tolist(), halves.tolist(), strict=True)
    return {
        "parameters": {
            name: _parameter(name in undetermined, *numbers)
            for name, numbers in zip(model.parameter_names, columns, strict=True)
        },
        "covariance": [[number(cell) for cell in row] for row in covariance.tolist()],
        "standard_error_v": fit.standard_error_v[axis],
        "degrees_of_freedom": fit.degrees_of_freedom // len(fit.axes),
        "effective_degrees_of_freedom": {
            name: degrees_of_freedom(own) for name, own in zip(model.parameter_names, dof.tolist(), strict=True)
        },
        "sensitive_axis_v_per_g": dict(zip(AXES, map(float, primary[1:]), strict=True)),
        "replication": None,
        "warnings": [
            *_warnings(fit),
            *(f"axis {axis}: {name} null: {reason}" for name, reason in undetermined.items()),
        ],
        "remarks": [f"axis {axis}: {_LINEAR}"],
    }


def _warnings(fit: JointFit) -> Iterator[str]:
    """Return what stands behind the intervals of every axis."""
    if fit.replication_dof == 0:
        yield "one replication only: precision, lack of fit and drift cannot be told apart; measure two or more"
    elif fit.replication_dof < 3:
        yield (
            f"intervals rest on {fit.replication_dof} degrees of freedom between replications and are wide; four "
            "replications or more make them much narrower"
        )
    yield from fit.confounded


def _parameter(is_null: bool, value: float, uncertainty: float, half: float) -> Document:
    return {
        "value": None if is_null else value,
        "standard_uncertainty": None if is_null else uncertainty,
        "tp_standard_uncertainty": None,
        "interval_95": None if is_null else [value - half, value + half],
    }


def _nuisance(nuisance: Nuisance) -> Document:
    return {
        "estimate_arcsec": nuisance.estimate_rad / RAD_PER_ARCSEC,
        "standard_deviation_arcsec": nuisance.standard_deviation_rad / RAD_PER_ARCSEC,
        "prior_arcsec": nuisance.prior_rad / RAD_PER_ARCSEC,
        "is_observed": nuisance.is_observed,
    }
