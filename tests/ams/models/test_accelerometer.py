"""The accelerometer models against the equations as printed in TP (1), (2), (4) and (5)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pitch_roll_of_tp import primary_from_parameters, primary_from_parameters_jacobian

from ams.calibration.calibrate import calibrate
from ams.errors import DesignError
from ams.frames import Attitude
from ams.inputs.request import CalibrationRequest
from ams.models.accelerometer import (
    PitchOnly,
    PitchRoll,
)
from ams.models.registry import model_named
from ams.observations import Observations

sin, cos = np.sin, np.cos


def printed_x(b, s, o, a, pitch, roll):
    return b + s * (cos(o) * sin(pitch) - sin(o) * cos(pitch) * sin(roll + a))  # TP (2)


def printed_y(b, s, o, a, pitch, roll):  # TP (4)
    return b - s * (cos(o) * sin(roll) * cos(pitch) - sin(o) * (sin(a) * sin(pitch) - cos(a) * cos(roll) * cos(pitch)))


def printed_z(b, s, o, a, pitch, roll):  # TP (5)
    return b - s * (cos(o) * cos(roll) * cos(pitch) - sin(o) * (cos(a) * sin(pitch) - sin(a) * sin(roll) * cos(pitch)))


PRINTED = {"x": printed_x, "y": printed_y, "z": printed_z}
ANGLES = np.random.default_rng(11).uniform(-np.pi, np.pi, (2, 40))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_outputs_are_those_of_the_printed_equations(axis: str) -> None:
    parameters = np.array([0.012, -2.4, 0.31, 2.2])
    outputs = PitchRoll(axis).predict(primary_from_parameters(axis, parameters), Attitude(*ANGLES))
    np.testing.assert_allclose(outputs, PRINTED[axis](*parameters, *ANGLES), rtol=0, atol=4e-15)


@given(
    axis=st.sampled_from("xyz"),
    offset=st.floats(-1.0, 1.0),
    sensitivity=st.floats(0.1, 10.0),
    sign=st.sampled_from([-1.0, 1.0]),
    coning=st.floats(1e-3, 1.5),
    azimuth=st.floats(-3.14159, np.pi),
)
def test_parameters_come_back_on_their_branch(axis, offset, sensitivity, sign, coning, azimuth) -> None:
    wanted = np.array([offset, sign * sensitivity, coning, azimuth])
    found = PitchRoll(axis).parameters(primary_from_parameters(axis, wanted))
    np.testing.assert_allclose(found, [*wanted[:2], *np.rad2deg(wanted[2:])], rtol=1e-12, atol=1e-10)


def test_azimuth_of_minus_half_a_turn_is_given_as_plus() -> None:
    assert PitchRoll("x").parameters(np.array([0.0, 1.0, -0.1, -0.0]))[3] == 180.0


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("sensitivity", [2.5, -2.5])
def test_derivatives_of_the_parameters_agree_with_differences(axis: str, sensitivity: float) -> None:
    model = PitchRoll(axis)
    primary = primary_from_parameters(axis, np.array([0.01, sensitivity, 0.2, -2.5]))
    step = 1e-6
    differences = np.stack(
        [(model.parameters(primary + d) - model.parameters(primary - d)) / (2 * step) for d in step * np.eye(4)], axis=1
    )
    np.testing.assert_allclose(model.parameters_jacobian(primary), differences, atol=2e-8)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_derivatives_by_the_printed_parameters_agree_with_a_complex_step(axis: str) -> None:
    parameters, step = np.array([0.01, -2.4, 0.2, 1.1]), 1e-30
    exact = np.stack([primary_from_parameters(axis, parameters + 1j * d).imag / step for d in step * np.eye(4)], axis=1)
    np.testing.assert_allclose(primary_from_parameters_jacobian(axis, parameters), exact, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("model", [PitchRoll("y"), PitchOnly("x"), PitchOnly("z")])
def test_angle_derivatives_agree_with_differences(model) -> None:
    primary = np.array([0.01, 0.3, -2.0, 0.4])[: len(model.primary_names)]
    pitch, roll = ANGLES if isinstance(model, PitchRoll) else (ANGLES[0], np.zeros(40))
    step, slopes = 1e-6, model.angle_jacobian(primary, Attitude(pitch, roll))
    by_pitch = (
        model.predict(primary, Attitude(pitch + step, roll)) - model.predict(primary, Attitude(pitch - step, roll))
    ) / (2 * step)
    np.testing.assert_allclose(slopes["pitch"], by_pitch, atol=1e-8)
    if isinstance(model, PitchRoll):
        by_roll = (
            model.predict(primary, Attitude(pitch, roll + step)) - model.predict(primary, Attitude(pitch, roll - step))
        ) / (2 * step)
        np.testing.assert_allclose(slopes["roll"], by_roll, atol=1e-8)


def test_without_roll_the_output_is_that_of_tp_1() -> None:
    b, s, phi = 0.02, -2.3, 0.04
    pitch = ANGLES[0]
    model = PitchOnly("x")
    primary = model.start(Attitude(pitch, np.zeros(40)), b + s * sin(pitch - phi))  # TP (1)
    np.testing.assert_allclose(model.parameters(primary), [b, s, np.rad2deg(phi)], atol=1e-12)


def test_without_roll_a_sensor_along_z_is_the_z_sensor_of_tp_5() -> None:
    pitch, phi = ANGLES[0], 0.03
    output = printed_z(0.1, 2.5, phi, 0.0, pitch, 0.0)
    model = PitchOnly("z")
    found = model.parameters(model.start(Attitude(pitch, np.zeros(40)), output))
    np.testing.assert_allclose(found, [0.1, 2.5, -np.rad2deg(phi)], atol=1e-12)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_without_roll_derivatives_agree_with_differences(axis: str) -> None:
    model, primary, step = PitchOnly(axis), np.array([0.01, -2.0, -2.2]), 1e-6
    differences = np.stack(
        [(model.parameters(primary + d) - model.parameters(primary - d)) / (2 * step) for d in step * np.eye(3)], axis=1
    )
    np.testing.assert_allclose(model.parameters_jacobian(primary), differences, atol=2e-8)


def test_without_roll_a_rolled_package_is_refused() -> None:
    with pytest.raises(DesignError, match=r"roll must stay 0°: got 30°.*pitch-roll"):
        PitchOnly("x").basis(Attitude(np.zeros(2), np.deg2rad([0.0, 30.0])))


def test_without_roll_a_sensor_along_y_is_refused() -> None:
    with pytest.raises(DesignError, match="allowed x or z"):
        PitchOnly("y")


def test_coning_within_five_uncertainties_of_zero_is_not_stated() -> None:
    primary = primary_from_parameters("x", np.array([0.0, 2.5, 1e-5, 0.3]))
    loose, tight = np.eye(4) * (2.5 * 3e-6) ** 2, np.eye(4) * (2.5 * 1e-6) ** 2
    assert set(PitchRoll("x").undetermined(primary, loose)) == {"coning_deg", "azimuth_deg"}
    assert not PitchRoll("x").undetermined(primary, tight)


@pytest.mark.parametrize(
    ("name", "axis", "match"),
    [("gyroscope", "x", "allowed gyro, linear"), ("pitch-roll", "w", "x, y or z")],
)
def test_unknown_models_and_axes_are_refused_by_name(name: str, axis: str, match: str) -> None:
    with pytest.raises(DesignError, match=match):
        model_named(name, axis)


@pytest.mark.parametrize("model", ["pitch-roll", "pitch-only"])
def test_an_output_that_does_not_follow_gravity_has_no_angles(model: str) -> None:
    """A constant output (unplugged, stuck) has a sensitivity of rounding, and an axis nowhere."""
    rolls = np.deg2rad([0.0, 120.0, 240.0]) if model == "pitch-roll" else np.zeros(1)
    pitch, roll = (part.ravel() for part in np.meshgrid(np.deg2rad(np.arange(-90.0, 91.0, 30.0)), rolls))
    replication, point = np.repeat([1, 2, 3], pitch.size), np.tile(np.arange(pitch.size), 3)
    outputs = {"x": np.full(point.size, 0.1)}
    rows = Observations(replication, point, np.tile(pitch, 3), np.tile(roll, 3), outputs)
    found = {
        item.name: item.value
        for item in calibrate(rows, CalibrationRequest(model=model, extended="no")).axes["x"].parameters
    }
    angles = ["coning_deg", "azimuth_deg"] if model == "pitch-roll" else ["pitch_misalignment_deg"]
    assert [found[name] for name in angles] == [None] * len(angles)
    assert found["offset_v"] == pytest.approx(0.1)
