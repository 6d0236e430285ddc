"""CR's accelerometer model against explicit rotations, a complex step."""

import numpy as np
import pytest
from cr_by_hand import jacobian, predict_v, sensor_from_linear

from ams.frames import AXES
from ams.models.cr import (
    model_gravity_g,
    sensitive_axis,
    sting_gravity_g,
)

DEG = np.pi / 180


# CR (III-B.2) to (III-B.12): a frame is turned, so a vector's components turn the other way.
def turn_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def turn_y(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def turn_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


MISALIGNMENT = {
    "x": lambda azimuth, coning: (turn_y(coning) @ turn_x(azimuth))[0],
    "y": lambda azimuth, coning: (turn_z(coning) @ turn_y(azimuth))[1],
    "z": lambda azimuth, coning: (turn_x(coning) @ turn_z(azimuth))[2],
}


def rotated_output(axis, sensor, pitch, yaw, roll):
    """One output in volts, by nothing but matrices."""
    gravity = turn_x(roll) @ turn_z(yaw) @ turn_y(pitch) @ turn_y(np.pi) @ np.array([0.0, 0.0, -1.0])
    bias, sensitivity, azimuth, coning = sensor
    return bias + sensitivity * MISALIGNMENT[axis](azimuth, coning) @ gravity


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("package", ["sting", "model"])
def test_outputs_are_those_of_explicit_rotations(axis, package):
    rng = np.random.default_rng(11)
    for _ in range(50):
        pitch, yaw, roll = rng.uniform(-np.pi, np.pi, 3)
        roll = 0.0 if package == "sting" else roll
        parameters = np.array([rng.normal(), rng.normal(), *rng.uniform(-np.pi, np.pi, 2)])
        field = model_gravity_g(sting_gravity_g(np.array([pitch]), np.array([yaw])), np.array([roll]))
        expected = rotated_output(axis, parameters, pitch, yaw, roll)
        assert predict_v(axis, parameters, field)[0] == pytest.approx(expected, abs=1e-14)


# The scalar forms as CR prints them, (III-B.27) to (III-B.29), written out once more by hand.
def printed_sting(axis, p, pitch, yaw):
    b, s, a, c = p
    sa, ca, sc, cc = np.sin(a), np.cos(a), np.sin(c), np.cos(c)
    st, ct, sp, cp = np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
    return {
        "x": b + s * (-cc * st * cp + sa * sc * st * sp - ca * sc * ct),
        "y": b + s * (ca * sc * st * cp + cc * st * sp + sa * sc * ct),
        "z": b + s * (-sa * sc * st * cp - ca * sc * st * sp + cc * ct),
    }[axis]


@pytest.mark.parametrize("axis", AXES)
def test_sting_outputs_are_the_printed_scalar_equations(axis):
    pitch, yaw = np.meshgrid(np.linspace(-3, 3, 13), np.linspace(-1.5, 1.5, 7))
    p = np.array([1.2, -0.5, 0.7, 0.3])
    ours = predict_v(axis, p, sting_gravity_g(pitch.ravel(), yaw.ravel()))
    np.testing.assert_allclose(ours, printed_sting(axis, p, pitch.ravel(), yaw.ravel()), atol=1e-15)


@pytest.mark.parametrize("axis", AXES)
def test_jacobian_is_the_complex_step_to_1e_12(axis):
    rng = np.random.default_rng(5)
    field = rng.normal(size=(40, 3))
    p = np.array([1.25, -0.51, 2.0, 0.4])
    step = 1e-30
    for j in range(4):
        shifted = p.astype(complex)
        shifted[j] += 1j * step
        numeric = predict_v(axis, shifted, field).imag / step
        np.testing.assert_allclose(jacobian(axis, p, field)[:, j], numeric, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("axis", AXES)
def test_any_parameters_are_brought_to_the_branch_that_gives_the_same_outputs(axis):
    rng = np.random.default_rng(3)
    field = rng.normal(size=(30, 3))
    for _ in range(200):
        p = np.array([0.3, rng.choice([-1, 1]) * rng.uniform(0.1, 2), *rng.uniform(-7, 7, 2)])
        output = predict_v(axis, p, field)
        sensor = sensor_from_linear(axis, np.array([p[0], *(p[1] * sensitive_axis(axis, *p[2:]))]))
        assert 0 <= sensor.coning_rad <= np.pi / 2
        assert -np.pi <= sensor.azimuth_rad <= np.pi
        again = np.array([sensor.bias_v, sensor.sensitivity, sensor.azimuth_rad, sensor.coning_rad])
        np.testing.assert_allclose(predict_v(axis, again, field), output, atol=1e-12)
