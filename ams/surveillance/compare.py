"""Two sets of one package: first the small rotation that a remount leaves in all axes, then what each axis changed.

The directions of all axes are fitted by one rotation, weighted by the covariances of both sets; what it leaves is each
axis' own change, with its uncertainty. A single axis cannot tell its own change of direction from a remount, two axes
share one angle, three axes three: the rotation is reported with the components that cannot be told left out.

The uncertainties are those of the two calibrations, parts that both repeat (table, lack of fit) taken off, because
the same table errs alike in both. They do not hold the scatter from day to day and from mount to mount, which only a
history knows (:mod:`ams.surveillance.control_chart`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SetError
from ams.sets.coefficients import CoefficientSet
from ams.statistics.distributions import chi_square_tail
from ams.surveillance.characteristics import PackageNumbers, cross_matrices, numbers_of, rotations_rad
from ams.units import ARCSEC_PER_RAD

SECONDS_PER_DAY = 86400.0
_SMALLEST_VARIANCE = 1e-30
_TELLING = 1e-9


@dataclass(frozen=True)
class Change:
    """New minus old."""

    value: float
    standard_uncertainty: float

    @property
    def in_uncertainties(self) -> float:
        """How many standard uncertainties; infinite for a change of what is exactly known."""
        if self.standard_uncertainty > 0.0:
            return abs(self.value) / self.standard_uncertainty
        return np.inf if self.value else 0.0


@dataclass(frozen=True)
class AxisChange:
    """What one axis changed, the common rotation taken off."""

    axis: str
    offset_v: Change
    offset_arcsec: Change
    """The same as an angle at full sensitivity."""
    sensitivity_v_per_g: Change
    """Per (deg/s) for gyros."""
    sensitivity_relative: Change
    direction_arcsec: Mapping[str, Change]
    """Of the sensitive axis, along the two package axes across its nominal one."""


@dataclass(frozen=True)
class Comparison:
    """Two calibrations of one package."""

    sensor: str
    old_sha256: str
    new_sha256: str
    elapsed_days: float
    rotation_deg: Mapping[str, Change | None]
    """About each package axis; None where the package's axes cannot tell it."""
    axes: Mapping[str, AxisChange]
    direction_chi_square: float
    """Of the directions after the rotation; expected: its degrees of freedom."""
    direction_dof: int
    direction_p_value: float | None
    """Chance of a larger one where nothing but a remount happened; None without degrees of freedom."""
    notes: tuple[str, ...]
    measured_unit: str = "v"
    """Of the outputs; ``offset_v`` and ``sensitivity_v_per_g`` of the axes are in the set's own units."""
    unit: str = "g"
    """Of what is sensed."""


def compare(old: CoefficientSet, new: CoefficientSet) -> Comparison:
    """Return what changed from ``old`` to ``new``.

    Raises: SetError where they are not of the same axes and equations.
    """
    _check_comparable(old, new)
    before, after = _at_one_gravity(numbers_of(old), old, new), numbers_of(new)
    scatter = before.scatter[0] + after.scatter[0]
    sizes = np.abs(before.sensitivity[0])
    units_before, units_after = before.directions[0], after.directions[0]
    fit = _Rotation.fitted(units_before, units_after, scatter[:, 1:, 1:] / (sizes**2)[:, None, None])
    return Comparison(
        sensor=new.sensor,
        old_sha256=old.sha256,
        new_sha256=new.sha256,
        elapsed_days=(new.created_utc - old.created_utc).total_seconds() / SECONDS_PER_DAY,
        rotation_deg=fit.changes_deg(),
        axes={
            name: _axis_change(name, index, (before, after), scatter[index], fit) for index, name in enumerate(new.axes)
        },
        direction_chi_square=fit.chi_square,
        direction_dof=fit.dof,
        direction_p_value=_chi_square_p(fit.chi_square, fit.dof),
        notes=tuple(_notes(old, new)),
        measured_unit=after.measured_unit,
        unit=after.unit,
    )


@dataclass(frozen=True)
class _Rotation:
    """The common rotation and what it leaves of every direction, both in radians."""

    vector: FloatArray
    covariance: FloatArray
    resolvable: FloatArray
    """(3, 3) projector onto the components that the axes tell."""
    residual: FloatArray
    """(A, 3)"""
    residual_covariance: FloatArray
    """(A, 3, A, 3)"""
    chi_square: float
    dof: int

    @staticmethod
    def fitted(before: FloatArray, after: FloatArray, covariance: FloatArray) -> "_Rotation":
        """Fit the (A, 3) tangential changes by generalised least squares; the start takes most of a large rotation."""
        start = rotations_rad(after[None], before)[0]
        turned = _turned(before, start)
        basis = _tangents(turned)
        design = np.einsum("ati,aij->atj", basis, -cross_matrices(turned)).reshape(-1, 3)
        change = np.einsum("ati,ai->at", basis, after - turned).ravel()
        variance = np.einsum("ati,aij,asj->ats", basis, covariance, basis)
        weight = np.zeros((2 * len(before), 2 * len(before)))
        spread = np.zeros_like(weight)
        for index, block in enumerate(variance):
            rows = slice(2 * index, 2 * index + 2)
            spread[rows, rows] = block
            weight[rows, rows] = np.linalg.inv(block + _SMALLEST_VARIANCE * np.eye(2))
        normal = design.T @ weight @ design
        inverse = np.linalg.pinv(normal, rcond=_TELLING, hermitian=True)
        step = inverse @ design.T @ weight @ change
        left = change - design @ step
        hat = np.eye(len(left)) - design @ inverse @ design.T @ weight
        left_covariance = (hat @ spread @ hat.T).reshape(len(before), 2, len(before), 2)
        rank = int(np.linalg.matrix_rank(normal, tol=_TELLING * float(np.linalg.norm(normal)), hermitian=True))
        return _Rotation(
            start + step,
            inverse,
            inverse @ normal,
            np.einsum("ati,at->ai", basis, left.reshape(-1, 2)),
            np.einsum("ati,atbs,bsj->aibj", basis, left_covariance, basis),
            float(left @ weight @ left),
            len(left) - rank,
        )

    def changes_deg(self) -> dict[str, Change | None]:
        """Return the change about each axis; None where more than a trace of it lies in what cannot be told."""
        is_resolvable = np.diag(self.resolvable) > 1.0 - 1e-3
        spread = np.degrees(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))
        return {
            axis: Change(float(np.degrees(self.vector[index])), float(spread[index])) if is_resolvable[index] else None
            for index, axis in enumerate("xyz")
        }


def _check_comparable(old: CoefficientSet, new: CoefficientSet) -> None:
    for name, was, now in (
        ("convention", old.convention, new.convention),
        ("axes", ", ".join(old.axes), ", ".join(new.axes)),
        ("units", _units(old), _units(new)),
        ("nominal axes", _nominal(old), _nominal(new)),
    ):
        if was != now:
            raise SetError(
                f"{new.sensor}: {name}: cannot be compared: got {now}, the older set has {was}; nothing was compared; "
                "compare sets of the same package and convention"
            )


def _units(coefficients: CoefficientSet) -> str:
    form = next(iter(coefficients.axes.values())).form
    return f"{form.measured_unit} per {form.unit}"


def _nominal(coefficients: CoefficientSet) -> str:
    return ", ".join(axis.nominal_axis for axis in coefficients.axes.values())


def _at_one_gravity(numbers: PackageNumbers, old: CoefficientSet, new: CoefficientSet) -> PackageNumbers:
    """Bring sensitivities per g to the g of the newer set; rates know no g."""
    if numbers.unit != "g":
        return numbers
    ratio = new.gravity_mps2 / old.gravity_mps2
    scale = np.array([1.0, ratio, ratio, ratio])
    spread = np.outer(scale, scale)
    return replace(
        numbers,
        primary=numbers.primary * scale,
        covariance=numbers.covariance * spread,
        scatter=numbers.scatter * spread,
    )


def _axis_change(
    name: str, index: int, pair: tuple[PackageNumbers, PackageNumbers], scatter: FloatArray, fit: _Rotation
) -> AxisChange:
    before, after = pair
    offset = float(after.primary[0, index, 0] - before.primary[0, index, 0])
    offset_u = float(np.sqrt(max(scatter[0, 0], 0.0)))
    was, now = float(before.sensitivity[0, index]), float(after.sensitivity[0, index])
    along = after.directions[0, index]
    sensitivity_u = float(np.sqrt(max(along @ scatter[1:, 1:] @ along, 0.0)))
    to_arcsec = ARCSEC_PER_RAD / abs(was)
    across = [axis for axis in "xyz" if axis != before.axes[index]]
    return AxisChange(
        axis=name,
        offset_v=Change(offset, offset_u),
        offset_arcsec=Change(offset * to_arcsec, offset_u * to_arcsec),
        sensitivity_v_per_g=Change(now - was, sensitivity_u),
        sensitivity_relative=Change((now - was) / was, sensitivity_u / abs(was)),
        direction_arcsec={axis: _direction(fit, index, "xyz".index(axis)) for axis in across},
    )


def _direction(fit: _Rotation, index: int, component: int) -> Change:
    variance = max(float(fit.residual_covariance[index, component, index, component]), 0.0)
    return Change(ARCSEC_PER_RAD * float(fit.residual[index, component]), ARCSEC_PER_RAD * float(np.sqrt(variance)))


def _turned(directions: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the directions turned by a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return directions
    about = vector / angle
    along = np.outer(directions @ about, about)
    turned = along + np.cos(angle) * (directions - along) + np.sin(angle) * np.cross(about, directions)
    return np.asarray(turned)


def _tangents(directions: FloatArray) -> FloatArray:
    """Return (A, 2, 3) two unit vectors across each direction."""
    _, _, frames = np.linalg.svd(directions[:, None, :])
    return np.asarray(frames[:, 1:, :])


def _chi_square_p(value: float, dof: int) -> float | None:
    if dof <= 0:
        return None

    return float(chi_square_tail(value, dof))


def _notes(old: CoefficientSet, new: CoefficientSet) -> list[str]:
    notes = []
    if old.sensor != new.sensor:
        notes.append(f"sets of two sensors: {old.sensor} and {new.sensor}")
    if new.created_utc < old.created_utc:
        notes.append("the first set is the newer one")
    if old.model != new.model:
        notes.append(f"models {old.model} and {new.model}: only offset and sensitive axis are compared")
    if old.gravity_mps2 != new.gravity_mps2 and new.senses_gravity:
        notes.append(f"calibrated at {old.gravity_mps2} and {new.gravity_mps2} m/s²: compared at the g of the second")
    return [*notes, *_temperature_notes(old, new)]


def _temperature_notes(old: CoefficientSet, new: CoefficientSet) -> list[str]:
    notes = []
    for axis in new.axes:
        was, now = (coefficients.axes[axis].parameters.get("reference_temperature_degc") for coefficients in (old, new))
        if was != now:
            degrees = " and ".join("none" if value is None else f"{value:g} °C" for value in (was, now))
            notes.append(f"axis {axis}: coefficients hold at reference temperatures {degrees}: compared as they stand")
    return notes
