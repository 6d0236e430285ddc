"""How wrong a set is at known attitudes, in degrees: the errors of the angles that it would have inferred.

At every point of a run the attitude is known, and of the outputs there the set tells another, whole and not by its
slope (:mod:`ams.surveillance.inferred_attitude`). Where the axes do not determine an angle its error is left out, and
said to be.

The uncertainty of an error is that of the new measurement: covariance of the new calibration (lack of fit, drift,
meter), the scatter of its dwells, and what the reference attitude is wrong by. That of the set under test is not part
of it: it is what is being found.

With e the error of the reference at a point (its index errors, the level of the base) the sensor stood at α + e and was
taken to stand at α, so that the stated δ is the set's own error there plus e, whole, whichever set is applied. The
coefficients solved from the run have followed a part of e, H e, which is the part ``table`` of the covariance. It is
the same e once more and no further error: the variance of e stands for it, var e and not var e + var H e, and where
H e has the larger one (next to an index at which the axis was set to read true), that one. Source: GUM 5.1.2, H.2.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude.spread import output_errors
from ams.errors import OutsideValidity
from ams.frames import LEVEL_ANGLES, specific_force
from ams.inference.package.calibrated import package_of_set, sensor_of_set
from ams.inputs.request import select_rows
from ams.models.registry import is_solved_from_levels
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet
from ams.sets.sensed_quantity import FIELDS
from ams.surveillance.inferred_attitude import InferredAngle, Readings, inferred_angles
from ams.surveillance.reference_attitude import ReferenceAttitude

COEFFICIENTS: Final = "coefficients"
READINGS: Final = "readings"
REFERENCE: Final = "reference attitude"
TWO_ATTITUDES: Final = "which of two attitudes"
_ROUNDING_DEG = 1e-6
_OF_PITCH_AND_ROLL: Final = "TP"
"""The convention in which errors in degrees are told."""


@dataclass(frozen=True)
class AngleErrors:
    """Errors of one inferred angle at the K points of a run where the outputs tell it, means over the replications."""

    angle: str
    """``pitch`` or ``roll``."""
    pitch_deg: FloatArray
    roll_deg: FloatArray
    error_deg: FloatArray
    """(K,) inferred minus true."""
    standard_uncertainty_deg: FloatArray
    """(K,) of the error."""
    coverage_factor: FloatArray
    """(K,) for 95 %, from the degrees of freedom of this angle at this point."""
    left_out: int
    """Points at which this angle is not determined: the outputs hardly move with it, both attitudes that two of them
    fit meet, or they are of no attitude by this set.
    """
    parts_deg: Mapping[str, FloatArray] = field(default_factory=dict)
    """Budget of the standard uncertainty: ``coefficients``, ``readings`` and, where they count, ``reference attitude``
    and ``which of two attitudes`` to (K,), of which it is the root of the sum of squares. Empty for errors that an
    earlier version stored.
    """

    @property
    def expanded_deg(self) -> FloatArray:
        return self.coverage_factor * self.standard_uncertainty_deg

    @property
    def largest(self) -> int:
        """The point where the size of the error is largest."""
        return int(np.argmax(np.abs(self.error_deg)))

    @property
    def worst(self) -> int:
        """The point where the size of the error and its expanded uncertainty together are largest."""
        return int(np.argmax(np.abs(self.error_deg) + self.expanded_deg))


def errors_of(
    applied: CoefficientSet,
    measured_by: CoefficientSet,
    observations: Observations,
    usage_pitch_deg: tuple[float, float] | None = None,
    reference: ReferenceAttitude | None = None,
) -> Mapping[str, AngleErrors]:
    """Return the errors of the set ``applied`` at the points of a run, by angle.

    ``measured_by`` is the set solved from this very run: its covariance is the uncertainty of what the run says.
    ``usage_pitch_deg`` limits the points. ``reference``: what the attitudes of the run are wrong by; None: nobody
    knows, and it is not in the uncertainties. Empty where no point tells any angle.

    Raises: OutsideValidity where the set cannot be applied to such outputs at all (other axes, other convention).
    """
    _check_alike(applied, measured_by, observations)
    kept = _within(np.rad2deg(observations.pitch_rad), usage_pitch_deg)
    if not kept.any():
        return {}
    observations = observations if reference is None else reference.corrected(observations)
    spread = _PointSpread(measured_by, applied, select_rows(observations, kept), reference)
    inferred = inferred_angles(spread.readings(), lambda gain: spread.of(gain).standard())
    found = {angle: _of_angle(angle, of_angle, spread) for angle, of_angle in inferred.items()}
    return {angle: errors for angle, errors in found.items() if errors.error_deg.size}


def angles_of(applied: CoefficientSet) -> tuple[str, ...]:
    """Return the angles that a package with the axes of a set tells: of one axis pitch alone."""
    return LEVEL_ANGLES[:1] if len(applied.axes) == 1 else LEVEL_ANGLES


def angles_judged(model: str, axes: int) -> tuple[str, ...]:
    """Return the angles whose errors are told of the set of a package solved with a model, ``axes`` of it.

    None of straight lines, of gyros, of packages that yaw and of models with an equation of their own.
    """
    form = FIELDS.get(model)
    if form is None or form.convention != _OF_PITCH_AND_ROLL or form.output is not None or is_solved_from_levels(model):
        return ()
    return LEVEL_ANGLES[:1] if axes == 1 else LEVEL_ANGLES


def _check_alike(applied: CoefficientSet, measured_by: CoefficientSet, observations: Observations) -> None:
    lacking = [axis for axis in applied.axes if axis not in observations.outputs or axis not in measured_by.axes]
    if {applied.convention, measured_by.convention} != {_OF_PITCH_AND_ROLL}:
        raise OutsideValidity(
            f"{applied.sensor}: errors in degrees need sets of pitch and roll: got convention {applied.convention}, "
            f"measured by {measured_by.convention}, needed TP; nothing was computed"
        )
    formula_axis = next(
        (axis for coefficients in (applied, measured_by) for axis in coefficients.axes.values() if axis.model_output),
        None,
    )
    if formula_axis is not None:
        raise OutsideValidity(
            f"{applied.sensor}: errors in degrees are told for sets of the form v = b + k·f, this one has an equation "
            "of its own; nothing was computed; compare its outputs at the test vectors instead"
        )
    if lacking:
        raise OutsideValidity(
            f"{applied.sensor}: axis {', '.join(lacking)} of the set was not measured: the run has "
            f"{', '.join(observations.outputs)}; nothing was computed; it is another package, or another set"
        )


def _within(pitch_deg: FloatArray, usage_pitch_deg: tuple[float, float] | None) -> BoolArray:
    if usage_pitch_deg is None:
        return np.ones(pitch_deg.size, dtype=bool)
    low, high = usage_pitch_deg
    return np.asarray((pitch_deg >= low - _ROUNDING_DEG) & (pitch_deg <= high + _ROUNDING_DEG))


@dataclass(frozen=True)
class _Parts:
    """Of m angles at K points, radians: means over the rows of each."""

    parts: Mapping[str, FloatArray]
    """(K, m) standard uncertainties."""
    half_95: FloatArray
    """(K, m)"""

    def standard(self) -> FloatArray:
        return np.asarray(np.sqrt(sum(part**2 for part in self.parts.values())))


class _PointSpread:
    """What is not known of the mean outputs at the K points of a run.

    It has the new calibration's covariance, what its axes share included, its dwells' scatter and the errors of the
    reference; every angle has degrees of freedom of its own (Welch-Satterthwaite), those of the reference infinite.
    """

    def __init__(
        self,
        measured_by: CoefficientSet,
        applied: CoefficientSet,
        rows: Observations,
        reference: ReferenceAttitude | None,
    ) -> None:
        axes = tuple(applied.axes)
        self._axes, self._applied, self._rows, self._reference = axes, applied, rows, reference
        replications = max(len(np.unique(rows.replication)), 1)
        scatter = [sensor_of_set(measured_by, axis, None, rows.temperature_degc).reading_sd_v for axis in axes]
        sensors = [
            sensor_of_set(measured_by, axis, sd / replications**0.5, rows.temperature_degc)
            for axis, sd in zip(axes, scatter, strict=True)
        ]
        package = package_of_set(measured_by, axes, sensors)
        self._errors = output_errors(sensors, specific_force(rows.pitch_rad, rows.roll_rad), package)
        self._components = (
            [part for sensor in sensors for part in sensor.components] if package is None else list(package.components)
        )
        _, self._point_of_row = np.unique(rows.point, return_inverse=True)
        self._counts = np.bincount(self._point_of_row)
        self.pitch_rad, self.roll_rad = self._mean(rows.pitch_rad), self._mean(rows.roll_rad)

    def readings(self) -> Readings:
        """Return what the set under test makes of the outputs, as deviations from its offsets."""
        rows, sensors, deviations = self._rows, [], []
        for axis in self._axes:
            sensor = sensor_of_set(self._applied, axis, 0.0, rows.temperature_degc)
            deviations.append(self._mean(sensor.line_output_v(rows.outputs[axis]) - sensor.offset_v))
            sensors.append(sensor)
        return Readings(sensors, np.stack(deviations, axis=-1), self.pitch_rad, self.roll_rad)

    def of(self, gain: FloatArray, known_rad: FloatArray | float = 0.0) -> _Parts:
        """Return the spread of (K, m, A) angles per volt; ``known_rad``, (K, m): a type B part of the angle itself."""
        of_rows = gain[self._point_of_row]
        shape = of_rows.shape[:2]
        beside = np.broadcast_to(known_rad, gain.shape[:2])[self._point_of_row] ** 2
        variances = self._errors.angle_variances(of_rows)
        calibration = np.sum(variances.calibration, axis=0)
        followed = whole = np.zeros(shape)
        if self._reference is not None:
            named = zip((part.name for part in self._components), variances.calibration, strict=True)
            followed = sum((part for name, part in named if name in self._reference.parts), np.zeros(shape))
            k = np.stack([self._applied.axes[axis].direction_v_per_g for axis in self._axes])
            rows = self._rows
            whole = np.fmax(followed, self._reference.angle_variances(of_rows, k, rows.pitch_rad, rows.roll_rad))
        parts = {COEFFICIENTS: np.fmax(calibration - followed, 0.0), READINGS: variances.reading}
        parts |= {REFERENCE: whole} if self._reference is not None else {}
        parts |= {TWO_ATTITUDES: beside} if np.nanmax(beside, initial=0.0) > 0.0 else {}
        is_moved = np.asarray(gain.any(axis=-1))[self._point_of_row]
        half_95 = np.where(is_moved, variances.half_95(known=whole - followed + beside), 0.0)
        return _Parts({name: self._mean(np.sqrt(part)) for name, part in parts.items()}, self._mean(half_95))

    def _mean(self, column: FloatArray) -> FloatArray:
        """Return the means over the rows of each point of (N, …)."""
        total = np.zeros((self._counts.size, *column.shape[1:]))
        np.add.at(total, self._point_of_row, column)
        return np.asarray(total / self._counts.reshape(-1, *[1] * (column.ndim - 1)))


def _of_angle(angle: str, inferred: InferredAngle, spread: _PointSpread) -> AngleErrors:
    """Return the errors at the points where the angle is determined, along it and across it as one length."""
    is_known = np.isfinite(inferred.error_rad)
    beside = np.stack([inferred.known_rad, np.zeros_like(inferred.known_rad)], axis=-1)
    found = spread.of(inferred.gain, beside)
    parts = {name: np.rad2deg(np.linalg.norm(part[is_known], axis=-1)) for name, part in found.parts.items()}
    standard_uncertainty_deg = np.sqrt(sum(part**2 for part in parts.values()))
    return AngleErrors(
        angle,
        np.rad2deg(spread.pitch_rad[is_known]),
        np.rad2deg(spread.roll_rad[is_known]),
        np.rad2deg(inferred.error_rad[is_known]),
        standard_uncertainty_deg,
        np.rad2deg(np.linalg.norm(found.half_95[is_known], axis=-1)) / standard_uncertainty_deg,
        int((~is_known).sum()),
        parts,
    )
