"""Quaternion kinematics against scipy's rotations."""

import numpy as np
from integrated import integrated
from scipy.spatial.transform import Rotation

from ams.attitude.quaternion import multiply

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


def integrate(rates, interval_s, start=IDENTITY):
    """Return (N, 4) quaternions from (N, 3) rates."""
    return integrated(np.asarray(rates).T, start, interval_s).quaternion.T


def random_quaternions(n, seed=1):
    return Rotation.random(n, rng=np.random.default_rng(seed)).as_quat()


def test_the_product_is_that_of_scipy():
    p, q = random_quaternions(20), random_quaternions(20, 2)
    product = (Rotation.from_quat(p) * Rotation.from_quat(q)).as_matrix()
    np.testing.assert_allclose(Rotation.from_quat(multiply(p, q)).as_matrix(), product, atol=1e-14)


def test_a_varying_rate_is_integrated_to_fourth_order():
    # Reference: a fixed matrix path R(t) = Rz(sin t) Ry(0.5 t²) with its body rates by differentiation.
    def true(t):
        return Rotation.from_euler("ZY", np.column_stack([np.sin(t), 0.5 * t**2]))

    def body_rate(t):
        yaw_rate, pitch, pitch_rate = np.cos(t), 0.5 * t**2, t
        return np.column_stack([-np.sin(pitch) * yaw_rate, pitch_rate, np.cos(pitch) * yaw_rate])

    errors = []
    for n in (50, 100, 200):
        t = np.linspace(0.0, 1.5, n + 1)
        # the interpolated rate errs in second order, so compare ends on a rate that is straight between samples
        found = Rotation.from_quat(integrate(body_rate(t), t[1], true(t[:1]).as_quat()[0]))
        errors.append((found[-1] * true(t[-1:])[0].inv()).magnitude())
    assert errors[-1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 1.9


def test_a_rate_straight_between_samples_converges_with_the_fourth_power():
    first, last = np.array([0.5, 0.7, -0.4]), np.array([-0.6, 0.9, 0.8])

    def end(n):
        return Rotation.from_quat(integrate(np.linspace(first, last, n + 1), 2.0 / n)[-1])

    exact = end(2000)
    errors = [(end(n) * exact.inv()).magnitude() for n in (10, 20, 40)]
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 3.8)


def test_length_stays_one_over_a_long_path():
    rates = np.random.default_rng(3).normal(size=(2000, 3))
    np.testing.assert_allclose(np.linalg.norm(integrate(rates, 0.05), axis=1), 1.0, atol=1e-15)
