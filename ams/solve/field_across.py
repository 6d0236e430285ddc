"""What stands across a coil, by all axes of a magnetometer together: Gauss-Newton over every axis and the field.

y_j = o_j + M_j·T·(c·(a + β_j) + P·b): T from level into package axes, a the coil's field along c, β_j what stands along
it as this axis alone has it, b what stands across, common to all. With b given, each axis by itself is linear and finds
the same o_j, M_j, β_j; b is uncorrelated with the noise in them (what is left of a regression is orthogonal to it), so
that its error enters them as one more error of their known levels. Source: MATH 10.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.frames import AXES

LARGEST_CONDITION = 300.0
"""Of the Jacobian with columns of length one; six positions have some tens, an undetermined direction infinite."""
_STEPS, _PER_AXIS = 30, 5
"""Own: parameters of one axis: o, M (3), β."""
_WEIGHED = 4
"""Steps until the weights are taken from the residuals: each squares what a leaning axis leaves of the field across."""
_CONVERGED = 1e-11


@dataclass(frozen=True)
class FieldAcross:
    """The solution of all axes."""

    across: FloatArray
    """(3,) level axes."""
    along: Mapping[str, float]
    """What stands along the coil, by each axis."""
    matrix: Mapping[str, FloatArray]
    """(3,) M_j by each axis, package axes."""
    gain: Mapping[str, FloatArray]
    """(3, N) what an error of every reading of each axis does to ``across``."""
    noise: FloatArray
    """(3, q) columns of the standard uncertainty of ``across`` by the scatter of the readings."""


def field_across(
    to_package: FloatArray,
    coil: FloatArray,
    applied: FloatArray,
    readings: Mapping[str, FloatArray],
    believed: Mapping[str, float] | None = None,
) -> FieldAcross | None:
    """Return the solution; None where the attitudes do not determine it, or a reading follows no field.

    ``believed``: the scatter of every axis' readings, for rows that are planned and have none; None: as they show it.
    """
    basis = np.linalg.svd(coil[None, :])[2][1:].T
    labels = list(readings)
    y = np.stack([readings[label] for label in labels])
    if not np.isfinite(y).all() or y.shape[1] <= _PER_AXIS + 2:
        return None
    theta, slopes = _start(to_package, coil, applied, readings)
    # Every axis in units of the field, so that a gain makes none of them count for more.
    weight = 1.0 / slopes
    for step in range(_STEPS):
        fitted, jacobian = _linear(to_package, coil, basis, applied, labels, theta)
        residual = y - fitted
        if believed is None:
            scatter = np.sqrt((residual**2).sum(axis=1) / (y.shape[1] - _PER_AXIS - 2.0 / len(labels)))
        else:
            scatter = np.array([believed[label] for label in labels])
        # Once, as soon as what is left is noise: every later step then lowers one and the same sum of squares.
        if step == _WEIGHED:
            if not (scatter > 0.0).all():
                return None
            weight = 1.0 / scatter
        weighted = (jacobian * weight[:, None, None]).reshape(-1, theta.size)
        lengths = np.linalg.norm(weighted, axis=0)
        if not (np.isfinite(lengths).all() and (lengths > 0.0).all()):
            return None
        scaled = weighted / lengths
        if np.linalg.cond(scaled) > LARGEST_CONDITION:
            return None
        inverse = np.linalg.pinv(scaled)
        change = inverse @ (residual * weight[:, None]).ravel()
        theta = theta + change / lengths
        if step > _WEIGHED and np.linalg.norm(change) <= _CONVERGED * np.linalg.norm(theta * lengths):
            break
    else:
        return None
    of_b = (basis @ (inverse[-2:] / lengths[-2:, None])).reshape(3, len(labels), -1) * weight[:, None]
    by_axis = theta[:-2].reshape(-1, _PER_AXIS)
    spread = [of_b[:, index] * scatter[index] for index in range(len(labels))]
    covariance = basis.T @ np.sum([part @ part.T for part in spread], axis=0) @ basis
    return FieldAcross(
        basis @ theta[-2:],
        {label: float(row[4]) for label, row in zip(labels, by_axis, strict=True)},
        {label: row[1:4] for label, row in zip(labels, by_axis, strict=True)},
        {label: of_b[:, index] for index, label in enumerate(labels)},
        basis @ np.linalg.cholesky(covariance),
    )


def _start(
    to_package: FloatArray, coil: FloatArray, applied: FloatArray, readings: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Take every axis as lying along its nominal direction and nothing as standing across; return the slopes beside it.

    One axis by itself tells of the field across no more than its own attitudes show, and in a direction that it is
    never laid along nothing but the servos' last tenth of a degree: only all axes together start from there.
    """
    found, slopes = [], []
    for label, reading in readings.items():
        diagonal = AXES.index(label)
        along = to_package[:, diagonal] @ coil
        columns = np.column_stack([np.ones_like(applied), along * applied, along])
        zero, slope, beside = np.linalg.lstsq(columns, reading, rcond=None)[0]
        slope = slope or 1.0
        found.append([zero, *(slope * np.eye(3)[diagonal]), beside / slope])
        slopes.append(abs(slope))
    return np.concatenate([*found, np.zeros(2)]), np.array(slopes)


def _linear(
    to_package: FloatArray,
    coil: FloatArray,
    basis: FloatArray,
    applied: FloatArray,
    labels: list[str],
    theta: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return (J, N) what the parameters predict, and (J, N, P) its derivatives."""
    by_axis, b = theta[:-2].reshape(-1, _PER_AXIS), theta[-2:]
    along, across = to_package @ coil, to_package @ basis
    fitted = np.zeros((len(labels), applied.size))
    jacobian = np.zeros((len(labels), applied.size, theta.size))
    for index, (zero, *m, beside) in enumerate(by_axis):
        field = along * (applied + beside)[:, None] + across @ b
        fitted[index] = zero + field @ np.array(m)
        columns = [np.ones_like(applied), *field.T, along @ np.array(m)]
        jacobian[index, :, index * _PER_AXIS : (index + 1) * _PER_AXIS] = np.stack(columns, axis=-1)
        jacobian[index, :, -2:] = np.einsum("nkb,k->nb", across, np.array(m))
    return fitted, jacobian
