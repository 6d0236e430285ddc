"""What belongs to the sensor and what to its mounting: a package's coefficients in terms that a remount leaves alone.

A package that is taken off the table and put back sits turned by a small rotation, the same for all its axes, and every
coning angle and azimuth changes with it. What stays is the package's own: each axis' offset and sensitivity, and the
angles between its axes. So the 4 A coefficients of A axes are read as A offsets, A sensitivities, A(A − 1)/2 angles
between axes, and the rotation against a reference (three components; two of a single axis, whose twist does not show).

Rotation: u_i = exp([θ]×) u_i,ref in the least-squares sense, by Gauss-Newton from zero with a pseudo-inverse, so that
what one axis cannot tell stays zero. Everything is vectorised over calibrations: arrays are (n, A, …).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ams.arrays import FloatArray
from ams.inputs.shared_errors import BETWEEN_RATES, G_SENSITIVITY, NONLINEARITY, SHIFTS
from ams.models.sensor_model import SetForm
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.coefficients import CoefficientSet

REPEATED = ("table", "lack-of-fit", "temperature", *SHIFTS, NONLINEARITY, BETWEEN_RATES, G_SENSITIVITY)
"""Parts of the covariance that the next run on the same table repeats, or that are of the time between them and looked
for there: they do not scatter between runs."""
_COLUMNS = 4


@dataclass(frozen=True)
class PackageNumbers:
    """b and k of n calibrations of packages with the same axes."""

    axes: tuple[str, ...]
    """Nominal axes."""
    primary: FloatArray
    """(n, A, 4): offset and k per unit of the field."""
    covariance: FloatArray
    """(n, A, 4, 4)"""
    scatter: FloatArray
    """(n, A, 4, 4) the part of the covariance that is drawn anew in every run."""
    sensitivity_name: str = "sensitivity_v_per_g"

    @property
    def measured_unit(self) -> str:
        """Of the outputs, such as ``v``."""
        return self.sensitivity_name.removeprefix("sensitivity_").partition("_per_")[0]

    @property
    def unit(self) -> str:
        """Of what is sensed, such as ``g``."""
        return self.sensitivity_name.partition("_per_")[2]

    @property
    def k(self) -> FloatArray:
        return self.primary[..., 1:]

    @property
    def sensitivity(self) -> FloatArray:
        """(n, A) |k|, signed by the nominal direction."""
        nominal = np.stack([self.k[:, index, "xyz".index(axis)] for index, axis in enumerate(self.axes)], axis=1)
        return np.asarray(np.where(nominal < 0.0, -1.0, 1.0) * np.linalg.norm(self.k, axis=-1))

    @property
    def directions(self) -> FloatArray:
        """(n, A, 3) unit vectors of the sensitive axes, polarity taken off."""
        return np.asarray(self.k / self.sensitivity[..., None])


@dataclass(frozen=True)
class Characteristics:
    """The sensor's own, n calibrations by p quantities."""

    names: tuple[str, ...]
    """``offset_v.x``, ``sensitivity_v_per_g.x``, ``angle_deg.xy`` …"""
    value: FloatArray
    """(n, p)"""
    standard_uncertainty: FloatArray
    """(n, p) of the whole calibration."""
    scatter: FloatArray
    """(n, p) the part of it that is drawn anew in every run."""
    scale: FloatArray
    """(n, p) what a change is divided by to become a small angle in radians: |S| for offset and sensitivity."""


def numbers_of(coefficients: CoefficientSet) -> PackageNumbers:
    """Return the primary parameters of one set, n = 1; a component that the model lacks is zero and exact."""
    axes = table(coefficients.document["axes"])
    rows = [_axis_rows(table(section), coefficients.axes[name].form) for name, section in axes.items()]
    primary, covariance, scatter = (np.stack(part)[None] for part in zip(*rows, strict=True))
    first, *_ = coefficients.axes.values()
    nominal = tuple(axis.nominal_axis for axis in coefficients.axes.values())
    return PackageNumbers(nominal, primary, covariance, scatter, first.form.sensitivity)


def characteristics_of(numbers: PackageNumbers) -> Characteristics:
    """Return the offsets, sensitivities and angles between axes, with their standard uncertainties."""
    axes, size = numbers.axes, np.abs(numbers.sensitivity)
    units, n = numbers.directions, numbers.primary.shape[0]
    offset_name = f"offset_{numbers.measured_unit}"
    names = [*(f"{offset_name}.{axis}" for axis in axes), *(f"{numbers.sensitivity_name}.{axis}" for axis in axes)]
    values = [numbers.primary[..., 0], numbers.sensitivity]
    scales = [size, size]
    # A line along its nominal axis knows nothing across it: the angle between two of them was not calibrated.
    tells_direction = np.count_nonzero(numbers.k, axis=-1).max(axis=0) > 1
    pairs = [(a, b) for a, b in combinations(range(len(axes)), 2) if tells_direction[a] and tells_direction[b]]
    if pairs:
        names += [f"angle_deg.{axes[a]}{axes[b]}" for a, b in pairs]
        values.append(np.stack([_angle_deg(units[:, a], units[:, b]) for a, b in pairs], axis=1))
        scales.append(np.full((n, len(pairs)), np.degrees(1.0)))
    whole, scatter = (_uncertainties(numbers, part, pairs) for part in (numbers.covariance, numbers.scatter))
    return Characteristics(tuple(names), np.concatenate(values, axis=1), whole, scatter, np.concatenate(scales, axis=1))


def rotations_rad(directions: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the (n, 3) rotation vector that turns the (A, 3) reference onto each of (n, A, 3) directions."""
    total = np.broadcast_to(np.eye(3), (directions.shape[0], 3, 3))
    for _ in range(6):
        turned = np.einsum("nij,aj->nai", total, reference)
        design = -cross_matrices(turned)
        residual = (directions - turned).reshape(directions.shape[0], -1)
        inverse = np.linalg.pinv(design.reshape(design.shape[0], -1, 3), rcond=1e-6)
        step = np.einsum("nsm,nm->ns", inverse, residual)
        total = _exponential(step) @ total
        if np.all(np.abs(step) < 1e-15):
            break
    return _logarithm(total)


def cross_matrices(vectors: FloatArray) -> FloatArray:
    """Return (…, 3, 3) with [v]× w = v × w."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([np.stack(row, axis=-1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], axis=-2)


def placed_rows(section: Document, form: SetForm) -> FloatArray:
    """Return (4,) b and k of an axis' section; a component that the model lacks is zero."""
    values = table(table(section["primary"])["values"])
    return np.array([number(values[name]) if name in values else 0.0 for name in (form.offset, *form.directions)])


def scatter_rows(section: Document, form: SetForm) -> list[tuple[str, FloatArray, float]]:
    """Return the parts that every run draws anew: name, (4, 4) covariance of b and k, and degrees of freedom."""
    primary, pairs = table(section["primary"]), _pairs(section, form)
    components = {name: table(part) for name, part in table(primary["components"]).items() if name not in REPEATED}
    return [
        (name, _placed(part["covariance"], pairs), _dof(part["degrees_of_freedom"]))
        for name, part in components.items()
    ]


def _dof(stated: Json) -> float:
    """Return degrees of freedom; null is of a certificate."""
    return np.inf if stated is None else number(stated)


def _pairs(section: Document, form: SetForm) -> list[tuple[int, int]]:
    """Return where b and k stand among four, and in the order of the set."""
    order = [str(name) for name in listed(table(section["primary"])["order"])]
    return [(index, order.index(name)) for index, name in enumerate((form.offset, *form.directions)) if name in order]


def _axis_rows(section: Document, form: SetForm) -> tuple[FloatArray, FloatArray, FloatArray]:
    primary, pairs = table(section["primary"]), _pairs(section, form)
    whole = _placed(primary["covariance"], pairs)
    repeated = sum(
        (
            _placed(table(component)["covariance"], pairs)
            for name, component in table(primary["components"]).items()
            if name in REPEATED
        ),
        np.zeros_like(whole),
    )
    return placed_rows(section, form), whole, whole - repeated


def _placed(matrix: Json, pairs: Sequence[tuple[int, int]]) -> FloatArray:
    """Return the (4, 4) of b and k out of a covariance in the order of the set, null as zero."""
    rows = [listed(row) for row in listed(matrix)]
    placed = np.zeros((_COLUMNS, _COLUMNS))
    for row, at in pairs:
        for column, to in pairs:
            value = rows[at][to]
            placed[row, column] = 0.0 if value is None else number(value)
    return placed


def _angle_deg(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the (n,) angle between two unit vectors; exact near 90 degrees, where it is needed."""
    sine = np.linalg.norm(np.cross(first, second), axis=-1)
    return np.asarray(np.degrees(np.arctan2(sine, np.einsum("ni,ni->n", first, second))))


def _uncertainties(numbers: PackageNumbers, covariance: FloatArray, pairs: Sequence[tuple[int, int]]) -> FloatArray:
    """Return (n, p) uncertainties by the law of propagation; axes are taken as independent."""
    units = numbers.directions
    offset = np.sqrt(np.maximum(covariance[..., 0, 0], 0.0))
    of_k = covariance[..., 1:, 1:]
    along = np.sqrt(np.maximum(np.einsum("nai,naij,naj->na", units, of_k, units), 0.0))
    columns = [offset, along]
    if pairs:
        scaled = of_k / (numbers.sensitivity**2)[..., None, None]
        angles = [_pair_variance(units, scaled, a, b) + _pair_variance(units, scaled, b, a) for a, b in pairs]
        columns.append(np.degrees(np.sqrt(np.maximum(np.stack(angles, axis=1), 0.0))))
    return np.concatenate(columns, axis=1)


def _pair_variance(units: FloatArray, covariance: FloatArray, moving: int, fixed: int) -> FloatArray:
    """Return the (n,) variance of the angle as the direction of one axis varies.

    It varies along the part of the other that is across it.
    """
    cosine = np.einsum("ni,ni->n", units[:, moving], units[:, fixed])[:, None]
    across = units[:, fixed] - cosine * units[:, moving]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    across = across / np.where(length > 0.0, length, 1.0)
    return np.asarray(np.einsum("ni,nij,nj->n", across, covariance[:, moving], across))


def _exponential(vectors: FloatArray) -> FloatArray:
    """Return the (n, 3, 3) rotation matrices, Rodrigues."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    matrix = cross_matrices(vectors)
    half = 0.5 * angle
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * matrix + 0.5 * np.sinc(half / np.pi) ** 2 * matrix @ matrix)


def _logarithm(matrices: FloatArray) -> FloatArray:
    """Return the (n, 3) rotation vectors, below half a turn."""
    axial = 0.5 * np.stack(
        [
            matrices[:, 2, 1] - matrices[:, 1, 2],
            matrices[:, 0, 2] - matrices[:, 2, 0],
            matrices[:, 1, 0] - matrices[:, 0, 1],
        ],
        axis=-1,
    )
    sine = np.linalg.norm(axial, axis=-1, keepdims=True)
    cosine = 0.5 * (np.trace(matrices, axis1=1, axis2=2)[:, None] - 1.0)
    angle = np.arctan2(sine, cosine)
    return np.asarray(axial * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0))
