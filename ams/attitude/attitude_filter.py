"""The Kalman filter over a stream: gyro, specific force and, where there is one, the magnetic field, row by row.

What spoils a row is kept out of the state and marked: a rate that is not a number is bridged by the last one, its
uncertainty growing with the gap; a force or field that is not a number is left out, and so is one that does not agree
with the estimate (a package that accelerates, a magnet nearby); of forces also what follows within ``hold_off_s``,
because a stretch of acceleration passes through values that look like gravity. Row n holds the attitude at sample n;
between samples the rate runs straight. Arrays are channel-first.

A force of the length of gravity that points elsewhere tells of a bias outside its stated spread as much as of an
acceleration, and so does a mean of the innovations that is not zero (:mod:`ams.attitude.innovation_watch`). Such rows
are marked as that. Where they outweigh the others by ``unaided_s``, the estimate is at fault as far as anyone can
tell: tilt and biases are taken as unknown again, gravity leads, and every row from there on is marked.
"""

from dataclasses import dataclass, field
from math import isfinite, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.attitude.innovation_watch import watch_over
from ams.attitude.kalman import (
    Estimate,
    GyroNoise,
    KnownDirection,
    State,
    Triple,
    Weighed,
    carry,
    in_body_axes,
    known_direction,
    state_of,
    take_bias,
    weigh,
    widen,
)
from ams.errors import ObservationsError
from ams.statistics.distributions import chi_square_upper_quantile

Codes = NDArray[np.uint16]

GYRO_BRIDGED: Final = 1
FORCE_MISSING: Final = 2
FORCE_REJECTED: Final = 4
FIELD_MISSING: Final = 8
FIELD_REJECTED: Final = 16
UNAIDED: Final = 32
FORCE_TURNED: Final = 64
CONTRADICTED: Final = 128
WORDS: Final = {
    GYRO_BRIDGED: "gyro bridged",
    FORCE_MISSING: "force missing",
    FORCE_REJECTED: "force rejected: package accelerates",
    FIELD_MISSING: "field missing",
    FIELD_REJECTED: "field rejected",
    UNAIDED: "gravity not seen for too long",
    FORCE_TURNED: "force rejected: bias not as stated, or package accelerates",
    CONTRADICTED: "innovations not white: bias not as stated, or package accelerates",
}
GATE: Final = 16.266
"""Chi-square of three degrees of freedom stays below it in 99.9 %."""


@dataclass(frozen=True)
class FilterSettings:
    """What the sensors do and where the filter is used."""

    interval_s: float
    noise: GyroNoise
    force_sd_g: float
    """Standard deviation of one component, calibration and vibration together."""
    force_reference_g: Triple = (0.0, 0.0, -1.0)
    field_reference_ut: Triple | None = None
    field_sd_ut: float | None = None
    field_renewed_s: float = 0.0
    """In which the errors of the field become others: rows of that time share the weight of one; 0: new in each row."""
    gate: float = GATE
    hold_off_s: float = 0.5
    bridged_rate_sd_rad_s: float = 0.2
    """How wrong the last rate may be while it stands for one that is missing."""
    unaided_s: float = 10.0
    """Without an accepted force for longer than this, rows are marked."""
    watch_s: float = 5.0
    """Over which the mean of the innovations is looked at."""
    frame_rate_rad_s: Triple | None = None
    """Of the reference frame against the stars, along its axes; None: unknown, and in the biases."""
    unknown_frame_rate_rad_s: float = 0.0
    """Length of a rate of the frame that is in the biases: as the package turns it does not stay what it was."""
    renewed_bias_sd_rad_s: float = float(np.deg2rad(0.1))
    """Of biases that gravity contradicted for longer than ``unaided_s``, beside what the tilt tells of them."""

    def __post_init__(self) -> None:
        if not (self.interval_s > 0.0 and self.gate > 0.0):
            raise ObservationsError(
                f"filter: got an interval of {self.interval_s:g} s and a gate of {self.gate:g}: both must be above 0"
            )
        if (self.field_reference_ut is None) != (self.field_sd_ut is None):
            raise ObservationsError("filter: a field needs its reference and its standard deviation; give both or none")

    @property
    def field_share(self) -> float:
        """Of a field whose errors are new, that a row counts for beside its neighbours."""
        return self.interval_s / max(self.field_renewed_s, self.interval_s)


@dataclass(frozen=True)
class FilteredPath:
    """Estimates at n samples."""

    quaternion: FloatArray
    """(4, n)"""
    bias_rad_s: FloatArray
    """(3, n)"""
    sd: FloatArray
    """(6, n): turn about the reference axes (rad), then bias (rad/s)."""
    turn_covariance: FloatArray
    """(n, 3, 3) of the turn about the reference axes."""
    force_innovation: FloatArray
    """(n,) normalised innovation squared, three degrees of freedom; NaN where there was no force."""
    field_innovation: FloatArray
    """(n,)"""
    codes: Codes


@dataclass
class AttitudeFilter:
    """A filter that is fed rows and keeps its state between them."""

    settings: FilterSettings
    estimate: Estimate
    _state: State = field(init=False)
    _rate: Triple | None = field(init=False, default=None)
    _bridged: int = field(init=False, default=0)
    _rejected_until: int = field(init=False, default=-1)
    _unaided: int = field(init=False, default=0)
    _row: int = field(init=False, default=0)
    _refused: int = field(init=False, default=0)
    """Forces refused on end."""
    _off_length: float = field(init=False, default=0.0)
    """Sum over these of how far their length is from the known one, in standard deviations squared."""
    _doubtful: int = field(init=False, default=0)
    """Rows that speak against the estimate less those that do not, 0 at least."""
    _was_renewed: bool = field(init=False, default=False)
    _has_field: bool = field(init=False, default=False)
    """Whether a field was taken: the first counts whole."""

    def __post_init__(self) -> None:
        self._state = state_of(self.estimate)
        settings = self.settings
        self._force = known_direction(np.array(settings.force_reference_g), settings.force_sd_g)
        self._field: KnownDirection | None = None
        if settings.field_reference_ut is not None and settings.field_sd_ut is not None:
            self._field = known_direction(np.array(settings.field_reference_ut), settings.field_sd_ut)
        self._hold_off = round(settings.hold_off_s / settings.interval_s)
        self._most_unaided = round(settings.unaided_s / settings.interval_s)
        self._watch = watch_over(settings.watch_s, settings.interval_s)
        self._frame_bias_v = settings.unknown_frame_rate_rad_s**2 * settings.interval_s
        x, y, z = settings.force_reference_g
        self._length_g = sqrt(x * x + y * y + z * z)

    def run(
        self,
        gyro_rad_s: FloatArray,
        force_g: FloatArray,
        field_ut: FloatArray | None = None,
        *,
        is_resting: bool = False,
    ) -> FilteredPath:
        """Return the estimates at (3, n) further samples; NaN stands for what was not read.

        With ``is_resting`` nothing turns: the gyros are left alone, gravity and the field correct what stands still.
        """
        rows = gyro_rad_s.shape[1]
        fields = np.full((3, rows), np.nan) if field_ut is None else field_ut
        columns = zip(gyro_rad_s.T.tolist(), force_g.T.tolist(), fields.T.tolist(), strict=True)
        variances, turns = np.empty((rows, 6)), np.empty((rows, 3, 3))
        quaternions, biases, found = [], [], []
        for row, (gyro, force, magnetic) in enumerate(columns):
            found.append(self.step(gyro, force, magnetic, is_resting=is_resting))
            quaternions.append(self._state.quaternion)
            biases.append(self._state.bias_rad_s)
            variances[row] = self._state.covariance.diagonal()
            turns[row] = self._state.covariance[:3, :3]
        self.estimate = Estimate(
            np.array(self._state.quaternion), np.array(self._state.bias_rad_s), self._state.covariance
        )
        codes, of_force, of_field = np.array(found, dtype=float).reshape(rows, 3).T
        return FilteredPath(
            np.array(quaternions).reshape(rows, 4).T,
            np.array(biases).reshape(rows, 3).T,
            np.sqrt(variances.T),
            turns,
            of_force,
            of_field,
            codes.astype(np.uint16),
        )

    def rested(self, covariance: FloatArray) -> None:
        """End a rest whose mean rates were taken off as the gyros' zeros, known with this (3, 3) covariance."""
        frame = self.settings.frame_rate_rad_s
        take_bias(self._state, (0.0, 0.0, 0.0), covariance, frame)
        self._rate = (0.0, 0.0, 0.0) if frame is None else in_body_axes(self._state.quaternion, frame)

    def step(
        self, gyro: Triple, force: Triple, magnetic: Triple, *, is_resting: bool = False
    ) -> tuple[int, float, float]:
        """Take one row; return its codes and the normalised innovations of force and field."""
        code = 0 if is_resting else self._carry(gyro)
        self._row += 1
        code_of_force, of_force = self._correct_by_force(force)
        code |= code_of_force
        of_field = float("nan")
        if self._field is not None:
            if _is_finite(magnetic):
                share = self.settings.field_share if self._has_field else 1.0
                of_field = weigh(self._state, magnetic, self._field, self.settings.gate, share=share).normalised
                is_taken = of_field <= self.settings.gate
                self._has_field = self._has_field or is_taken
                code |= 0 if is_taken else FIELD_REJECTED
            else:
                code |= FIELD_MISSING
        return code, of_force, of_field

    def _carry(self, gyro: Triple) -> int:
        last = self._rate
        is_read = _is_finite(gyro)
        if is_read:
            self._rate = gyro
        self._bridged = 0 if is_read else self._bridged + 1
        now = self._rate
        if last is not None and now is not None:
            mean = ((last[0] + now[0]) / 2.0, (last[1] + now[1]) / 2.0, (last[2] + now[2]) / 2.0)
            # A rate that is wrong by a constant turns n intervals by n times its error: the step's share is 2n − 1.
            turn = self.settings.bridged_rate_sd_rad_s * self.settings.interval_s
            self._turn(mean, (2 * self._bridged - 1) * turn**2 if self._bridged else 0.0)
        elif self._row:
            turn = self.settings.bridged_rate_sd_rad_s * self.settings.interval_s
            self._turn(self._state.bias_rad_s, (2 * self._row - 1) * turn**2)
        return 0 if is_read else GYRO_BRIDGED

    def _turn(self, rate: Triple, rate_variance: float) -> None:
        settings, bias_variance = self.settings, 0.0
        if self._frame_bias_v:
            (x, y, z), (b_x, b_y, b_z) = rate, self._state.bias_rad_s
            # A vector that is turned changes by no more than a walk whose variance is its square for each radian.
            bias_variance = self._frame_bias_v * sqrt((x - b_x) ** 2 + (y - b_y) ** 2 + (z - b_z) ** 2)
        carry(
            self._state,
            rate,
            settings.interval_s,
            settings.noise,
            rate_variance,
            bias_variance=bias_variance,
            frame_rate_rad_s=settings.frame_rate_rad_s,
        )

    def _correct_by_force(self, force: Triple) -> tuple[int, float]:
        code, innovation = FORCE_MISSING, float("nan")
        if _is_finite(force):
            # While it is held off a gate that nothing passes keeps the state, and the innovation still renews the wait.
            is_held_off = self._row <= self._rejected_until
            seen = weigh(self._state, force, self._force, -1.0 if is_held_off else self.settings.gate)
            code, innovation = 0, seen.normalised
            if innovation > self.settings.gate:
                self._rejected_until = self._row + self._hold_off
            if is_held_off or innovation > self.settings.gate:
                code = self._code_of_refused(force)
            else:
                self._refused, self._off_length = 0, 0.0
            code |= self._doubted(code, seen)
        self._unaided = self._unaided + 1 if code & (FORCE_MISSING | FORCE_REJECTED | FORCE_TURNED) else 0
        return (code | UNAIDED if self._unaided > self._most_unaided else code), innovation

    def _code_of_refused(self, force: Triple) -> int:
        """Return whether the forces that were refused on end have another length than gravity, or point elsewhere."""
        x, y, z = force
        off = (sqrt(x * x + y * y + z * z) - self._length_g) / self.settings.force_sd_g
        self._refused += 1
        self._off_length += off * off
        # A chi-square of as many degrees of freedom, five of whose standard deviations are spared for vibration.
        is_longer = self._off_length > self._refused + 5.0 * sqrt(2.0 * self._refused) + self.settings.gate
        return FORCE_REJECTED if is_longer else FORCE_TURNED

    def _doubted(self, code: int, seen: Weighed) -> int:
        """Return CONTRADICTED where the estimate is in doubt; after too long let gravity lead."""
        is_doubtful = code == FORCE_TURNED
        if not code:
            is_doubtful = self._watch.contradicts(seen, self._force.sd**2)
        self._doubtful = self._doubtful + 1 if is_doubtful else max(self._doubtful - 1, 0)
        if self._doubtful > self._most_unaided:
            self._renew(seen)
        return CONTRADICTED if self._was_renewed or (is_doubtful and not code) else 0

    def _renew(self, seen: Weighed) -> None:
        """Take tilt and biases as unknown: the tilt by as much as gravity is off, biases by what made it so."""
        x, y, _ = seen.innovation
        tilt = max(sqrt(x * x + y * y), self._watch.mean) / self._length_g
        over_s = self._most_unaided * self.settings.interval_s
        widen(self._state, tilt, sqrt(self.settings.renewed_bias_sd_rad_s**2 + (tilt / over_s) ** 2))
        self._watch.forget()
        self._doubtful, self._rejected_until, self._was_renewed = 0, -1, True
        self._refused, self._off_length = 0, 0.0


def _is_finite(vector: Triple) -> bool:
    x, y, z = vector
    return isfinite(x + y + z)


def mean_band(dof: int, count: int, level: float = 0.999) -> tuple[float, float]:
    """Return the band that the mean of ``count`` chi-squares of ``dof`` degrees of freedom keeps to at the level."""
    share = (1.0 - level) / 2.0
    total = dof * count
    return float(chi_square_upper_quantile(1.0 - share, total)) / count, float(
        chi_square_upper_quantile(share, total)
    ) / count
