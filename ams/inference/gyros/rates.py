"""From the outputs of gyros to pitch, yaw and roll: integrated from a start, with what the angles have grown to lack.

Attitudes follow from the rates (:mod:`ams.inference.gyros.gyro_package`) by the scan of
:mod:`ams.attitude.rate_scan`, their uncertainty from the set's covariance, the readings' noise and the start by
:mod:`ams.attitude.rate_errors`. A row whose reading is missing is bridged and marked, a row that comes twice is not
used, samples that never came are counted as missing, and where the attitude has grown too uncertain it is withheld:
nothing spoils what comes after.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.attitude import flag_codes
from ams.attitude.earth_rate import EarthRate
from ams.attitude.gyro import Method, path_by_butcher, quaternion_of_cr
from ams.attitude.rate_errors import ErrorGrowth, RateErrors, angle_sds, cr_angles, rotation_matrices
from ams.attitude.rate_scan import Interpolation, RateScan
from ams.attitude.three_axes import LARGEST_SD_RAD
from ams.errors import OutsideValidity
from ams.frames import ANGLES
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rest_at_start import RestAtStart
from ams.inference.rows.angle_stream import Answer, joined, nothing
from ams.inference.rows.sample_clock import LONGEST_TURN_S, SampleClock
from ams.inference.rows.used_beyond import codes_of_rates, codes_of_temperature
from ams.models.possible_temperature import COLUMN

_ANSWERED: Final = ("pitch", "roll", "yaw")
ANSWERS: Final = (*(f"{angle}_{end}" for angle in _ANSWERED for end in ("deg", "sd_deg")), "flag")
LONGEST_GAP_SAMPLES: Final = 100_000
"""Of samples that never came; where more are missing the attitude is unknown all the same."""
_SINGULAR_COS_YAW: Final = 1e-3


@dataclass(frozen=True)
class Motion:
    """Where a motion starts and how it is sampled."""

    rate_hz: float | None = None
    """None: as the column time_s says."""
    interpolation: Interpolation = "cubic"
    start_deg: tuple[float, float, float] | None = None
    """Pitch, yaw, roll; None: as the accelerometers say, and without them 0."""
    start_sd_deg: float | None = None
    """None: of a start that is not stated and that accelerometers correct, 5°; else 0."""
    rest_s: float = 0.0
    """At the beginning, over which nothing turned: the mean of the outputs is their zero."""
    earth: EarthRate | None = None
    """None: the Earth's turn is left in the angles."""
    method: Method = "quaternion"
    """How gyros alone are integrated: by the scan of :mod:`ams.attitude.rate_scan`, or by CR's own, Butcher's."""

    def __post_init__(self) -> None:
        if self.rate_hz is not None and not self.rate_hz > 0.0:
            raise OutsideValidity(f"sampling rate: got {self.rate_hz:g} Hz, allowed above 0 Hz; nothing was computed")
        yaw_deg, sd_deg = self.stated_start_deg[1], self.start_sd_deg or 0.0
        if not (sd_deg >= 0.0 and self.rest_s >= 0.0 and abs(yaw_deg) < 90.0):
            raise OutsideValidity(
                f"start: got yaw {yaw_deg:g}°, a standard deviation of {sd_deg:g}° and "
                f"{self.rest_s:g} s at rest: allowed are yaw within ±90°, and no negative number; nothing was computed"
            )

    @property
    def stated_start_deg(self) -> tuple[float, float, float]:
        return (0.0, 0.0, 0.0) if self.start_deg is None else self.start_deg

    def start_covariance(self) -> FloatArray:
        """Return the (3, 3) covariance of the turn by which a stated start is wrong, in reference axes."""
        return np.asarray(np.deg2rad(self.start_sd_deg or 0.0) ** 2 * np.eye(3))


@dataclass
class _Pending:
    """Rows that wait for their attitude."""

    sample: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """Of each row; that of the row before where it is not used."""
    is_used: BoolArray = field(default_factory=lambda: np.empty(0, dtype=bool))
    codes: flag_codes.Codes = field(default_factory=lambda: np.empty(0, dtype=np.uint32))

    def add(self, sample: IntArray, is_used: BoolArray, codes: flag_codes.Codes) -> None:
        self.sample = np.concatenate([self.sample, sample])
        self.is_used = np.concatenate([self.is_used, is_used])
        self.codes = np.concatenate([self.codes, codes])

    def taken_before(self, sample: int) -> "_Pending":
        """Take the rows whose attitude is known."""
        until = int(np.searchsorted(self.sample, sample))
        taken = _Pending(self.sample[:until], self.is_used[:until], self.codes[:until])
        self.sample, self.is_used, self.codes = self.sample[until:], self.is_used[until:], self.codes[until:]
        return taken


class GyroAngles:
    """An :class:`ams.inference.rows.angle_stream.AngleStream` of one package of gyros."""

    def __init__(self, package: GyroPackage, motion: Motion) -> None:
        self.package, self.motion = package, motion
        self._clock = SampleClock(motion.rate_hz, LONGEST_TURN_S)
        self.rest = RestAtStart(package, motion.rest_s)
        self._offset_v = package.offset_v
        self._errors = RateErrors(
            package.calibration_covariance(),
            package.reading_covariance(),
            motion.start_covariance(),
            further=package.further_factors(),
        )
        self._rested: list[flag_codes.Codes] = []
        """Of rows at rest, which are answered when it is known whether it was one."""
        self._scan: RateScan | None = None
        self._growth: ErrorGrowth | None = None
        self._pending = _Pending()
        self._rates: FloatArray = np.empty((3, 0))
        """Of samples that wait for their attitude; NaN where none was read."""
        self._last_sample, self._settled = -1, 0

    @property
    def needed(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self.package.columns.values()))

    @property
    def optional(self) -> tuple[str, ...]:
        return ("time_s", COLUMN)

    @property
    def answers_at_once(self) -> bool:
        return False

    @property
    def answers(self) -> tuple[str, ...]:
        return ANSWERS

    def answer(self, readings: Mapping[str, FloatArray]) -> Answer:
        """Return the angles that further rows settle. Raises: OutsideValidity without a sampling rate."""
        outputs_v = self.package.outputs_v(readings)
        rows = outputs_v.shape[1]
        if not rows:
            return nothing(ANSWERS)
        steps = self._clock.steps(readings.get("time_s"), rows)
        assert self._clock.interval_s is not None
        resting = self.rest.take(outputs_v, self._clock.interval_s)
        of_temperature = codes_of_temperature([self.package.coefficients], readings)
        outside = np.zeros(rows, dtype=np.uint32) if of_temperature is None else of_temperature
        start = nothing(ANSWERS)
        if resting:
            self._rested.append(outside[:resting])
        if resting and self.rest.zero is not None:
            self._take_zero()
            start = self._start()
        if resting == rows:
            return start
        found = self._turning(outputs_v[:, resting:], steps[resting:], outside[resting:])
        return joined(start, found) if resting else found

    def finish(self) -> Answer:
        """Return the angles still due. Raises: ObservationsError with too few samples."""
        if self._scan is None:
            return self._start() if self._rested else nothing(ANSWERS)
        path = self._scan.finish()
        return self._settle(path.quaternion, path.is_bridged)

    def _take_zero(self) -> None:
        """Put the zeros of the rest in the place of the calibration's."""
        self._offset_v = self.rest.offset_v(self._earth_rate_rad_s())
        calibration = self._errors.calibration.copy()
        calibration[:3, :], calibration[:, :3] = 0.0, 0.0
        calibration[:3, :3] = self.rest.zero_covariance()
        further = self.package.further_factors(from_rest=True)
        start = self._errors.start + self._turned_while_resting()
        self._errors = replace(self._errors, calibration=calibration, start=start, further=further)

    def _turned_while_resting(self) -> FloatArray:
        """Return the (3, 3) covariance, in reference axes, of the turn that a rest which was none may have brought."""
        assert self.rest.zero is not None
        if self.rest.zero.is_still:
            return np.zeros((3, 3))
        turn = self.rest.zero_covariance() * self.motion.rest_s**2
        to_reference = self._start_rotation()
        return np.asarray(to_reference @ turn @ to_reference.T)

    def _start_rotation(self) -> FloatArray:
        """Return the (3, 3) rotation from package axes at the start to those of the reference."""
        start = quaternion_of_cr(np.deg2rad(self.motion.stated_start_deg))
        return np.asarray(rotation_matrices(start[:, None])[0])

    def _earth_rate_rad_s(self) -> FloatArray:
        """Return the (3,) rate that gyros at rest at the start read of the Earth's turn, along package axes."""
        if self.motion.earth is None:
            return np.zeros(3)
        return np.asarray(self._start_rotation().T @ self.motion.earth.rate_rad_s)

    def _start(self) -> Answer:
        """Return the attitude of the start for the rows at rest, with the codes of their temperature."""
        outside, self._rested = np.concatenate(self._rested), []
        rows = outside.size
        angles = np.tile(np.deg2rad(self.motion.stated_start_deg)[:, None], rows)
        codes = self._of_start(outside | np.uint32(flag_codes.AT_REST))
        return _answer(angles, np.broadcast_to(self._errors.start, (rows, 3, 3)), codes)

    def _of_start(self, codes: flag_codes.Codes) -> flag_codes.AnswerCodes:
        """Return the codes of rows, with that of a rest which was none: everything behind it leans on it."""
        if self.rest.zero is None or self.rest.zero.is_still:
            return codes
        return codes.astype(np.uint64) | np.uint64(flag_codes.NO_REST)

    def _turning(self, outputs_v: FloatArray, steps: IntArray, outside: flag_codes.Codes) -> Answer:
        if self._scan is None or self._growth is None:
            assert self._clock.interval_s is not None
            start = quaternion_of_cr(np.deg2rad(self.motion.stated_start_deg))
            way = path_by_butcher if self.motion.method == "butcher" else None
            self._scan = RateScan(start, self._clock.interval_s, self.motion.interpolation, way)
            self._growth = ErrorGrowth(self._errors, self._clock.interval_s)
            steps = np.concatenate([[1], steps[1:]])
        rates = self.package.rates_above(outputs_v - self._offset_v[:, None])
        is_used = steps > 0
        gaps = np.minimum(steps, LONGEST_GAP_SAMPLES)
        sample = self._last_sample + np.cumsum(gaps)
        missing = ~np.isfinite(rates).all(axis=0)
        codes = np.where(missing, flag_codes.NOT_FINITE | flag_codes.RATE_BRIDGED, 0).astype(np.uint32)
        codes |= codes_of_rates(self.package.coefficients, rates) | outside
        codes[steps > 1] |= np.uint32(flag_codes.SAMPLES_LOST)
        codes[steps < 1] = flag_codes.NOT_AFTER
        self._pending.add(sample, is_used, codes)
        slots = np.full((3, int(sample[-1]) - self._last_sample), np.nan)
        slots[:, sample[is_used] - self._last_sample - 1] = rates[:, is_used]
        self._last_sample = int(sample[-1])
        self._rates = np.concatenate([self._rates, slots], axis=1)
        path = self._scan.feed(slots)
        return self._settle(path.quaternion, path.is_bridged)

    def _settle(self, quaternion: FloatArray, is_bridged: BoolArray) -> Answer:
        """Answer the rows whose attitude is known now."""
        assert self._growth is not None
        samples = quaternion.shape[1]
        if not samples:
            return nothing(ANSWERS)
        rates, self._rates = self._rates[:, :samples], self._rates[:, samples:]
        covariance = self._growth.covariance(quaternion, rates, is_bridged)
        first, self._settled = self._settled, self._settled + samples
        if self.motion.earth is not None:
            assert self._clock.interval_s is not None
            time_s = np.asarray((first + np.arange(samples)) * self._clock.interval_s, dtype=float)
            quaternion = self.motion.earth.against_earth(quaternion, time_s)
        rows = self._pending.taken_before(self._settled)
        elapsed = np.where(rows.is_used, rows.sample - first, 0)
        if not elapsed.size:
            return nothing(ANSWERS)
        found = answer_of(quaternion[:, elapsed], covariance[elapsed], self._of_start(rows.codes))
        for values in found.columns.values():
            values[~rows.is_used] = np.nan
        return found


def answer_of(quaternion: FloatArray, covariance: FloatArray, codes: flag_codes.AnswerCodes) -> Answer:
    """Return the angles of (4, n) attitudes with the (n, 3, 3) covariance of their turn."""
    return _answer(cr_angles(quaternion), covariance, codes)


def _answer(angles_rad: FloatArray, covariance: FloatArray, codes: flag_codes.AnswerCodes) -> Answer:
    """Return angles that can be told, in degrees; withhold the others and say why."""
    sds = angle_sds(angles_rad, covariance)
    lost = ~(sds <= LARGEST_SD_RAD)
    aside = np.abs(np.cos(angles_rad[1])) < _SINGULAR_COS_YAW
    codes = codes | np.where(aside, flag_codes.YAW_ASIDE, 0).astype(np.uint32)
    codes |= np.where(lost.any(axis=0) & ~aside, flag_codes.ADRIFT, 0).astype(np.uint32)
    lost[0] |= aside
    lost[2] |= aside
    columns = {}
    for name in _ANSWERED:
        index = ANGLES.index(name)
        columns[f"{name}_deg"] = np.where(lost[index], np.nan, np.rad2deg(angles_rad[index]))
        columns[f"{name}_sd_deg"] = np.where(lost[index], np.nan, np.rad2deg(sds[index]))
    return Answer(columns, codes)
