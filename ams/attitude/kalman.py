"""SR's Kalman filter: attitude and gyro bias from gyro, gravity and magnetic field.

The state is the quaternion and the gyro bias; the covariance is that of the small turn by which the estimate is wrong
and of the bias, six numbers, so that the quaternion's length never enters. Between samples the gyro carries the
attitude; a measured direction (gravity, or the magnetic field where there is one) corrects it. SR (3) is this
correction in one dimension.

The small turn is counted in the reference frame (true = turn ⊗ estimate). A direction then says nothing about the turn
around itself whatever the estimate is, so without a field the turn about the vertical stays as unknown as it is;
counted in body axes the linearisation drifts with the estimate and the filter talks itself into a heading it never saw.
"""

from dataclasses import dataclass, replace

import numpy as np

from ams.arrays import FloatArray
from ams.attitude.quaternion import advance, from_turn, multiply, normalised, rotation_matrix
from ams.errors import ObservationsError


@dataclass(frozen=True)
class GyroNoise:
    """What the gyro does, as Allan's deviation shows it."""

    angle_random_walk_rad_per_sqrt_s: float
    """White rate noise: the angle's standard deviation after one second."""
    bias_walk_rad_s_per_sqrt_s: float
    """The bias's standard deviation after one second."""


@dataclass(frozen=True)
class Estimate:
    """Attitude and bias after a step."""

    quaternion: FloatArray
    """(4,) body to reference, scalar last."""
    bias_rad_s: FloatArray
    """(3,) in body axes."""
    covariance: FloatArray
    """(6, 6): the small turn in reference axes (rad), then the bias in body axes (rad/s)."""

    def turn_sd_about(self, reference_direction: FloatArray) -> float:
        """Standard deviation of the turn about a direction of the reference frame, such as the vertical, rad."""
        direction = np.asarray(reference_direction, dtype=float)
        direction = direction / np.linalg.norm(direction)
        return float(np.sqrt(direction @ self.covariance[:3, :3] @ direction))


@dataclass(frozen=True)
class Correction:
    """What a measured direction did to the estimate."""

    estimate: Estimate
    normalised_innovation: float
    """Chi-square with three degrees of freedom where the filter's assumptions hold."""


def start_estimate(
    quaternion: FloatArray, turn_sd_rad: float, bias_sd_rad_s: float, bias_rad_s: FloatArray | None = None
) -> Estimate:
    """An estimate to start from; all three turns and all three biases equally uncertain."""
    covariance = np.diag([turn_sd_rad**2] * 3 + [bias_sd_rad_s**2] * 3)
    bias = np.zeros(3) if bias_rad_s is None else np.asarray(bias_rad_s, dtype=float)
    return Estimate(normalised(np.asarray(quaternion, dtype=float)), bias, covariance)


def propagate(estimate: Estimate, gyro_rad_s: FloatArray, interval_s: float, noise: GyroNoise) -> Estimate:
    """The estimate one interval later, the gyro (3,) taken as constant over it."""
    rate = np.asarray(gyro_rad_s, dtype=float) - estimate.bias_rad_s
    halfway = rotation_matrix(advance(estimate.quaternion, rate, interval_s / 2.0))
    F = np.eye(6)
    F[:3, 3:] = -interval_s * halfway
    covariance = F @ estimate.covariance @ F.T + _process_noise(noise, interval_s, halfway)
    return Estimate(advance(estimate.quaternion, rate, interval_s), estimate.bias_rad_s, _symmetric(covariance))


def _process_noise(noise: GyroNoise, interval_s: float, body_to_reference: FloatArray) -> FloatArray:
    walk, drift = noise.angle_random_walk_rad_per_sqrt_s**2, noise.bias_walk_rad_s_per_sqrt_s**2
    added = np.zeros((6, 6))
    added[:3, :3] = (walk * interval_s + drift * interval_s**3 / 3.0) * np.eye(3)
    added[:3, 3:] = -drift * interval_s**2 / 2.0 * body_to_reference
    added[3:, :3] = added[:3, 3:].T
    added[3:, 3:] = drift * interval_s * np.eye(3)
    return added


def correct(
    estimate: Estimate, measured: FloatArray, reference: FloatArray, sd: float, *, gate: float | None = None
) -> Correction:
    """Take a vector measured in body axes whose components in the reference frame are known.

    ``measured`` and ``reference`` are (3,), in the same unit as ``sd``, the standard deviation of one component:
    specific force in g against (0, 0, −1) for z down, or the magnetic field in µT. With ``gate`` a vector whose
    normalised innovation is above it (a package that accelerates, a magnet nearby) is not used: the estimate comes back
    unchanged together with the innovation that says so.
    Raises: ObservationsError for a reference without direction or a standard deviation that is not positive.
    """
    reference, measured = np.asarray(reference, dtype=float), np.asarray(measured, dtype=float)
    if not np.linalg.norm(reference) > 0 or not sd > 0:
        raise ObservationsError(
            f"kalman: got a reference of length {np.linalg.norm(reference):g} and a standard deviation of {sd:g}: "
            "both must be above 0; leave the measurement out where there is none"
        )
    H = np.hstack([_cross_matrix(reference), np.zeros((3, 3))])
    innovation = rotation_matrix(estimate.quaternion) @ measured - reference
    spread = H @ estimate.covariance @ H.T + sd**2 * np.eye(3)
    normalised_innovation = float(innovation @ np.linalg.solve(spread, innovation))
    if gate is not None and normalised_innovation > gate:
        return Correction(estimate, normalised_innovation)
    gain = np.linalg.solve(spread, H @ estimate.covariance).T
    left = np.eye(6) - gain @ H
    covariance = left @ estimate.covariance @ left.T + sd**2 * (gain @ gain.T)
    change = gain @ innovation
    quaternion = normalised(multiply(from_turn(change[:3]), estimate.quaternion))
    better = replace(
        estimate,
        quaternion=quaternion,
        bias_rad_s=estimate.bias_rad_s + change[3:],
        covariance=_symmetric(covariance),
    )
    return Correction(better, normalised_innovation)


def _cross_matrix(v: FloatArray) -> FloatArray:
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _symmetric(matrix: FloatArray) -> FloatArray:
    return np.asarray((matrix + matrix.T) / 2.0)
