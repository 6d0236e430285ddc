"""The Kalman filter over a stream: gyro, specific force and, where there is one, the magnetic field, row by row.

What spoils a row is kept out of the state and marked: a rate that is not a number is bridged by the last one, its
uncertainty growing with the gap; a force or field that is not a number is left out, and so is one that does not agree
with the estimate (a package that accelerates, a magnet nearby); of forces also what follows within ``hold_off_s``,
because a stretch of acceleration passes through values that look like gravity. Row n holds the attitude at sample n;
between samples the rate runs straight. Arrays are channel-first.
"""

from dataclasses import dataclass, field
from math import isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray
from ams.attitude.kalman import (
    Estimate,
    GyroNoise,
    KnownDirection,
    State,
    Triple,
    carry,
    known_direction,
    state_of,
    weigh,
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
WORDS: Final = {
    GYRO_BRIDGED: "gyro bridged",
    FORCE_MISSING: "force missing",
    FORCE_REJECTED: "force rejected: package accelerates",
    FIELD_MISSING: "field missing",
    FIELD_REJECTED: "field rejected",
    UNAIDED: "gravity not seen for too long",
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
    gate: float = GATE
    hold_off_s: float = 0.5
    bridged_rate_sd_rad_s: float = 0.2
    """How wrong the last rate may be while it stands for one that is missing."""
    unaided_s: float = 10.0
    """Without an accepted force for longer than this, rows are marked."""

    def __post_init__(self) -> None:
        if not (self.interval_s > 0.0 and self.gate > 0.0):
            raise ObservationsError(
                f"filter: got an interval of {self.interval_s:g} s and a gate of {self.gate:g}: both must be above 0"
            )
        if (self.field_reference_ut is None) != (self.field_sd_ut is None):
            raise ObservationsError("filter: a field needs its reference and its standard deviation; give both or none")


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

    def __post_init__(self) -> None:
        self._state = state_of(self.estimate)
        settings = self.settings
        self._force = known_direction(np.array(settings.force_reference_g), settings.force_sd_g)
        self._field: KnownDirection | None = None
        if settings.field_reference_ut is not None and settings.field_sd_ut is not None:
            self._field = known_direction(np.array(settings.field_reference_ut), settings.field_sd_ut)
        self._hold_off = round(settings.hold_off_s / settings.interval_s)
        self._most_unaided = round(settings.unaided_s / settings.interval_s)

    def run(self, gyro_rad_s: FloatArray, force_g: FloatArray, field_ut: FloatArray | None = None) -> FilteredPath:
        """Return the estimates at (3, n) further samples; NaN stands for what was not read."""
        rows = gyro_rad_s.shape[1]
        fields = np.full((3, rows), np.nan) if field_ut is None else field_ut
        columns = zip(gyro_rad_s.T.tolist(), force_g.T.tolist(), fields.T.tolist(), strict=True)
        variances, turns = np.empty((rows, 6)), np.empty((rows, 3, 3))
        quaternions, biases, found = [], [], []
        for row, (gyro, force, magnetic) in enumerate(columns):
            found.append(self.step(gyro, force, magnetic))
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

    def step(self, gyro: Triple, force: Triple, magnetic: Triple) -> tuple[int, float, float]:
        """Take one row; return its codes and the normalised innovations of force and field."""
        code = self._carry(gyro)
        self._row += 1
        code_of_force, of_force = self._correct_by_force(force)
        code |= code_of_force
        of_field = float("nan")
        if self._field is not None:
            if _is_finite(magnetic):
                of_field = weigh(self._state, magnetic, self._field, self.settings.gate)
                code |= FIELD_REJECTED if of_field > self.settings.gate else 0
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
            added = (2 * self._bridged - 1) * turn**2 if self._bridged else 0.0
            carry(self._state, mean, self.settings.interval_s, self.settings.noise, added)
        elif self._row:
            turn = self.settings.bridged_rate_sd_rad_s * self.settings.interval_s
            added = (2 * self._row - 1) * turn**2
            carry(self._state, self._state.bias_rad_s, self.settings.interval_s, self.settings.noise, added)
        return 0 if is_read else GYRO_BRIDGED

    def _correct_by_force(self, force: Triple) -> tuple[int, float]:
        code, innovation = FORCE_MISSING, float("nan")
        if _is_finite(force):
            # While it is held off a gate that nothing passes keeps the state, and the innovation still renews the wait.
            is_held_off = self._row <= self._rejected_until
            innovation = weigh(self._state, force, self._force, -1.0 if is_held_off else self.settings.gate)
            code = 0
            if innovation > self.settings.gate:
                self._rejected_until = self._row + self._hold_off
            if is_held_off or innovation > self.settings.gate:
                code = FORCE_REJECTED
        self._unaided = self._unaided + 1 if code else 0
        return (code | UNAIDED if self._unaided > self._most_unaided else code), innovation


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
