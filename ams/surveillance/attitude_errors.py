"""How wrong a set is at known attitudes, in degrees: the errors of the angles that it would have inferred.

At every point of a run the attitude is known, so the error of an inferred angle follows from the outputs by the slope
of the set itself: δ = (JᵀWJ)⁻¹JᵀW (v − v(α, R)), with J = ∂v/∂(α, R). That serves one, two and three axes alike, has no
second branch and is exact to the square of the error. One axis tells pitch alone, roll being known (TP (76), (79)); two
and three tell both. Where the outputs hardly move with an angle (TP 6) its error is left out, and said to be.

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

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude.spread import output_errors
from ams.errors import OutsideValidity
from ams.frames import specific_force
from ams.inference.calibrated import package_of_set, sensor_of_set
from ams.inputs.request import select_rows
from ams.observations import Observations
from ams.sets.apply import apply
from ams.sets.coefficients import CoefficientSet
from ams.surveillance.reference_attitude import ReferenceAttitude

LARGEST_AMPLIFICATION = 10.0
"""Points where an angle's error would be more than so many times that of an output at full slope are left out."""
COEFFICIENTS: Final = "coefficients"
READINGS: Final = "readings"
REFERENCE: Final = "reference attitude"
_STEP_RAD = 1e-4
_ROUNDING_DEG = 1e-6


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
    """Points where the outputs do not tell this angle."""
    parts_deg: Mapping[str, FloatArray] = field(default_factory=dict)
    """Budget of the standard uncertainty: ``coefficients``, ``readings`` and, where it is counted, ``reference
    attitude`` to (K,), of which it is the root of the sum of squares. Empty for errors that an earlier version stored.
    """

    @property
    def expanded_deg(self) -> FloatArray:
        return self.coverage_factor * self.standard_uncertainty_deg

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
    pitch, roll = observations.pitch_rad[kept], observations.roll_rad[kept]
    temperature = None if observations.temperature_degc is None else observations.temperature_degc[kept]
    axes = tuple(applied.axes)
    gain = _gain(applied, axes, pitch, roll, temperature)
    outputs_v = np.stack([observations.outputs[axis][kept] for axis in axes], axis=-1)
    errors_rad = np.einsum("nsa,na->ns", gain, outputs_v - _predicted_v(applied, axes, pitch, roll, temperature))
    spread = _spread(measured_by, applied, select_rows(observations, kept), gain, reference)
    points = observations.point[kept]
    found = {
        angle: _at_points(angle, points, (pitch, roll, errors_rad[:, index]), spread, index)
        for index, angle in enumerate(("pitch", "roll")[: gain.shape[1]])
    }
    return {angle: errors for angle, errors in found.items() if errors.error_deg.size}


def _check_alike(applied: CoefficientSet, measured_by: CoefficientSet, observations: Observations) -> None:
    lacking = [axis for axis in applied.axes if axis not in observations.outputs or axis not in measured_by.axes]
    if applied.convention != "TP" or measured_by.convention != "TP":
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


def _predicted_v(
    applied: CoefficientSet, axes: tuple[str, ...], pitch: FloatArray, roll: FloatArray, temperature: FloatArray | None
) -> FloatArray:
    outputs = apply(applied, pitch, roll, temperature, beyond_validity=True)
    return np.stack([outputs[axis] for axis in axes], axis=-1)


def _gain(
    applied: CoefficientSet, axes: tuple[str, ...], pitch: FloatArray, roll: FloatArray, temperature: FloatArray | None
) -> FloatArray:
    """Return (N, s, A) radians per volt, s angles; NaN rows where the outputs do not tell an angle."""

    def slope(by_pitch: float, by_roll: float) -> FloatArray:
        ahead, behind = (
            _predicted_v(applied, axes, pitch + sign * by_pitch, roll + sign * by_roll, temperature)
            for sign in (1.0, -1.0)
        )
        return np.asarray((ahead - behind) / (2.0 * _STEP_RAD))

    slopes = [slope(_STEP_RAD, 0.0)] + ([slope(0.0, _STEP_RAD)] if len(axes) > 1 else [])
    scale = np.array([float(np.linalg.norm(applied.axes[axis].direction_v_per_g)) for axis in axes])
    relative = np.stack(slopes, axis=-1) / scale[:, None]
    inverse = np.linalg.pinv(relative, rcond=1e-9)
    amplification = np.linalg.norm(inverse, axis=-1)
    lost = ~_resolved(relative, amplification)
    return np.asarray(np.where(lost[..., None], np.nan, inverse) / scale)


def _resolved(relative: FloatArray, amplification: FloatArray) -> BoolArray:
    """Return (N, s) whether each angle is told.

    Some slope is there, no other angle hides it, noise is not blown up.
    """
    columns = np.linalg.norm(relative, axis=1)
    cosine = np.zeros(columns.shape[0])
    if columns.shape[1] == 2:
        with np.errstate(invalid="ignore", divide="ignore"):
            cosine = np.abs(np.einsum("na,na->n", relative[..., 0], relative[..., 1])) / columns.prod(axis=1)
    hidden = np.nan_to_num(cosine) > 1.0 - 0.5 / LARGEST_AMPLIFICATION**2
    seen = columns * LARGEST_AMPLIFICATION >= 1.0
    return np.asarray(seen & ~hidden[:, None] & (amplification <= LARGEST_AMPLIFICATION))


@dataclass(frozen=True)
class _Spread:
    """Of s angles in N rows, radians."""

    parts: Mapping[str, FloatArray]
    """(N, s) standard uncertainties."""
    half_95: FloatArray
    """(N, s)"""


def _spread(
    measured_by: CoefficientSet,
    applied: CoefficientSet,
    rows: Observations,
    gain: FloatArray,
    reference: ReferenceAttitude | None,
) -> _Spread:
    """Return the spread of the mean errors at a point.

    It has the new calibration's covariance, what its axes share included, its dwells' scatter and the errors of the
    reference; every angle has degrees of freedom of its own (Welch-Satterthwaite), those of the reference infinite.
    """
    axes = tuple(applied.axes)
    replications = max(len(np.unique(rows.replication)), 1)
    scatter = [sensor_of_set(measured_by, axis, None, rows.temperature_degc).reading_sd_v for axis in axes]
    sensors = [
        sensor_of_set(measured_by, axis, sd / replications**0.5, rows.temperature_degc)
        for axis, sd in zip(axes, scatter, strict=True)
    ]
    package = package_of_set(measured_by, axes, sensors)
    errors = output_errors(sensors, specific_force(rows.pitch_rad, rows.roll_rad), package)
    variances = errors.angle_variances(gain)
    calibration = np.sum(variances.calibration, axis=0)
    if reference is None:
        parts = {COEFFICIENTS: calibration, READINGS: variances.reading}
        return _Spread({name: np.sqrt(part) for name, part in parts.items()}, variances.half_95())
    components = (
        [part for sensor in sensors for part in sensor.components] if package is None else list(package.components)
    )
    named = zip((part.name for part in components), variances.calibration, strict=True)
    followed = sum((part for name, part in named if name in reference.parts), np.zeros_like(calibration))
    k = np.stack([applied.axes[axis].direction_v_per_g for axis in axes])
    whole = np.fmax(followed, reference.angle_variances(gain, k, rows.pitch_rad, rows.roll_rad))
    parts = {COEFFICIENTS: np.fmax(calibration - followed, 0.0), READINGS: variances.reading, REFERENCE: whole}
    half_95 = variances.half_95(known=whole - followed)
    return _Spread({name: np.sqrt(part) for name, part in parts.items()}, half_95)


def _at_points(
    angle: str, points: IntArray, rows: tuple[FloatArray, FloatArray, FloatArray], spread: _Spread, index: int
) -> AngleErrors:
    """Return the means over the rows of each point; a point is left out where any of its rows is.

    ``rows``: pitch, roll and error; ``index``: of the angle in ``spread``.
    """
    labels, point_of_row = np.unique(points, return_inverse=True)
    counts = np.bincount(point_of_row)

    def mean(column: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(point_of_row, weights=column) / counts)

    pitch, roll, error = (mean(column) for column in rows)
    is_known = np.isfinite(error)
    parts = {name: np.rad2deg(mean(part[:, index])[is_known]) for name, part in spread.parts.items()}
    standard_uncertainty_deg = np.sqrt(sum(part**2 for part in parts.values()))
    return AngleErrors(
        angle,
        np.rad2deg(pitch[is_known]),
        np.rad2deg(roll[is_known]),
        np.rad2deg(error[is_known]),
        standard_uncertainty_deg,
        np.rad2deg(mean(spread.half_95[:, index])[is_known]) / standard_uncertainty_deg,
        int(labels.size - is_known.sum()),
        parts,
    )
