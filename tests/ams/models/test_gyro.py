"""CR's gyro model against differentiated rotation matrices and the report's own table 4."""

import numpy as np
import pytest

from ams.errors import DesignError
from ams.frames import AXES, body_rates_rad_s, euler_rates_rad_s
from ams.models.cr import predict_v
from ams.models.gyro import fit_gyros

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


# CR table 4: (B in V, S in V/(deg/s), A in deg, C in deg), specified.
TABLE_4 = {"x": (0.051, 1.25, 0.14, 0.11), "y": (0.052, 1.26, 0.15, 0.12), "z": (0.053, 1.27, 0.16, 0.13)}


def table_4_motion():
    """Θ, Ψ, Φ = 10 sin 2πft degrees, f = 0.125, 0.0625, 0.25 Hz, 10 s by 0.01 s (CR IV-C)."""
    time_s = np.linspace(0.0, 10.0, 1001)
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * omega
    return 10 * DEG * np.sin(phase), 10 * DEG * omega * np.cos(phase)


def test_table_4_is_recovered_to_every_printed_digit():
    euler, rate = table_4_motion()
    field = body_rates_rad_s(euler, rate)
    outputs = {
        axis: predict_v(axis, np.array([b, s / DEG, a * DEG, c * DEG]), field) for axis, (b, s, a, c) in TABLE_4.items()
    }
    found = fit_gyros(euler, rate, outputs)
    for axis in AXES:
        sensor = found[axis].sensor
        values = (sensor.bias_v, sensor.sensitivity * DEG, sensor.azimuth_rad / DEG, sensor.coning_rad / DEG)
        assert [f"{v:.5f}" for v in values] == [f"{v:.5f}" for v in TABLE_4[axis]]


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


def test_constant_rates_about_one_axis_only_are_refused():
    rate = np.tile([0.0, 0.0, 1.0], (50, 1)) * np.linspace(-1, 1, 50)[:, None]
    with pytest.raises(DesignError, match="about at least two axes"):
        fit_gyros(np.zeros((50, 3)), rate, {"x": np.zeros(50)})


def test_stated_uncertainties_of_a_gyro_are_the_scatter_of_repeated_calibrations():
    rng = np.random.default_rng(15)
    euler, rate = table_4_motion()
    truth = np.array([0.051, 1.25 / DEG, 2.0, 3 * DEG])
    clean = predict_v("x", truth, body_rates_rad_s(euler, rate))
    fits = [fit_gyros(euler, rate, {"x": clean + rng.normal(0, 0.05, clean.size)})["x"] for _ in range(300)]
    for name, true in zip(("bias_v", "sensitivity", "azimuth_rad", "coning_rad"), truth, strict=True):
        values = np.array([getattr(f.sensor, name) for f in fits])
        stated = np.mean([f.standard_uncertainties()[name] for f in fits])
        assert np.std(values) == pytest.approx(stated, rel=0.12)
        assert abs(values.mean() - true) < 4 * stated / np.sqrt(300)
