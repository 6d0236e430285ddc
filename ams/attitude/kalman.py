"""SR's Kalman filter: attitude and gyro bias from gyro, gravity and magnetic field.

The state is the quaternion and the gyro bias; the covariance is that of the small turn by which the estimate is wrong
and of the bias, six numbers, so that the quaternion's length never enters. Between samples the gyro carries the
attitude; a measured direction (gravity, or the magnetic field where there is one) corrects it. SR (3) is this
correction in one dimension.

The small turn is counted in the reference frame (true = turn ⊗ estimate). A direction then says nothing about the turn
around itself whatever the estimate is, so without a field the turn about the vertical stays as unknown as it is;
counted in body axes the linearisation drifts with the estimate and the filter talks itself into a heading it never saw.
"""

from dataclasses import dataclass
from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from ams.arrays import FloatArray
from ams.errors import ObservationsError

Triple = tuple[float, float, float]
Quadruple = tuple[float, float, float, float]


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


@dataclass
class State:
    """Attitude and bias while a stream runs: plain numbers where a library call would cost more than the sum."""

    quaternion: Quadruple
    bias_rad_s: Triple
    covariance: FloatArray
    """(6, 6) as in :class:`Estimate`; replaced, never written into."""


@dataclass(frozen=True)
class KnownDirection:
    """A vector whose components in the reference frame are known."""

    reference: Triple
    sd: float
    H: FloatArray
    """(3, 6) derivatives of the innovation by turn and bias."""


class Weighed(NamedTuple):
    """What a measured direction said against the estimate."""

    normalised: float
    """Chi-square with three degrees of freedom where the filter's assumptions hold."""
    innovation: Triple
    """Measured less known, in reference axes."""
    spread: list[list[float]]
    """(3, 3) covariance of the innovation by the estimate; the measurement's own is not in it."""


def known_direction(reference: FloatArray, sd: float) -> KnownDirection:
    """Return what :func:`weigh` needs. Raises: ObservationsError without a direction or a positive deviation."""
    if not np.linalg.norm(reference) > 0 or not sd > 0:
        raise ObservationsError(
            f"kalman: got a reference of length {np.linalg.norm(reference):g} and a standard deviation of {sd:g}: "
            "both must be above 0; leave the measurement out where there is none"
        )
    x, y, z = reference.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return KnownDirection((x, y, z), sd, np.hstack([cross, np.zeros((3, 3))]))


def carry(
    state: State,
    gyro_rad_s: Triple,
    interval_s: float,
    noise: GyroNoise,
    rate_variance: float = 0.0,
    *,
    bias_variance: float = 0.0,
    frame_rate_rad_s: Triple | None = None,
) -> None:
    """Move the state one interval on, the gyro taken as constant over it.

    ``rate_variance`` is what a gyro that was not read adds to each turn, in rad²; ``bias_variance`` what the interval
    adds to each bias beside its walk, in (rad/s)²; ``frame_rate_rad_s`` the turn of the reference frame against the
    stars along its own axes, which gyros read and an attitude in the frame does not have.
    """
    (g_x, g_y, g_z), (b_x, b_y, b_z) = gyro_rad_s, state.bias_rad_s
    turn = _half_turn((g_x - b_x) * interval_s, (g_y - b_y) * interval_s, (g_z - b_z) * interval_s)
    halfway = _times(state.quaternion, turn)
    walk, drift = noise.angle_random_walk_rad_per_sqrt_s**2, noise.bias_walk_rad_s_per_sqrt_s**2
    R = _matrix(halfway)
    F = _blocks(1.0, -interval_s, R, 0.0, 1.0)
    angle_v = walk * interval_s + drift * interval_s**3 / 3.0 + rate_variance
    shared = drift * interval_s**2 / -2.0
    ahead = _times(halfway, turn)
    if frame_rate_rad_s is not None:
        x, y, z = (-component * interval_s for component in frame_rate_rad_s)
        back = _half_turn(x, y, z)
        ahead = _times(back, _times(back, ahead))
        # A small turn is a vector of the frame, and seen from the frame it turns back as the attitude does.
        F[:3] = np.array(((1.0, -z, y), (z, 1.0, -x), (-y, x, 1.0))).dot(F[:3])
    covariance = F.dot(state.covariance).dot(F.T)
    covariance += _blocks(angle_v, shared, R, shared, drift * interval_s + bias_variance)
    state.quaternion = _unit(ahead)
    state.covariance = covariance


def weigh(
    state: State, measured: Triple, direction: KnownDirection, gate: float | None = None, *, share: float = 1.0
) -> Weighed:
    """Correct the state by a direction measured in body axes; return its innovation.

    Where the normalised one is above the gate the state stays as it is. ``share``: of a measurement whose errors are
    new, that this one counts for in the state; the gate takes it whole.
    """
    (x, y, z), variance = measured, direction.sd**2
    to_x, to_y, to_z = _matrix(state.quaternion)
    known_x, known_y, known_z = direction.reference
    innovation = (
        to_x[0] * x + to_x[1] * y + to_x[2] * z - known_x,
        to_y[0] * x + to_y[1] * y + to_y[2] * z - known_y,
        to_z[0] * x + to_z[1] * y + to_z[2] * z - known_z,
    )
    H, P = direction.H, state.covariance
    PHt = P.dot(H.T)
    spread: list[list[float]] = H.dot(PHt).tolist()
    inverse = _inverse(spread, variance)
    weighted = [row[0] * innovation[0] + row[1] * innovation[1] + row[2] * innovation[2] for row in inverse]
    normalised_innovation = sum(component * other for component, other in zip(innovation, weighted, strict=True))
    weighed = Weighed(normalised_innovation, innovation, spread)
    if gate is not None and normalised_innovation > gate:
        return weighed
    if share != 1.0:
        inverse = _inverse(spread, variance / share)
        weighted = [row[0] * innovation[0] + row[1] * innovation[1] + row[2] * innovation[2] for row in inverse]
    gain = PHt.dot(np.array(inverse))
    # Symmetric as it stands. What Joseph's form would save shows where the prior is 10⁷ times wider than the reading.
    covariance = P - gain.dot(PHt.T)
    d_x, d_y, d_z, d_bx, d_by, d_bz = PHt.dot(weighted).tolist()
    b_x, b_y, b_z = state.bias_rad_s
    half = _half_turn(d_x, d_y, d_z)
    state.quaternion = _unit(_times(half, _times(half, state.quaternion)))
    state.bias_rad_s = (b_x + d_bx, b_y + d_by, b_z + d_bz)
    state.covariance = covariance
    return weighed


def in_body_axes(quaternion: Quadruple, vector: Triple) -> Triple:
    """Return a vector of the reference axes in those of the body."""
    (a, b, c), (d, e, f), (g, h, i) = _matrix(quaternion)
    x, y, z = vector
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def widen(state: State, turn_sd_rad: float, bias_sd_rad_s: float) -> None:
    """Add to what the state does not know of the turns across the vertical, z, and of every bias."""
    state.covariance = state.covariance + np.diag([turn_sd_rad**2] * 2 + [0.0] + [bias_sd_rad_s**2] * 3)


def take_bias(state: State, bias_rad_s: Triple, covariance: FloatArray, frame_rate_rad_s: Triple | None) -> None:
    """Put a bias that a rest told, with its (3, 3) covariance, in the place of the state's.

    What gyros at rest read of ``frame_rate_rad_s`` was taken off by the estimated attitude: b = b̂ − Rᵀ[ω]ₓ δ.
    """
    P, by_turn = np.zeros((6, 6)), np.zeros((3, 3))
    if frame_rate_rad_s is not None:
        x, y, z = frame_rate_rad_s
        cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
        by_turn = -np.array(_matrix(state.quaternion)).T @ cross
    P[:3, :3] = state.covariance[:3, :3]
    P[3:, :3] = by_turn @ P[:3, :3]
    P[:3, 3:] = P[3:, :3].T
    P[3:, 3:] = covariance + by_turn @ P[:3, :3] @ by_turn.T
    state.bias_rad_s, state.covariance = bias_rad_s, P


def state_of(estimate: Estimate) -> State:
    """Return the state that a stream starts from."""
    return State(tuple(estimate.quaternion.tolist()), tuple(estimate.bias_rad_s.tolist()), estimate.covariance)


def _half_turn(x: float, y: float, z: float) -> Quadruple:
    """Return the quaternion of half the turn, so that its square is the whole."""
    quarter = sqrt(x * x + y * y + z * z) / 4.0
    share = sin(quarter) / quarter / 4.0 if quarter > 1e-9 else 0.25
    return x * share, y * share, z * share, cos(quarter)


def _times(p: Quadruple, q: Quadruple) -> Quadruple:
    """Return :func:`ams.attitude.quaternion.multiply` of plain numbers: thirty times faster for one."""
    a, b, c, d = p
    x, y, z, w = q
    return (
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    )


def _unit(q: Quadruple) -> Quadruple:
    x, y, z, w = q
    length = sqrt(x * x + y * y + z * z + w * w)
    return x / length, y / length, z / length, w / length


def _matrix(q: Quadruple) -> tuple[Triple, Triple, Triple]:
    """Return the rotation from body to reference."""
    x, y, z, s = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - s * z), 2.0 * (x * z + s * y)),
        (2.0 * (x * y + s * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - s * x)),
        (2.0 * (x * z - s * y), 2.0 * (y * z + s * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def _blocks(first: float, upper: float, R: tuple[Triple, Triple, Triple], lower: float, last: float) -> FloatArray:
    """Return (6, 6) of first·1, upper·R, lower·Rᵀ and last·1.

    One array of plain numbers costs less than four blocks.
    """
    (a, b, c), (d, e, f), (g, h, i) = R
    return np.array(
        (
            (first, 0.0, 0.0, upper * a, upper * b, upper * c),
            (0.0, first, 0.0, upper * d, upper * e, upper * f),
            (0.0, 0.0, first, upper * g, upper * h, upper * i),
            (lower * a, lower * d, lower * g, last, 0.0, 0.0),
            (lower * b, lower * e, lower * h, 0.0, last, 0.0),
            (lower * c, lower * f, lower * i, 0.0, 0.0, last),
        )
    )


def _inverse(matrix: list[list[float]], added: float) -> tuple[Triple, Triple, Triple]:
    """Return the inverse of a symmetric (3, 3) matrix with ``added`` on its diagonal."""
    (a, b, c), (_, d, e), (_, _, f) = matrix
    a, d, f = a + added, d + added, f + added
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * first + b * second + c * third
    xx, xy, xz = first / determinant, second / determinant, third / determinant
    yy, yz, zz = (a * f - c * c) / determinant, (b * c - a * e) / determinant, (a * d - b * b) / determinant
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
