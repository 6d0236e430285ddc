"""CR's package models as the solvers see them."""

import numpy as np
import pytest
from cr_by_hand import predict_v

from ams.calibration.calibrate import calibrate
from ams.errors import DesignError, ObservationsError
from ams.frames import AXES, Attitude
from ams.inputs.request import CalibrationRequest
from ams.models.cr import CrSensor
from ams.models.pitch_yaw_roll import PitchYawRoll
from ams.observations import Observations


def attitudes(n=60, seed=1):
    pitch, yaw, roll = np.random.default_rng(seed).uniform(-1.4, 1.4, (3, n))
    return Attitude(pitch, roll, yaw)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("package", ["sting", "model"])
def test_solves_for_the_parameters_that_made_the_outputs(axis, package):
    model, rows = PitchYawRoll(axis, package), attitudes()
    truth = CrSensor(axis, 1.25, -0.51, np.deg2rad(175.0), np.deg2rad(3.0))
    field = model.basis(rows)[:, 1:]
    output = predict_v(axis, np.array([1.25, -0.51, truth.azimuth_rad, truth.coning_rad]), field)
    primary = model.start(rows, output)
    np.testing.assert_allclose(model.parameters(primary), [1.25, -0.51, 3.0, 175.0], rtol=1e-11)
    np.testing.assert_allclose(model.predict(primary, rows), output, atol=1e-13)


@pytest.mark.parametrize("package", ["sting", "model"])
def test_angle_derivatives_are_the_complex_step(package):
    model, rows = PitchYawRoll("y", package), attitudes(7)
    primary = np.array([0.1, 0.3, -0.7, 0.2])
    h = 1e-30
    for name in ("pitch", "yaw", "roll"):
        shifted = {f"{n}_rad": getattr(rows, f"{n}_rad").astype(complex) for n in ("pitch", "yaw", "roll")}
        shifted[f"{name}_rad"] = shifted[f"{name}_rad"] + 1j * h
        numeric = (
            model.predict(primary, Attitude(shifted["pitch_rad"], shifted["roll_rad"], shifted["yaw_rad"])).imag / h
        )
        np.testing.assert_allclose(model.angle_jacobian(primary, rows)[name], numeric, rtol=1e-12, atol=1e-15)


def test_roll_does_not_reach_the_sting_package():
    rows = attitudes()
    turned = Attitude(rows.pitch_rad, rows.roll_rad + 1.0, rows.yaw_rad)
    model = PitchYawRoll("z", "sting")
    np.testing.assert_array_equal(model.basis(rows), model.basis(turned))


def test_observations_without_yaw_are_refused_in_words():
    with pytest.raises(ObservationsError, match="column yaw_deg"):
        PitchYawRoll("x").basis(Attitude(np.zeros(3), np.zeros(3)))


def test_only_two_packages_exist():
    with pytest.raises(DesignError, match="allowed 'sting' or 'model'"):
        PitchYawRoll("x", "tunnel")


def test_the_whole_calibration_takes_cr_models():
    rng = np.random.default_rng(0)
    angles = np.meshgrid(
        *(np.deg2rad(a) for a in (np.arange(-30, 31, 10), np.arange(-30, 31, 15), np.arange(-180, 180, 60)))
    )
    pitch, yaw, roll = (angle.ravel() for angle in angles)
    points, n = pitch.size, 4
    truth = {"x": CrSensor("x", 1.25, 0.51, 2.0, 0.05), "z": CrSensor("z", 1.19, -0.54, -1.0, 0.02)}
    models = {axis: PitchYawRoll(axis) for axis in truth}
    clean = {a: models[a].predict(np.array([s.bias_v, *s.k]), Attitude(pitch, roll, yaw)) for a, s in truth.items()}
    outputs = {a: np.tile(v, n) + rng.normal(0, 1e-5, n * points) for a, v in clean.items()}
    rows = Observations(
        np.repeat(np.arange(n), points), np.tile(np.arange(points), n), np.tile(pitch, n), np.tile(roll, n), outputs,
        np.tile(yaw, n),
    )  # fmt: skip
    solved = calibrate(rows, CalibrationRequest(models=models, extended="no"))
    assert (solved.model, solved.convention) == ("pitch-yaw-roll-model", "CR")
    for axis, sensor in truth.items():
        found = {p.name: p for p in solved.axes[axis].parameters}
        for name, value in {
            "offset_v": sensor.bias_v,
            "sensitivity_v_per_g": sensor.sensitivity,
            "coning_deg": np.degrees(sensor.coning_rad),
            "azimuth_deg": np.degrees(sensor.azimuth_rad),
        }.items():
            assert abs(found[name].value - value) < 5 * found[name].standard_uncertainty
