"""How fast angles from integrated rates grow uncertain.

What is wrong with the rate in body axes turns the attitude by δ, in reference axes: dδ/dt = R δω. A calibration errs
by the same ε in every sample, δω = −K⁻¹(ε_b + ε_K ω), so that δ is linear in ε with the integrals of R and of R ω_x,
R ω_y, R ω_z, and of what nonlinear scale factors add; the readings' own noise is new in every sample and its variances
add up. To a rate that was missing and bridged belongs a turn of its own. δ becomes pitch, yaw and roll through CR's
sequence about y, the new z, the new x.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ams.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class RateErrors:
    """What is not known of three gyros, rates in rad/s along package axes."""

    calibration: FloatArray
    """(3 p, 3 p) covariance of the errors of the rate: constant, by ω_x, by ω_y, by ω_z and by each of ``further``,
    three components each; p = 4 without these."""
    reading: FloatArray
    """(3, 3) covariance of the rate of one sample."""
    start: FloatArray
    """(3, 3) covariance of the turn by which the start is wrong, in reference axes."""
    bridged_rate_sd_rad_s: float = 0.2
    """How wrong a rate may be that stands for one that is missing."""
    further: Callable[[FloatArray], FloatArray] | None = None
    """(q, n) of (3, n) rates, what else errors of the rate go with; NaN where a rate is."""

    def basis(self, rate_rad_s: FloatArray) -> FloatArray:
        """Return the (p, n) factors of the errors at (3, n) rates; one that is missing is taken as zero."""
        known = np.nan_to_num(rate_rad_s)
        further = [] if self.further is None else [self.further(known)]
        return np.concatenate([np.ones((1, rate_rad_s.shape[1])), known, *further])


@dataclass
class ErrorGrowth:
    """The covariance of the attitude along a stream."""

    errors: RateErrors
    interval_s: float
    _gain: FloatArray = field(init=False)
    """(3, 3 p) turn by calibration error so far."""
    _noise: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    _run: int = 0
    """Samples bridged in a row."""

    def __post_init__(self) -> None:
        self._gain = np.zeros((3, self.errors.calibration.shape[0]))

    def covariance(self, quaternion: FloatArray, rate_rad_s: FloatArray, is_bridged: BoolArray) -> FloatArray:
        """Return the (n, 3, 3) covariance of the turn at further (4, n) attitudes with their (3, n) rates."""
        turn = rotation_matrices(quaternion) * self.interval_s
        by_error = np.einsum("nij,bn->nibj", turn, self.errors.basis(rate_rad_s))
        gains = self._gain + np.cumsum(by_error.reshape(-1, *self._gain.shape), axis=0)
        noise = turn @ self.errors.reading @ np.swapaxes(turn, 1, 2)
        run = self._runs(is_bridged)
        missing = np.where(run > 0, 2.0 * run - 1.0, 0.0) * (self.errors.bridged_rate_sd_rad_s * self.interval_s) ** 2
        noise = self._noise + np.cumsum(noise + missing[:, None, None] * np.eye(3), axis=0)
        # What a sample's rate turns belongs to the interval behind it: the attitude at the sample is free of it.
        behind = np.concatenate([self._gain[None], gains[:-1]])
        noise_behind = np.concatenate([self._noise[None], noise[:-1]])
        if run.size:
            self._gain, self._noise, self._run = gains[-1], noise[-1], int(run[-1])
        return np.asarray(
            behind @ self.errors.calibration @ np.swapaxes(behind, 1, 2) + noise_behind + self.errors.start
        )

    def _runs(self, is_bridged: BoolArray) -> FloatArray:
        """Return the (n,) number of each bridged sample in its gap, 0 where it was read."""
        indices = np.arange(is_bridged.size)
        last_good = np.maximum.accumulate(np.where(is_bridged, -1, indices))
        return np.where(is_bridged, np.where(last_good < 0, indices + 1 + self._run, indices - last_good), 0.0)


def rotation_matrices(quaternion: FloatArray) -> FloatArray:
    """Return the (n, 3, 3) rotations, body to reference, of (4, n) quaternions."""
    x, y, z, w = quaternion
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )


def cr_angles(quaternion: FloatArray) -> FloatArray:
    """Return pitch, yaw and roll, (3, n), of (4, n) quaternions: yaw within ±90°, the others within ±180°.

    At yaw ±90° pitch and roll merge; what they then are is for the caller to withhold.
    """
    x, y, z, w = quaternion
    ahead_x, ahead_y, ahead_z = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    roll = np.arctan2(-2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + z * z))
    return np.stack([np.arctan2(-ahead_z, ahead_x), np.arctan2(ahead_y, np.hypot(ahead_x, ahead_z)), roll])


def turns_by_angle(angles_rad: FloatArray) -> FloatArray:
    """Return the (3, 3) turns in reference axes, a column for each of pitch, yaw and roll, per radian of it."""
    pitch, yaw, _ = angles_rad
    s, c = np.sin(pitch), np.cos(pitch)
    return np.array([[0.0, s, c * np.cos(yaw)], [1.0, 0.0, np.sin(yaw)], [0.0, c, -s * np.cos(yaw)]])


def angle_sds(angles_rad: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the (3, n) standard deviations of pitch, yaw and roll from the (n, 3, 3) covariance of the turn."""
    pitch, yaw, _ = angles_rad
    s, c = np.sin(pitch), np.cos(pitch)
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent, secant = np.tan(yaw), 1.0 / np.cos(yaw)
        rows = np.stack(
            [
                np.stack([-tangent * c, np.ones_like(c), tangent * s], axis=-1),
                np.stack([s, np.zeros_like(c), c], axis=-1),
                np.stack([secant * c, np.zeros_like(c), -secant * s], axis=-1),
            ]
        )
        variances = np.einsum("ani,nij,anj->an", rows, covariance, rows)
        # An angle that is known to be what it is said to be may have a variance of rounding below zero.
        return np.asarray(np.sqrt(np.maximum(variances, 0.0)))
