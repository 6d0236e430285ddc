"""The filter is honest: its errors are as large as it says, and what it cannot see it says it cannot see."""

import numpy as np
import pytest
from kalman_steps import correct, propagate, start_estimate
from scipy.spatial.transform import Rotation

from ams.attitude.kalman import GyroNoise, carry, state_of, take_bias
from ams.attitude.quaternion import from_turn, multiply
from ams.errors import ObservationsError

DOWN_FORCE_G = np.array([0.0, 0.0, -1.0])  # specific force of a level package, z down
FIELD_UT = np.array([22.0, 3.0, 42.0])  # a northern field, north-east-down
NOISE = GyroNoise(2e-3, 2e-5)
INTERVAL_S = 0.05


def campaign(rng, *, steps, with_field, start_sd=0.1, bias_sd=0.01):
    """One simulated flight; returns the true quaternion, true bias and the filter's last estimate."""
    q_true = Rotation.from_euler("ZYX", [1.0, 0.2, -0.4]).as_quat()
    bias = rng.normal(0, bias_sd, 3)
    estimate = start_estimate(multiply(q_true, from_turn(rng.normal(0, start_sd, 3))), start_sd, bias_sd)
    innovations = []
    for n in range(steps):
        rate = 0.4 * np.array([np.sin(0.03 * n), np.cos(0.05 * n), np.sin(0.02 * n + 1.0)])
        q_true = multiply(q_true, from_turn(rate * INTERVAL_S))
        bias = bias + rng.normal(0, NOISE.bias_walk_rad_s_per_sqrt_s * np.sqrt(INTERVAL_S), 3)
        white = rng.normal(0, NOISE.angle_random_walk_rad_per_sqrt_s / np.sqrt(INTERVAL_S), 3)
        estimate = propagate(estimate, rate + bias + white, INTERVAL_S, NOISE)
        body = Rotation.from_quat(q_true).as_matrix().T
        step = correct(estimate, body @ DOWN_FORCE_G + rng.normal(0, 0.01, 3), DOWN_FORCE_G, 0.01)
        innovations.append(step.normalised_innovation)
        estimate = step.estimate
        if with_field:
            step = correct(estimate, body @ FIELD_UT + rng.normal(0, 0.5, 3), FIELD_UT, 0.5)
            innovations.append(step.normalised_innovation)
            estimate = step.estimate
    return q_true, bias, estimate, np.array(innovations)


def error_of(q_true, bias, estimate):
    turn = (Rotation.from_quat(q_true) * Rotation.from_quat(estimate.quaternion).inv()).as_rotvec()
    return np.concatenate([turn, bias - estimate.bias_rad_s])


def test_errors_are_as_large_as_the_covariance_says():
    rng = np.random.default_rng(21)
    nees, innovations = [], []
    for _ in range(60):
        q_true, bias, estimate, seen = campaign(rng, steps=120, with_field=True)
        error = error_of(q_true, bias, estimate)
        nees.append(error @ np.linalg.solve(estimate.covariance, error))
        innovations.append(seen[40:].mean())
    # chi-square of 6 degrees of freedom, mean of 60: 6 ± 3 √(12/60)
    assert np.mean(nees) == pytest.approx(6.0, abs=1.35)
    assert np.mean(innovations) == pytest.approx(3.0, abs=0.15)


def test_bias_is_found_within_its_stated_spread():
    q_true, bias, estimate, _ = campaign(np.random.default_rng(4), steps=1500, with_field=True)
    error = error_of(q_true, bias, estimate)
    sd = np.sqrt(np.diag(estimate.covariance))
    assert np.all(np.abs(error) < 4 * sd)
    assert np.all(sd[3:] < 0.002)


def test_without_a_field_the_turn_about_the_vertical_stays_unknown():
    rng = np.random.default_rng(5)
    seen = campaign(rng, steps=400, with_field=True)[2]
    unseen = campaign(rng, steps=400, with_field=False)[2]
    (about_x, _, vertical), of_seen = (np.sqrt(np.diag(estimate.covariance)[:3]) for estimate in (unseen, seen))
    assert vertical >= 0.1 * (1 - 1e-9)
    assert of_seen[2] < 0.01
    assert about_x < 0.01


def test_one_correction_of_a_small_turn_is_least_squares():
    # With a vague attitude about x and y, the tilt after one measurement of gravity has the measurement's own spread.
    before = start_estimate(np.array([0.0, 0.0, 0.0, 1.0]), 10.0, 1e-9)
    after = correct(before, DOWN_FORCE_G, DOWN_FORCE_G, 0.01).estimate
    np.testing.assert_allclose(np.sqrt(np.diag(after.covariance)[:3]), [0.01, 0.01, 10.0], rtol=1e-5)


def test_propagation_adds_the_noise_it_was_given():
    estimate = start_estimate(np.array([0.0, 0.0, 0.0, 1.0]), 0.0, 0.0)
    for _ in range(100):
        estimate = propagate(estimate, np.zeros(3), 0.1, GyroNoise(1e-3, 1e-4))
    # closed form after t: angle variance N² t + K² t³/3, bias variance K² t
    np.testing.assert_allclose(np.diag(estimate.covariance)[:3], 1e-6 * 10 + 1e-8 * 1000 / 3, rtol=1e-10)
    np.testing.assert_allclose(np.diag(estimate.covariance)[3:], 1e-8 * 10, rtol=1e-10)


def test_a_vector_beyond_the_gate_is_left_out_and_said():
    before = start_estimate(np.array([0.0, 0.0, 0.0, 1.0]), 0.01, 0.001)
    accelerating = np.array([0.8, 0.0, -1.0])
    result = correct(before, accelerating, DOWN_FORCE_G, 0.01, gate=16.3)
    np.testing.assert_array_equal(result.estimate.quaternion, before.quaternion)
    np.testing.assert_array_equal(result.estimate.covariance, before.covariance)
    assert result.normalised_innovation > 1000


def test_a_missing_field_is_refused_in_words():
    before = start_estimate(np.array([0.0, 0.0, 0.0, 1.0]), 0.01, 0.001)
    with pytest.raises(ObservationsError, match="leave the measurement out"):
        correct(before, np.zeros(3), np.zeros(3), 0.01)


@pytest.mark.parametrize("is_held_by_the_frame", [True, False])
def test_a_frame_that_turns_is_taken_off(is_held_by_the_frame: bool) -> None:
    """One body rests in a frame that turns, the other against the stars; both have a closed form."""
    frame = np.array([4e-3, -2e-3, -6e-3])
    start = Rotation.from_euler("YZX", [0.3, -0.2, 0.9])
    state = state_of(start_estimate(start.as_quat(), 0.0, 0.0))
    state.covariance = np.diag([1e-4, 4e-4, 9e-4, 0.0, 0.0, 0.0])
    gyro = start.inv().apply(frame) if is_held_by_the_frame else np.zeros(3)
    for _ in range(2000):
        carry(state, tuple(gyro.tolist()), 0.1, GyroNoise(0.0, 0.0), frame_rate_rad_s=tuple(frame.tolist()))
    back = Rotation.from_rotvec(-200.0 * frame)
    expected = start if is_held_by_the_frame else back * start
    assert (Rotation.from_quat(state.quaternion) * expected.inv()).magnitude() < 1e-9
    turned = back.as_matrix() @ np.diag([1e-4, 4e-4, 9e-4]) @ back.as_matrix().T
    np.testing.assert_allclose(state.covariance[:3, :3], turned, atol=1e-6)


def test_a_zero_at_rest_is_as_wrong_as_the_attitude_that_the_frame_was_taken_off_by() -> None:
    rng, frame, known = np.random.default_rng(9), (4e-3, -2e-3, -6e-3), Rotation.from_euler("YZX", [0.3, -0.2, 0.9])
    state = state_of(start_estimate(known.as_quat(), 0.05, 1.0))
    take_bias(state, (0.0, 0.0, 0.0), 1e-8 * np.eye(3), frame)
    errors = []
    for turn in rng.normal(0.0, 0.05, (20000, 3)):
        true = Rotation.from_rotvec(turn) * known
        read = true.inv().apply(frame) + rng.normal(0.0, 1e-4, 3)
        errors.append(np.concatenate([turn, known.inv().apply(frame) - read]))
    # A gyro without a bias: what the estimate lacks is what was taken off less what was read.
    np.testing.assert_allclose(np.cov(np.array(errors).T[3:]), state.covariance[3:, 3:], atol=3e-9)
    crossed = np.array(errors).T[:3] @ np.array(errors)[:, 3:] / 20000
    np.testing.assert_allclose(crossed.T, state.covariance[3:, :3], atol=1.5e-6)
