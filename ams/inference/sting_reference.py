"""Second step of CR: the model package calibrated against the sting package instead of against the table's angles.

The sting's outputs give gravity in sting axes, roll turns it into model axes; so a tunnel that knows only its roll can
calibrate the model package. Pitch and yaw stand for that direction of gravity; at level, where yaw has no meaning, any
yaw does.

The sting's set tells gravity wrong by what its coefficients are wrong by: one draw of them turns the gravity of all
rows, each by what the derivative there makes of it. Those are columns of errors that all rows share, as those of a
certificate are: g = -K⁻¹(v - b), so that K δg = J δp, J the derivatives of the outputs by the coefficients p, and of
δg what lies across g. What n replications scatter is n - 1 directions of the coefficients of a package, which have many
more: columns of these alone would say that gravity is exact in all others. So the set's covariance is taken as no less
than that of noise alone, TP (50), in any direction. The noise of the sting's own readings is another in every row, and
stands in the scatter of the model package. Source: CR IV-A; GUM F.1.2.3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.two_package import angles_from_gravity
from ams.calibration_result import VarianceComponent
from ams.errors import OutsideValidity
from ams.inference.inference import Package
from ams.inference.package.calibrated import CalibratedPackage, as_package, covariance_root, noise_of_set
from ams.inputs.csv_table import PLAIN, CsvForm
from ams.inputs.observations_csv import read_csv
from ams.inputs.shared_errors import STING_CALIBRATION, SharedError
from ams.models.cr import model_gravity_g
from ams.observations import Observations
from ams.statistics.intervals import combined_dof
from ams.statistics.short_of import short_of

WARNING = (
    "gravity is that of the sting package: what its set leaves uncertain is in these uncertainties, as "
    f"{STING_CALIBRATION}; angles by both sets count the two as independent, though they share it"
)


def read_with_sting(
    path: str | Path, axes: Mapping[str, str], sting: Package, form: CsvForm = PLAIN
) -> tuple[Observations, SharedError]:
    """Read observations whose pitch and yaw come from the sting's columns, with the error that they share.

    The file states roll.

    Raises: ObservationsError as :func:`ams.inputs.observations_csv.read_csv`; OutsideValidity where the set is no
    sting's.
    """
    if not sting.is_of_sting or len(sting.columns) != 3:
        raise OutsideValidity(
            f"{sting.coefficients.sensor}: got model {sting.model} with {len(sting.columns)} axes, needed "
            "pitch-yaw-roll-sting with three; nothing was solved; give the set of the sting package"
        )
    named = {f"sting {axis}": column for axis, column in sting.columns.items()}
    rows = read_csv(path, {**axes, **named}, ("roll",), form=form)
    readings = {column: rows.outputs[f"sting {axis}"] for axis, column in sting.columns.items()}
    if rows.temperature_degc is not None:
        readings["temperature_degc"] = rows.temperature_degc
    sensors = sting.sensors(readings, None)
    k = np.stack([sensor.k_v_per_g for sensor in sensors])
    volts = sting.outputs_v(sensors, readings) - np.array([sensor.offset_v for sensor in sensors])
    gravity = -np.linalg.solve(k, volts.T).T
    package, noise = (
        as_package(sensors, sting.together(sensors)),
        noise_of_set(sting.coefficients, tuple(sting.columns)),
    )
    errors_rad, dof = _errors_of(replace(package, components=_no_less_than(noise, package.components)), gravity)
    rows = replace(
        _along(gravity, rows),
        outputs={axis: rows.outputs[axis] for axis in axes},
        gravity_errors_rad=np.swapaxes(model_gravity_g(np.swapaxes(errors_rad, 1, 2), rows.roll_rad[:, None]), 1, 2),
    )
    stated = f"set of {sting.coefficients.sensor}"
    return rows, SharedError(STING_CALIBRATION, "gravity-direction", 1.0, stated=stated, degrees_of_freedom=dof)


def _along(gravity: FloatArray, rows: Observations) -> Observations:
    """Return rows at the pitch and yaw that stand for (N, 3) gravity in sting axes."""
    angles = angles_from_gravity(gravity, gravity)
    yaw = np.where(np.isnan(angles.yaw_rad), 0.0, angles.yaw_rad)
    size = np.arctan2(np.hypot(gravity[:, 0], gravity[:, 1]), gravity[:, 2])
    sideways = np.isnan(angles.pitch_rad)
    return replace(
        rows,
        pitch_rad=np.where(sideways, size, angles.pitch_rad),
        yaw_rad=np.where(sideways, np.sign(gravity[:, 1]) * 0.5 * np.pi, yaw),
    )


def _no_less_than(noise: VarianceComponent, parts: Sequence[VarianceComponent]) -> tuple[VarianceComponent, ...]:
    """Return (Q, Q) parts with one more, by which they are as much as noise in every direction that noise has."""
    free = np.flatnonzero(noise.covariance.diagonal() > 0.0)
    if free.size == 0:
        return tuple(parts)
    block = np.ix_(free, free)
    root = np.asarray(np.linalg.cholesky(noise.covariance[block]))
    added = np.zeros_like(noise.covariance)
    added[block] = short_of(np.asarray(sum(part.covariance for part in parts))[block], root, np.ones(()))
    return (*parts, replace(noise, covariance=added))


def _errors_of(package: CalibratedPackage, gravity: FloatArray) -> tuple[FloatArray, float]:
    """Return (N, 3, q) what the calibration of a package turns its (N, 3) gravity by, with its degrees of freedom.

    In sting axes, one standard uncertainty of each of q independent errors, radians. The degrees of freedom are those
    of the mean variance over the rows: Welch-Satterthwaite of the parts of the covariance.
    """
    size = np.linalg.norm(gravity, axis=1)[:, None]
    along = gravity / size
    across = (np.eye(3) - along[:, :, None] * along[:, None, :]) / size[:, :, None]
    k = np.stack([sensor.k_v_per_g for sensor in package.sensors])
    turned = across @ np.linalg.solve(k, package.rows(-gravity))
    variances = np.array([_mean_square(turned, part) for part in package.components])
    dof = float(combined_dof(variances, np.array([part.dof for part in package.components])))
    whole = np.asarray(sum(part.covariance for part in package.components))
    return turned @ covariance_root(whole), dof if np.isfinite(dof) else np.inf


def _mean_square(turned: FloatArray, part: VarianceComponent) -> float:
    """Return the mean over the rows of the variance that a part leaves, radians²; ``turned`` (N, 3, Q)."""
    return float(np.einsum("niq,qr,nir->", turned, part.covariance, turned, optimize=True) / len(turned))
