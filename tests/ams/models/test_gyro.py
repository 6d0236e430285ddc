"""CR's gyro model against differentiated rotation matrices."""

import numpy as np
import pytest
from cr_by_hand import predict_v

from ams.frames import AXES, body_rates_rad_s, euler_rates_rad_s

DEG = np.pi / 180


def attitude_matrix(euler):
    """From the initial frame to model axes: pitch about y, yaw about the new z, roll about the new x."""
    pitch, yaw, roll = euler
    c, s = np.cos, np.sin
    t_y = np.array([[c(pitch), 0, -s(pitch)], [0, 1, 0], [s(pitch), 0, c(pitch)]])
    t_z = np.array([[c(yaw), s(yaw), 0], [-s(yaw), c(yaw), 0], [0, 0, 1]])
    t_x = np.array([[1, 0, 0], [0, c(roll), s(roll)], [0, -s(roll), c(roll)]])
    return t_x @ t_z @ t_y


def test_body_rates_are_those_of_the_differentiated_rotation_matrix():
    # For components T v of a fixed v: dT/dt = −[ω]× T, whatever the sequence of turns.
    rng = np.random.default_rng(8)
    for _ in range(50):
        euler, rate = rng.uniform(-1.4, 1.4, 3), rng.normal(size=3)
        h = 1e-30
        derivative = attitude_matrix(euler + 1j * h * rate).imag / h
        cross = -derivative @ attitude_matrix(euler).T
        omega = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
        np.testing.assert_allclose(body_rates_rad_s(euler, rate), omega, atol=1e-13)


def test_euler_rates_invert_body_rates():
    rng = np.random.default_rng(9)
    euler, rate = rng.uniform(-1.4, 1.4, (100, 3)), rng.normal(size=(100, 3))
    np.testing.assert_allclose(euler_rates_rad_s(euler, body_rates_rad_s(euler, rate)), rate, atol=1e-12)


@pytest.mark.parametrize("axis", AXES)
def test_outputs_are_the_printed_scalar_equations(axis):
    # CR (III-C.16) to (III-C.18), written out by hand.
    rng = np.random.default_rng(4)
    euler, rate = rng.uniform(-3, 3, (30, 3)), rng.normal(size=(30, 3))
    _, y, f = euler.T
    dt, dy, df = rate.T
    b, s, a, c = 0.05, -1.3, 0.9, 0.25
    sa, ca, sc, cc = np.sin(a), np.cos(a), np.sin(c), np.cos(c)
    sy, cy, sf, cf = np.sin(y), np.cos(y), np.sin(f), np.cos(f)
    printed = {
        "x": (cc * sy + sa * sc * cy * cf + ca * sc * cy * sf) * dt + (sa * sc * sf - ca * sc * cf) * dy + cc * df,
        "y": (-ca * sc * sy + cc * cy * cf - sa * sc * cy * sf) * dt + (cc * sf + sa * sc * cf) * dy - ca * sc * df,
        "z": (sa * sc * sy - ca * sc * cy * cf - cc * cy * sf) * dt + (-ca * sc * sf + cc * cf) * dy + sa * sc * df,
    }[axis]
    ours = predict_v(axis, np.array([b, s, a, c]), body_rates_rad_s(euler, rate))
    np.testing.assert_allclose(ours, b + s * printed, atol=1e-14)
