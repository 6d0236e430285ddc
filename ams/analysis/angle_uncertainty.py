"""How well the angles that a package will tell are known: U95, and what each source takes of it.

Angles are inferred from the outputs e of all axes by weighted least squares, TP (99) to (108): δθ = (JᵀWJ)⁻¹JᵀW δe
with J the outputs' slopes by pitch and roll and W the inverse variances of the readings at use. The outputs are wrong
by what the coefficients are wrong by, all axes together, and by the readings themselves. One axis alone tells pitch.

U95 is the root mean square, over the box of attitudes where the package will be used, of the 95 % half-width of one
future angle. A share is what a source leaves of it: their squares add up to the square of U95.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.calibration_result import VarianceComponent
from ams.frames import LEVEL_ANGLES, Attitude
from ams.models.model import Model
from ams.statistics.intervals import reading_halfwidth

READING: Final = "reading at use"
ADDED: Final = "extension"
_PITCHES: Final = 9
"""Over the range of use, at the middles of equal steps."""
_ROLLS: Final = 16
"""Over the circle, at the middles of equal steps."""
_LEAST_INFORMATION: Final = 0.25
"""Of the largest slope in the box: where an angle moves the outputs less, it is flagged at use and not counted."""

_LEAST_READING: Final = 1e-3
"""Of the largest scatter of a reading: no axis is weighed as if it had none."""


@dataclass(frozen=True)
class UsageBox:
    """Where a package will be used, radians; every roll."""

    pitch_rad: tuple[float, float]
    temperature_degc: float | None = None

    def attitudes(self, *, is_level: bool) -> Attitude:
        """Return attitudes all over the box; at no roll where the model knows none."""
        low, high = self.pitch_rad
        middles = (np.arange(_PITCHES) + 0.5) / _PITCHES
        rolls = np.zeros(1) if is_level else 2.0 * np.pi * (np.arange(_ROLLS) + 0.5) / _ROLLS - np.pi
        pitch, roll = (grid.ravel() for grid in np.meshgrid(low + (high - low) * middles, rolls, indexing="ij"))
        temperature = None if self.temperature_degc is None else np.full(pitch.size, self.temperature_degc)
        return Attitude(pitch, roll, np.zeros(pitch.size), temperature)


@dataclass(frozen=True)
class KnownAxis:
    """One sensor axis of a package: what its coefficients are, and how much a reading of it scatters at use."""

    model: Model
    primary: FloatArray
    reading_v: float
    """Standard deviation of one reading at use."""
    added: tuple[str, ...] = ()
    """Primary parameters that stand in the model beside those that were asked for."""


@dataclass(frozen=True)
class AngleUncertainty:
    """U95 of one angle, radians."""

    u95_rad: float
    calibration_rad: float
    """The same with readings that do not scatter."""
    shares_rad: Mapping[str, float]
    """Part of the covariance, ``extension`` or ``reading at use`` to what it takes of U95. Below zero: it takes off."""
    counted: float
    """Share of the box where the angle is told well enough to be counted."""


@dataclass(frozen=True)
class InferredAngles:
    """Angles at n attitudes, inferred from the outputs of A axes; t of them are told."""

    names: tuple[str, ...]
    """(t)"""
    estimator: FloatArray
    """(n, t, A) from errors of the outputs to errors of the angles, radians a volt."""
    directions: FloatArray
    """(n, t, Q) the same from errors of the primary parameters of all axes."""
    read: FloatArray
    """(n, t) variance that the readings leave."""
    is_determined: BoolArray
    """(n, t) whether the attitude tells the angle well enough to be counted."""

    def half_widths_rad(self, components: Sequence[VarianceComponent]) -> FloatArray:
        """Return the (n, t) 95 % half-widths of one future angle each."""
        variances = [_quadratic(self.directions, part.covariance) for part in components]
        return reading_halfwidth(variances, [part.dof for part in components], self.read)


def inferred(axes: Sequence[KnownAxis], attitude: Attitude) -> InferredAngles | None:
    """Return how angles are inferred at attitudes; None where no angle moves an output."""
    slopes = np.stack([_slopes(axis, attitude) for axis in axes], axis=1)  # (n, A, 2)
    resolved = [index for index in range(2) if np.abs(slopes[..., index]).max() > 0.0][: len(axes)]
    if not resolved:
        return None
    reading = np.array([axis.reading_v for axis in axes])
    weights = 1.0 / np.maximum(reading, _LEAST_READING * reading.max() or 1.0) ** 2
    counted, estimator = _estimator(slopes[..., resolved], weights)
    columns = [axis.model.jacobian(axis.primary, attitude) for axis in axes]
    directions = np.concatenate(
        [estimator[:, :, index, None] * column[:, None, :] for index, column in enumerate(columns)], axis=2
    )
    read = np.einsum("nta,a->nt", estimator**2, reading**2)
    return InferredAngles(tuple(LEVEL_ANGLES[index] for index in resolved), estimator, directions, read, counted)


def angle_uncertainties(
    axes: Sequence[KnownAxis], components: Sequence[VarianceComponent], box: UsageBox
) -> dict[str, AngleUncertainty]:
    """Return what is to be expected of pitch and, with two axes or more, of roll.

    ``components`` are of the primary parameters of all axes, one axis after the other. No angle is returned that moves
    no output.
    """
    found = inferred(axes, box.attitudes(is_level=not any(_follows_roll(axis) for axis in axes)))
    if found is None:
        return {}
    added = np.concatenate([[name in axis.added for name in axis.model.primary_names] for axis in axes])
    return {
        name: _uncertainty(found.directions[:, row], found.read[:, row], found.is_determined[:, row], added, components)
        for row, name in enumerate(found.names)
    }


def _follows_roll(axis: KnownAxis) -> bool:
    """Return whether the model can be asked at a roll; one that knows none refuses it or has no slope by it."""
    probe = Attitude(np.array([0.3]), np.array([0.0]), np.zeros(1), np.array([20.0]))
    return bool(np.any(axis.model.angle_jacobian(axis.primary, probe).get("roll", np.zeros(1))))


def _slopes(axis: KnownAxis, attitude: Attitude) -> FloatArray:
    """Return the (n, 2) slopes of an output by pitch and roll, volts per radian."""
    found = axis.model.angle_jacobian(axis.primary, attitude)
    return np.stack([found.get(name, np.zeros_like(attitude.pitch_rad)) for name in LEVEL_ANGLES], axis=-1)


def _estimator(slopes: FloatArray, weights: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Return which of the (n, t) angles are told, and the (n, t, A) estimator of the angles from the outputs."""
    weighted = np.swapaxes(slopes, -1, -2) * weights
    moments = weighted @ slopes
    size = moments.shape[-1]
    scale = np.abs(moments).max()
    inverse = np.linalg.inv(moments + 1e-12 * scale * np.eye(size))
    information = 1.0 / np.diagonal(inverse, axis1=-2, axis2=-1)
    counted = information >= _LEAST_INFORMATION**2 * information.max(axis=0)
    return counted, inverse @ weighted


def _uncertainty(
    directions: FloatArray,
    read: FloatArray,
    counted: BoolArray,
    added: BoolArray,
    components: Sequence[VarianceComponent],
) -> AngleUncertainty:
    """Return one angle's, from (n, Q) directions and the (n,) variance of its readings."""
    directions, read = directions[counted], read[counted]
    variances = [_quadratic(directions, part.covariance) for part in components]
    dof = [part.dof for part in components]
    half = reading_halfwidth(variances, dof, read)
    alone = reading_halfwidth(variances, dof, 0.0)
    factor = half**2 / (sum(variances) + read)
    plain = np.where(added, 0.0, directions)
    shares: dict[str, FloatArray] = {}
    for part, whole in zip(components, variances, strict=True):
        part_variance = _quadratic(plain, part.covariance)
        shares[part.name] = part_variance
        if added.any():
            shares[ADDED] = shares.get(ADDED, np.zeros_like(read)) + whole - part_variance
    shares[READING] = read
    return AngleUncertainty(
        _rms(half),
        _rms(alone),
        {name: _signed_root(float(np.mean(factor * variance))) for name, variance in shares.items()},
        float(counted.mean()),
    )


def _quadratic(directions: FloatArray, covariance: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", directions @ covariance, directions))


def _rms(values: FloatArray) -> float:
    return sqrt(float(np.mean(values**2)))


def _signed_root(value: float) -> float:
    return sqrt(value) if value >= 0.0 else -sqrt(-value)
