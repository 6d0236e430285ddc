"""Gyros and accelerometers together: pitch, yaw and roll by the Kalman filter of :mod:`ams.attitude.attitude_filter`.

The gyros carry the attitude, gravity as the accelerometers feel it corrects pitch, roll and the gyros' zeros; yaw rests
on the gyros alone, or on a magnetometer beside them. A package that accelerates does not feel gravity alone: its force
is not used then, nor a field that something nearby disturbs, and that is said. All packages stand in the same axes. The
normalised innovations are counted: where the assumptions hold, their mean is three.

To the filter's covariance, which takes the errors of forces as new in every row and those of the field as new every
five seconds, comes what is the same in all rows: what the sets leave open, and what is stated of the field
(:mod:`ams.inference.gyros.lasting_errors`).

The zeros start as uncertain as the covariance of the set makes them, with what the set counts of their shift since the
calibration, or what is stated of it, or 0.1 °/s; a rest at the beginning measures them. The Earth's turn is taken off
where latitude and heading are stated; where they are not it is in the zeros, 15°/h (standard deviation) along any
axis: all of it may lie along one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude import attitude_filter, flag_codes
from ams.attitude.attitude_filter import AttitudeFilter, FilteredPath, FilterSettings
from ams.attitude.earth_rate import EARTH_RATE_RAD_S
from ams.attitude.gyro import quaternion_of_cr
from ams.attitude.kalman import Estimate, GyroNoise, in_body_axes
from ams.attitude.quaternion import multiply
from ams.attitude.rate_errors import turns_by_angle
from ams.errors import OutsideValidity
from ams.inference.gyros.aided_words import mean_in_words, zeros_in_words
from ams.inference.gyros.field_aid import FieldAid
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.lasting_errors import lasting_covariance, turn_by_lasting_errors
from ams.inference.gyros.rates import ANSWERS, Motion, answer_of
from ams.inference.gyros.rest_at_start import RestAtStart
from ams.inference.inference import Package
from ams.inference.rows.angle_stream import Answer, joined, nothing, with_temperature_codes
from ams.inference.rows.sample_clock import LONGEST_TURN_S, SampleClock
from ams.inference.rows.used_beyond import codes_of_angles, codes_of_rates
from ams.models.possible_temperature import COLUMN, possible_temperatures
from ams.sets.coefficients import CoefficientSet
from ams.sets.vectors import inferred_force, resolves

LEAST_FORCE_SD_G: Final = 1e-4
UNSTATED_ZERO_SD_DPS: Final = 0.1
"""Of zeros since the calibration, where neither set nor user states it: what gyros of small sensors do from one
switching on to the next."""
UNSTATED_TILT_SD_DEG: Final = 5.0
"""Of pitch and roll by the first force alone; yaw counts from there."""
KNOWN: Final = ("true_pitch_deg", "true_yaw_deg", "true_roll_deg")
"""Columns of the attitude where it is known, as on a table: the estimate is held against it."""
LEAST_SPREAD_RAD: Final = 1e-5
FIELD_RENEWED_S: Final = 5.0
"""What disturbs a field comes and goes with what moves near by, in seconds and not in rows."""
_CODES: Final = (
    (attitude_filter.GYRO_BRIDGED, flag_codes.RATE_BRIDGED),
    (attitude_filter.FORCE_REJECTED, flag_codes.ACCELERATED),
    (attitude_filter.FORCE_TURNED, flag_codes.FORCE_TURNED),
    (attitude_filter.CONTRADICTED, flag_codes.CONTRADICTED),
    (attitude_filter.UNAIDED, flag_codes.UNAIDED),
    (attitude_filter.FORCE_MISSING, flag_codes.NOT_FINITE),
    (attitude_filter.FIELD_MISSING, flag_codes.NOT_FINITE),
    (attitude_filter.FIELD_REJECTED, flag_codes.FIELD_UNUSED),
)
_REASONS: Final = {**flag_codes.WORDS, **flag_codes.GRAVITY_WORDS, **flag_codes.FIELD_WORDS}


@dataclass(frozen=True)
class Aiding:
    """What the filter is told beside the sets."""

    force_sd_g: float = 0.005
    """Standard deviation of one component of the force, calibration and vibration together."""
    bias_walk_dps_per_sqrt_s: float = 1e-4
    """How far the zero of a gyro wanders in a second."""
    zero_sd_dps: float | None = None
    """How far the zero of a gyro has gone since its calibration, standard deviation; None: as the set counts it, else
    0.1 °/s."""

    def __post_init__(self) -> None:
        if not (self.force_sd_g >= LEAST_FORCE_SD_G and self.bias_walk_dps_per_sqrt_s >= 0.0):
            raise OutsideValidity(
                f"filter: got a standard deviation of {self.force_sd_g:g} g and a walk of "
                f"{self.bias_walk_dps_per_sqrt_s:g} °/s per √s: allowed are {LEAST_FORCE_SD_G:g} g or more and 0 or "
                "more; nothing was computed"
            )
        if self.zero_sd_dps is not None and not 0.0 <= self.zero_sd_dps < np.inf:
            raise OutsideValidity(
                f"filter: got zeros known within {self.zero_sd_dps:g} °/s (standard deviation): allowed is a number of "
                "0 or more; nothing was computed"
            )


class AidedAngles:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` of gyros, accelerometers and, if given, magnetometers."""

    def __init__(
        self,
        gyros: GyroPackage,
        accelerometers: Package,
        motion: Motion,
        aiding: Aiding,
        field: FieldAid | None = None,
    ) -> None:
        coefficients = accelerometers.coefficients
        senses_force = all(axis.form.unit == "g" and not axis.form.is_gravity for axis in coefficients.axes.values())
        all_columns = tuple(accelerometers.columns) == tuple(coefficients.axes)
        if not (all_columns and senses_force and resolves(coefficients.axes)):
            raise OutsideValidity(
                f"{coefficients.sensor}: got the axes {', '.join(accelerometers.columns)} by {accelerometers.model}, "
                "needed three accelerometers in TP's convention, or straight lines in g, that determine the force; "
                "nothing was computed"
            )
        if motion.rest_s and aiding.zero_sd_dps is not None:
            raise OutsideValidity(
                f"at rest: got {motion.rest_s:g} s at rest, which measure the zeros of the gyros, and zeros known "
                f"within {aiding.zero_sd_dps:g} °/s: give one of the two; nothing was computed"
            )
        if motion.method != "quaternion":
            raise OutsideValidity(
                "method: the filter carries the quaternion; nothing was computed; leave the method out"
            )
        self.gyros, self.accelerometers, self.motion, self.aiding = gyros, accelerometers, motion, aiding
        self.field = field
        self.rest = RestAtStart(gyros, motion.rest_s)
        self._offset_v = gyros.offset_v
        self._clock = SampleClock(motion.rate_hz, LONGEST_TURN_S)
        self._filter: AttitudeFilter | None = None
        self._zero_sd_rad_s = np.sqrt(np.diag(self._zero_covariance()))
        self._innovations, self._of_field, self._errors = np.zeros(2), np.zeros(2), np.zeros(2)

    @property
    def needed(self) -> tuple[str, ...]:
        temperature = ["temperature_degc"] if self.accelerometers.coefficients.needs_temperature else []
        field = () if self.field is None else self.field.needed
        columns = self.gyros.columns.values(), self.accelerometers.columns.values(), field, temperature
        return tuple(dict.fromkeys(name for names in columns for name in names))

    @property
    def optional(self) -> tuple[str, ...]:
        return ("time_s", COLUMN, *KNOWN)

    @property
    def answers_at_once(self) -> bool:
        return True

    @property
    def answers(self) -> tuple[str, ...]:
        return ANSWERS

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles of further rows. Raises: OutsideValidity without a sampling rate."""
        outputs_v = self.gyros.outputs_v(readings)
        rows = outputs_v.shape[1]
        if not rows:
            return nothing(ANSWERS)
        steps = self._clock.steps(readings.get("time_s"), rows)
        if self._filter is None:
            steps = np.concatenate([[1], steps[1:]])
            self._filter = self._started(readings)
        assert self._clock.interval_s is not None
        resting = self.rest.take(outputs_v, self._clock.interval_s)
        found = None
        if resting:
            found = self._rows({name: values[:resting] for name, values in readings.items()}, steps[:resting], None)
            if self.rest.zero is not None:
                self._take_zero()
        if resting < rows:
            moving = {name: values[resting:] for name, values in readings.items()}
            rates = self.gyros.rates_above(outputs_v[:, resting:] - self._offset_v[:, None])
            turning = self._rows(moving, steps[resting:], rates)
            found = turning if found is None else joined(found, turning)
        assert found is not None
        return with_temperature_codes(found, readings, self._sets)

    @cached_property
    def _sets(self) -> tuple[CoefficientSet, ...]:
        of_field = () if self.field is None else (self.field.package.coefficients,)
        return (self.gyros.coefficients, self.accelerometers.coefficients, *of_field)

    def _rows(self, readings: Mapping[str, FloatArray], steps: IntArray, rates: FloatArray | None) -> Answer:
        """Return the angles of rows with their (3, n) rates; None where they rest."""
        assert self._filter is not None
        force, field = self._directions(readings)
        is_resting = rates is None
        gyro = np.full_like(force, np.nan) if rates is None else rates
        sample = np.cumsum(np.minimum(steps, round(self._most_lost))) - 1
        is_used = steps > 0
        count = int(sample[-1]) + 1
        slots = np.full((9, count), np.nan)
        slots[:, sample[is_used]] = np.concatenate([gyro, force, field])[:, is_used]
        path = self._filter.run(slots[:3], slots[3:6], slots[6:], is_resting=is_resting)
        self._count(path)
        quaternion, settings = path.quaternion[:, sample], self._filter.settings
        lasting = turn_by_lasting_errors(self.accelerometers, self.field, settings, quaternion, readings)
        covariance = path.turn_covariance[sample] + lasting
        self._compare(readings, quaternion, covariance, is_used)
        codes = np.full(steps.size, flag_codes.AT_REST if is_resting else 0, dtype=np.uint64)
        for path_code, code in _CODES:
            codes[(path.codes[sample] & path_code) != 0] |= np.uint64(code)
        codes |= codes_of_rates(self.gyros.coefficients, gyro)
        codes[steps > 1] |= np.uint64(flag_codes.SAMPLES_LOST)
        codes[~is_used] = flag_codes.NOT_AFTER
        found = answer_of(quaternion, covariance, codes)
        for values in found.columns.values():
            values[~is_used] = np.nan
        pitch_deg, roll_deg = found.columns["pitch_deg"], found.columns["roll_deg"]
        beyond = codes_of_angles(self.accelerometers.coefficients, pitch_deg, None, roll_deg)
        return Answer(found.columns, found.codes | beyond, _REASONS)

    def _count(self, path: FilteredPath) -> None:
        self._innovations += np.nansum(path.force_innovation), np.isfinite(path.force_innovation).sum()
        self._of_field += np.nansum(path.field_innovation), np.isfinite(path.field_innovation).sum()

    def _directions(self, readings: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Return the (3, n) forces and fields, NaN without a magnetometer."""
        force = self._force(readings)
        return force, np.full_like(force, np.nan) if self.field is None else self.field.field_ut(readings)

    def _take_zero(self) -> None:
        """Put the zeros of the rest in the place of the calibration's."""
        assert self._filter is not None
        earth = self.motion.earth
        turning = (0.0, 0.0, 0.0) if earth is None else tuple(earth.rate_rad_s.tolist())
        quaternion = tuple(self._filter.estimate.quaternion.tolist())
        self._offset_v = self.rest.offset_v(np.array(in_body_axes(quaternion, turning)))
        covariance = self.rest.zero_covariance()
        self._zero_sd_rad_s = np.sqrt(np.diag(covariance))
        self._filter.rested(covariance)

    def _zero_covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of the zeros without a rest: calibration, shift since then, the Earth's turn."""
        covariance = self.gyros.calibration_covariance()[:3, :3].copy()
        if self.aiding.zero_sd_dps is not None:
            covariance += np.deg2rad(self.aiding.zero_sd_dps) ** 2 * np.eye(3)
        elif not self.gyros.counts_shift:
            covariance += np.deg2rad(UNSTATED_ZERO_SD_DPS) ** 2 * np.eye(3)
        if self.motion.earth is None:
            covariance += EARTH_RATE_RAD_S**2 * np.eye(3)
        return covariance

    def finish(self) -> Answer:
        """Return nothing: every row is answered at once."""
        return nothing(ANSWERS)

    def _compare(
        self, readings: Mapping[str, FloatArray], quaternion: FloatArray, covariance: FloatArray, is_used: BoolArray
    ) -> None:
        """Add up the normalised errors squared of (4, n) attitudes where the true one is known."""
        if not all(name in readings for name in KNOWN):
            return
        known = np.deg2rad(np.stack([readings[name] for name in KNOWN]))
        # At the start yaw is zero by definition: a covariance without width has no normalised error.
        has_width = np.linalg.eigvalsh(np.nan_to_num(covariance))[:, 0] > LEAST_SPREAD_RAD**2
        rows = np.flatnonzero(is_used & np.isfinite(known).all(axis=0) & has_width)
        back = quaternion[:, rows].T * np.array([-1.0, -1.0, -1.0, 1.0])
        turn = multiply(quaternion_of_cr(known[:, rows]).T, back)
        error = 2.0 * turn[:, :3] * np.where(turn[:, 3:] >= 0.0, 1.0, -1.0)
        normalised = np.einsum("ni,ni->n", error, np.linalg.solve(covariance[rows], error[..., None])[..., 0])
        self._errors += normalised.sum(), rows.size

    def consistency(self) -> str:
        """Return what innovations, zeros, and errors where the truth is known, say of the filter's assumptions."""
        said = [self._innovations_in_words()]
        if self._filter is not None and self._innovations[1]:
            after_rest = self.rest.zero is not None
            said.append(zeros_in_words(self._filter.estimate, self._zero_sd_rad_s, after_rest=after_rest))
        total, count = self._errors
        if count:
            said.append(
                f"mean normalised error of the attitude (NEES) {total / count:.3g} over {int(count)} rows, 3 expected "
                "over many runs: rows of one run go together"
            )
        return "; ".join(said)

    def _innovations_in_words(self) -> str:
        if not self._innovations[1]:
            return "filter: no force was read"
        sentence = f"filter: {mean_in_words('force', self._innovations, '--force-sd-g')}"
        if not self._of_field[1]:
            return sentence
        return f"{sentence}; {mean_in_words('field', self._of_field, '--field-sd-ut')}"

    @property
    def _most_lost(self) -> float:
        """Samples that never came and are carried one by one; after more the filter knows nothing any longer."""
        assert self._clock.interval_s is not None
        return max(60.0 / self._clock.interval_s, 1.0)

    def _force(self, readings: Mapping[str, FloatArray]) -> FloatArray:
        """Return the (3, n) specific force in package axes."""
        package = self.accelerometers
        outputs = {axis: readings[column] for axis, column in package.columns.items()}
        temperature = readings.get("temperature_degc") if package.coefficients.needs_temperature else None
        if temperature is not None:
            temperature = possible_temperatures(temperature)
        force = np.ascontiguousarray(inferred_force(package.coefficients.axes, outputs, temperature).T)
        site = package.site_gravity_mps2
        return force if site is None else force * (package.coefficients.gravity_mps2 / site)

    def _started(self, readings: Mapping[str, FloatArray]) -> AttitudeFilter:
        assert self._clock.interval_s is not None
        force, field = self._directions(readings)
        walk = np.sqrt(np.trace(self.gyros.reading_covariance()) / 3.0 * self._clock.interval_s)
        noise = GyroNoise(float(walk), float(np.deg2rad(self.aiding.bias_walk_dps_per_sqrt_s)))
        field_aid, earth = self.field, self.motion.earth
        settings = FilterSettings(
            self._clock.interval_s,
            noise,
            self.aiding.force_sd_g,
            field_reference_ut=None if field_aid is None else field_aid.reference_ut,
            field_sd_ut=None if field_aid is None else self._field_sd_ut(field_aid, field, readings),
            field_renewed_s=FIELD_RENEWED_S,
            frame_rate_rad_s=None if earth is None else tuple(earth.rate_rad_s.tolist()),
            unknown_frame_rate_rad_s=EARTH_RATE_RAD_S if earth is None else 0.0,
        )
        bias = self._zero_covariance()
        start_rad = self._start_rad(force, field)
        if self.motion.start_sd_deg is not None:
            turn = self.motion.start_covariance()
        else:
            turn = _unstated(start_rad) if field_aid is None else np.deg2rad(UNSTATED_TILT_SD_DEG) ** 2 * np.eye(3)
        covariance = np.block([[turn, np.zeros((3, 3))], [np.zeros((3, 3)), bias]])
        return AttitudeFilter(settings, Estimate(quaternion_of_cr(start_rad), np.zeros(3), covariance))

    def _field_sd_ut(self, aid: FieldAid, field_ut: FloatArray, readings: Mapping[str, FloatArray]) -> float:
        """Return the standard deviation of one component in a row, stated and of the set, at the first field read."""
        good = np.flatnonzero(np.isfinite(field_ut).all(axis=0))[:1]
        if not good.size:
            return aid.sd_ut
        at_first = {name: values[good] for name, values in readings.items()}
        of_set_ut2 = np.trace(lasting_covariance(aid.package, field_ut[:, good].T, at_first)[0]) / 3.0
        return float(np.sqrt(aid.sd_ut**2 + of_set_ut2))

    def _start_rad(self, force: FloatArray, field: FloatArray) -> FloatArray:
        """Return the start that was stated; where none is, what the first force says, and a field of yaw, else 0."""
        if self.motion.start_deg is not None:
            return np.deg2rad(self.motion.start_deg)
        if self.field is not None:
            good = np.flatnonzero(np.isfinite(force).all(axis=0) & np.isfinite(field).all(axis=0))
            found = self.field.start_rad(force[:, good[0]], field[:, good[0]]) if good.size else None
            if found is not None:
                return found
        good = np.flatnonzero(np.isfinite(force).all(axis=0))
        if not good.size:
            return np.zeros(3)
        x, y, z = force[:, good[0]].tolist()
        return np.array([np.arctan2(x, np.hypot(y, z)), 0.0, np.arctan2(-y, -z)])


def _unstated(start_rad: FloatArray) -> FloatArray:
    """Return the covariance of the turn where pitch and roll are uncertain and yaw is what it is said to be."""
    turns = turns_by_angle(start_rad)[:, [0, 2]]
    return np.asarray(np.deg2rad(UNSTATED_TILT_SD_DEG) ** 2 * turns @ turns.T)
