"""The gyro as a model for the solvers: derivatives by a complex step, intervals that cover."""

import numpy as np
import pytest
from cr_by_hand import predict_v
from cr_outputs import TABLE_4

from ams.calibration.calibrate import calibrate
from ams.errors import ObservationsError
from ams.frames import Attitude, body_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.models.gyro import Gyro
from ams.observations import Observations

DEG = np.pi / 180


def motion(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    chance = np.random.default_rng(seed)
    return chance.uniform(-1.2, 1.2, (count, 3)), chance.uniform(-2.0, 2.0, (count, 3))


@pytest.mark.parametrize("axis", "xyz")
def test_prediction_and_its_slopes_by_angle_are_crs(axis: str) -> None:
    b, s, a, c = TABLE_4[axis]
    parameters = np.array([b, s / DEG, a * DEG, c * DEG])
    euler, rate = motion(30, 4)
    model, attitude = Gyro(axis), Attitude(euler[:, 0], euler[:, 2], euler[:, 1], euler_rate_rad_s=rate)
    clean = predict_v(axis, parameters, body_rates_rad_s(euler, rate))
    primary = np.linalg.lstsq(model.basis(attitude), clean, rcond=None)[0]
    np.testing.assert_allclose(model.predict(primary, attitude), clean, rtol=1e-11)
    np.testing.assert_allclose(model.parameters(primary), [b, s, c, a], rtol=1e-9)
    slopes, step = model.angle_jacobian(primary, attitude), 1e-30
    for index, name in enumerate(("pitch", "yaw", "roll")):
        shifted = euler.astype(complex)
        shifted[:, index] += 1j * step
        numeric = predict_v(axis, parameters, body_rates_rad_s(shifted, rate)).imag / step
        np.testing.assert_allclose(slopes[name], numeric, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("campaigns", "tolerance"), [(150, 0.054), pytest.param(600, 0.027, marks=pytest.mark.thorough)]
)
def test_intervals_of_a_gyro_cover(campaigns: int, tolerance: float) -> None:
    chance, (euler, rate) = np.random.default_rng(5), motion(30, 6)
    clean = predict_v("y", np.array([0.05, 1.26 / DEG, 0.6, 5 * DEG]), body_rates_rad_s(euler, rate))
    euler6, rate6 = np.tile(euler, (5, 1)), np.tile(rate, (5, 1))
    truth = {"offset_v": 0.05, "sensitivity_v_per_dps": 1.26, "coning_deg": 5.0, "azimuth_deg": np.degrees(0.6)}
    held: dict[str, list[bool]] = {name: [] for name in truth}
    for _ in range(campaigns):
        rows = Observations(
            np.repeat(np.arange(5), 30), np.tile(np.arange(30), 5), euler6[:, 0], euler6[:, 2],
            {"y": np.tile(clean, 5) + chance.normal(0.0, 0.5, 150)}, yaw_rad=euler6[:, 1], euler_rate_rad_s=rate6,
        )  # fmt: skip
        for estimate in calibrate(rows, CalibrationRequest(model="gyro")).axes["y"].parameters:
            if estimate.name not in truth:
                continue  # a nonlinearity
            low, high = estimate.interval_95
            held[estimate.name].append(low < truth[estimate.name] < high)
    for name, inside in held.items():
        assert np.mean(inside) == pytest.approx(0.95, abs=tolerance), name


def test_an_accelerometers_rows_are_refused() -> None:
    with pytest.raises(ObservationsError, match="pitch_rate_dps, yaw_rate_dps and roll_rate_dps"):
        Gyro("x").basis(Attitude(np.zeros(3), np.zeros(3)))
