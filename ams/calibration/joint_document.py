"""The joint fit of package and table from a file of one or two mountings, and its JSON document.

The file's angles are the table's. A column of mounts says ``upright`` or ``reversed`` (half round on its seat) for
every row; replications are numbered on from one mount to the next, so that every (replication, point) stands once.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.calibration.document import Document
from ams.calibration_result import METHOD_VERSION
from ams.errors import DesignError
from ams.frames import AXES, RAD_PER_ARCSEC
from ams.inputs.csv_table import parse_csv, refuse_cell, refuse_missing_columns
from ams.inputs.observations_csv import read_csv
from ams.inputs.request import select_rows
from ams.models.accelerometer import PitchRoll
from ams.solve.joint import JointFit, Nuisance
from ams.solve.table_errors import REVERSED, UPRIGHT, Mounting

FloatArray = NDArray[np.float64]

MOUNTS: Final = {"upright": UPRIGHT, "reversed": REVERSED}


def read_mountings(path: str | Path, axes: Mapping[str, str], mount_column: str | None) -> list[Mounting]:
    """One mounting, or one for each word of the mount column, in the order of their first rows.

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
    """``{"axes": …, "nuisances": …, "confounded": […]}``, the axes in the shape of any fit; angles of the table in
    arc seconds."""
    return {
        "axes": {axis: _axis(fit, axis) for axis in fit.axes},
        "nuisances": {nuisance.name: _nuisance(nuisance) for nuisance in fit.nuisances},
        "confounded": list(fit.confounded),
        "method_version": METHOD_VERSION,
        "package_covariance": _package(fit) if len(fit.axes) > 1 else None,
    }


def _package(fit: JointFit) -> Document:
    """All axes' primary parameters together, as the table's errors that were left tie them to each other."""
    return {
        "order": [[axis, name] for axis in fit.axes for name in PitchRoll.primary_names],
        "covariance": [[float(cell) if np.isfinite(cell) else None for cell in row] for row in fit.covariance],
    }


def _axis(fit: JointFit, axis: str) -> Document:
    model, primary, spread = PitchRoll(axis), fit.primary[axis], fit.axis_covariance(axis)
    if not np.isfinite(primary).all():
        raise DesignError(
            f"joint fit: axis {axis}: no attitude excites all of its sensitivities; nothing is reported; "
            "add roll angles other than 0° and 180°"
        )
    undetermined = model.undetermined(primary, spread)
    directions = model.parameters_jacobian(primary)
    directions[[name in undetermined for name in model.parameter_names]] = np.nan
    covariance = directions @ spread @ directions.T
    values = zip(model.parameter_names, model.parameters(primary), np.diag(covariance), strict=True)
    return {
        "parameters": {name: _parameter(name in undetermined, float(v), float(c)) for name, v, c in values},
        "covariance": [[float(cell) if np.isfinite(cell) else None for cell in row] for row in covariance],
        "standard_error_v": fit.standard_error_v[axis],
        "degrees_of_freedom": None,
        "effective_degrees_of_freedom": dict.fromkeys(model.parameter_names),
        "sensitive_axis_v_per_g": dict(zip(AXES, map(float, primary[1:]), strict=True)),
        "replication": None,
        "warnings": [f"axis {axis}: {name} null: {reason}" for name, reason in undetermined.items()],
    }


def _parameter(is_null: bool, value: float, variance: float) -> Document:
    return {
        "value": None if is_null else value,
        "standard_uncertainty": None if is_null else float(np.sqrt(max(variance, 0.0))),
        "tp_standard_uncertainty": None,
    }


def _nuisance(nuisance: Nuisance) -> Document:
    return {
        "estimate_arcsec": nuisance.estimate_rad / RAD_PER_ARCSEC,
        "standard_deviation_arcsec": nuisance.standard_deviation_rad / RAD_PER_ARCSEC,
        "prior_arcsec": nuisance.prior_rad / RAD_PER_ARCSEC,
        "is_observed": nuisance.is_observed,
    }
