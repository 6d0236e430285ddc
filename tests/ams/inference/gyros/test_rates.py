"""Angles from gyros: CR's profiles by their closed form, bad rows marked and survived, stated deviations that cover."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from cr_outputs import TABLE_4, gyro_v
from scipy.optimize import root
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set

from ams.arrays import FloatArray
from ams.attitude.rate_errors import RateErrors, angle_sds, cr_angles, rotation_matrices, turns_by_angle
from ams.errors import ObservationsError, OutsideValidity
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.rows.angle_stream import Answer
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers, predicted_v

GYROS = gyro_set()
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}


def harmonic(rate_hz: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """CR's harmonic profile: pitch, yaw, roll of 10° at 0.125, 0.0625 and 0.25 Hz, and their rates, (n, 3) degrees."""
    time_s = np.arange(round(rate_hz * seconds) + 1) / rate_hz
    omega = 2 * np.pi * np.array([0.125, 0.0625, 0.25])
    phase = time_s[:, None] * omega
    return 10.0 * np.sin(phase), 10.0 * omega * np.cos(phase)


def ramp(rate_hz: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """All three angles rise steadily: 2, 1 and 3 °/s."""
    time_s = np.arange(round(rate_hz * seconds) + 1) / rate_hz
    rates = np.array([2.0, 1.0, 3.0])
    return time_s[:, None] * rates, np.broadcast_to(rates, (time_s.size, 3))


def volts(euler_deg: np.ndarray, rates_dps: np.ndarray) -> dict[str, np.ndarray]:
    """Return what CR's assumed gyros read, by explicit rotations."""
    rows = list(zip(euler_deg.tolist(), rates_dps.tolist(), strict=True))
    return {f"{a}_v": np.array([gyro_v(a, t, tuple(e), r) for e, r in rows]) for a, t in TABLE_4.items()}


def stream(motion: Motion, reading_sd_v: float = 1e-6) -> GyroAngles:
    return GyroAngles(GyroPackage(GYROS, COLUMNS, reading_sd_v), motion)


def whole(found: GyroAngles, readings: Mapping[str, np.ndarray], pieces: int = 1) -> Answer:
    """Feed the readings in so many pieces and join the answers."""
    indices = np.array_split(np.arange(next(iter(readings.values())).size), pieces)
    parts = [found.answer({name: values[own] for name, values in readings.items()}) for own in indices]
    parts.append(found.finish())
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    return Answer(columns, np.concatenate([part.codes for part in parts]))


def angles(found: Answer) -> np.ndarray:
    return np.stack([found.columns[f"{name}_deg"] for name in ("pitch", "yaw", "roll")], axis=-1)


@pytest.mark.parametrize("profile", [harmonic, ramp])
def test_cr_s_profiles_come_back_at_1_khz(profile) -> None:  # type: ignore[no-untyped-def]
    euler, rates = profile(1000.0, 4.0)
    found = whole(stream(Motion(1000.0)), volts(euler, rates), 7)
    np.testing.assert_allclose(angles(found), euler, atol=1e-9)
    assert set(found.flags) == {""}


def test_holding_the_rate_at_100_hz_shows_the_report_s_error() -> None:
    """CR: 0.16° on its own profile; straight lines and cubics do better by orders."""
    euler, rates = harmonic(100.0, 32.0)
    readings = volts(euler, rates)
    worst = {
        how: np.abs(angles(whole(stream(Motion(100.0, how)), readings)) - euler).max()  # type: ignore[arg-type]
        for how in ("hold", "linear", "cubic")
    }
    assert worst["hold"] == pytest.approx(0.16, abs=0.01)
    assert worst["linear"] < 1e-3
    assert worst["cubic"] < 1e-6


@pytest.mark.parametrize("pieces", [1, 7])
def test_butcher_s_method_says_what_the_quaternion_says(pieces: int) -> None:
    """A fourth-order and a fifth-order method at 100 Hz: what parts them is the higher order's error."""
    euler, rates = harmonic(100.0, 6.0)
    readings = volts(euler, rates)
    readings["x_v"][200] = np.nan
    by_turns = whole(stream(Motion(100.0)), readings)
    by_butcher = whole(stream(Motion(100.0, method="butcher")), readings, pieces)
    assert by_butcher.codes.tolist() == by_turns.codes.tolist()
    np.testing.assert_allclose(angles(by_butcher), angles(by_turns), atol=1e-6)
    np.testing.assert_allclose(angles(by_butcher)[:190], euler[:190], atol=1e-6)


@pytest.mark.parametrize("pieces", [1, 2, 50, 301])
def test_pieces_make_the_whole(pieces: int) -> None:
    euler, rates = harmonic(100.0, 3.0)
    readings = volts(euler, rates)
    readings["y_v"] = readings["y_v"].copy()
    readings["y_v"][[17, 80, 81, 82]] = np.nan
    package = GyroPackage(gyro_set(0.01, np.random.default_rng(2)), COLUMNS, 1e-6)
    once, again = (whole(GyroAngles(package, Motion(100.0)), readings, count) for count in (1, pieces))
    assert again.codes.tolist() == once.codes.tolist()
    for name, values in once.columns.items():
        np.testing.assert_allclose(again.columns[name], values, rtol=1e-9, atol=1e-12, err_msg=name)


def test_a_missing_reading_is_bridged_marked_and_paid_for() -> None:
    euler, rates = harmonic(100.0, 3.0)
    readings = volts(euler, rates)
    good = whole(stream(Motion(100.0)), readings)
    readings["x_v"] = readings["x_v"].copy()
    readings["x_v"][150:153] = np.nan
    found = whole(stream(Motion(100.0)), readings)
    assert {row for row, flag in enumerate(found.flags) if flag} == {150, 151, 152}
    assert "bridged" in found.flags[150]
    np.testing.assert_allclose(angles(found), euler, atol=1e-3)
    sd, without = found.columns["roll_sd_deg"], good.columns["roll_sd_deg"]
    np.testing.assert_allclose(sd[:150], without[:150])
    # 0.2 rad/s over three intervals of 10 ms, wrong by one constant: 0.34 degrees, and it stays
    assert sd[-1] == pytest.approx(np.rad2deg(0.2 * 0.03), rel=0.05)


def test_gaps_duplicates_and_times_that_go_back_are_told_and_spoil_nothing() -> None:
    euler, rates = harmonic(100.0, 4.0)
    readings = {**volts(euler, rates), "time_s": np.arange(401) / 100.0}
    order = np.delete(np.arange(401), np.arange(200, 205))
    order = np.insert(order, 100, 99)
    order = np.insert(order, 300, 50)
    found = whole(stream(Motion()), {name: values[order] for name, values in readings.items()}, 9)
    flags = dict(enumerate(found.flags))
    said = {row: flag for row, flag in flags.items() if flag}
    assert said == {
        100: "time is not after the row before: not used",
        201: "samples missing before this row",
        300: "time is not after the row before: not used",
    }
    used = np.isfinite(found.columns["pitch_deg"])
    assert np.flatnonzero(~used).tolist() == [100, 300]
    np.testing.assert_allclose(angles(found)[used], euler[order][used], atol=2e-3)


@pytest.mark.parametrize("rows", [50, 73, 601])
def test_the_zero_is_taken_at_rest(rows: int) -> None:
    """Also where the rest ends with a piece."""
    euler, rates = harmonic(100.0, 4.0)
    at_rest = np.tile(euler[:1], (200, 1)), np.zeros((200, 3))
    readings = volts(np.concatenate([at_rest[0], euler]), np.concatenate([at_rest[1], rates]))
    shifted = {name: values + 0.003 for name, values in readings.items()}
    turning = stream(Motion(100.0, rest_s=2.0))
    parts = [turning.answer({n: v[at : at + rows] for n, v in shifted.items()}) for at in range(0, 601, rows)]
    parts.append(turning.finish())
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    found = Answer(columns, np.concatenate([part.codes for part in parts]))
    assert set(found.flags[:200]) == {"at rest: attitude of the start"}
    np.testing.assert_allclose(angles(found)[200:], euler, atol=1e-6)
    untouched = whole(stream(Motion(100.0)), {name: values[200:] for name, values in shifted.items()})
    assert np.abs(angles(untouched) - euler).max() > 0.005


@pytest.mark.parametrize("pieces", [1, 13])
@pytest.mark.parametrize("part", [0.1, 0.33, 0.7])
@pytest.mark.parametrize("rate_dps", [0.003, 0.02, 0.2, 3.0])
def test_a_rest_over_which_the_package_turned_is_told_in_every_row(rate_dps: float, part: float, pieces: int) -> None:
    """It rolls over the last part of a rest of 15 s and 5 s beyond: 0.02° ± 0.005° was told where it stood at 15°."""
    time_s = np.arange(3001) / 100.0
    begins, ends = 15.0 * (1.0 - part), 20.0
    rolling = (time_s >= begins) & (time_s <= ends)
    roll = rate_dps * (np.clip(time_s, begins, ends) - begins)
    euler = np.stack([np.zeros_like(roll), np.zeros_like(roll), roll], axis=-1)
    chance = np.random.default_rng(7)
    readings = volts(euler, np.where(rolling[:, None], [0.0, 0.0, rate_dps], 0.0))
    readings = {name: values + 1e-4 * chance.standard_normal(values.size) for name, values in readings.items()}
    found = whole(stream(Motion(100.0, rest_s=15.0), 1e-4), readings, pieces)
    assert found.codes.size == time_s.size
    assert all("start: it did not rest" in flag for flag in found.flags)
    told, sd = found.columns["roll_deg"], found.columns["roll_sd_deg"]
    is_told = np.isfinite(told)
    assert np.all(np.abs(told - roll)[is_told] <= 2.0 * sd[is_told])


def test_beside_yaw_90_pitch_and_roll_are_withheld_and_come_back() -> None:
    yaw = np.arange(0.0, 180.25, 0.25)
    nothing = np.zeros_like(yaw)
    readings = volts(np.stack([nothing, yaw, nothing], axis=-1), np.tile([0.0, 25.0, 0.0], (yaw.size, 1)))
    found = whole(stream(Motion(100.0)), readings)
    aside = np.abs(yaw - 90.0) < 0.05
    assert np.isnan(found.columns["pitch_deg"]).tolist() == aside.tolist()
    assert found.flags[int(np.argmax(aside))] == "pitch and roll singular: yaw near ±90°"
    turned = Rotation.from_euler("YZX", np.nan_to_num(angles(found)), degrees=True).as_matrix()
    expected = Rotation.from_euler("Z", yaw[:, None], degrees=True).as_matrix()
    np.testing.assert_allclose(turned[~aside], expected[~aside], atol=1e-9)


def test_rates_beyond_the_calibration_are_flagged_and_a_drifted_attitude_withheld() -> None:
    euler, rates = ramp(100.0, 2.0)
    fast = volts(euler, rates * 30.0)
    assert set(whole(stream(Motion(100.0)), fast).flags) == {"rate outside the validity of the set"}
    lost = whole(stream(Motion(100.0, start_sd_deg=6.0)), volts(euler, rates))
    assert np.isnan(lost.columns["pitch_deg"]).all()
    assert set(lost.flags) == {"attitude unknown: grown uncertain"}


def test_stated_deviations_cover_calibration_start_and_noise() -> None:
    """Sets solved from noisy calibrations, readings and starts drawn as stated; the truth is the motion itself."""
    chance, noise_v, start_sd_deg = np.random.default_rng(5), 0.02, 0.03
    euler, rates = harmonic(20.0, 6.0)
    clean = volts(euler, 4.0 * rates)
    truth = whole(stream(Motion(20.0)), clean)
    expected = angles(truth)
    inside = []
    for _ in range(80):
        package = GyroPackage(gyro_set(noise_v, chance), COLUMNS, noise_v)
        readings = {name: values + noise_v * chance.normal(size=values.size) for name, values in clean.items()}
        start = Rotation.from_rotvec(np.deg2rad(start_sd_deg) * chance.normal(size=3))
        found = whole(GyroAngles(package, Motion(20.0, "cubic", _cr_deg(start), start_sd_deg)), readings)
        sd = np.stack([found.columns[f"{name}_sd_deg"] for name in ("pitch", "yaw", "roll")], axis=-1)
        inside.append(np.abs(angles(found) - expected)[[20, 60, 120]] < 2.0 * sd[[20, 60, 120]])
    assert np.mean(inside) == pytest.approx(0.95, abs=0.03)


def test_errors_of_the_rate_are_those_of_the_parameters() -> None:
    """Every parameter of the set's own equation moved a little, the rates solved anew by scipy, at rates drawn."""
    coefficients = gyro_set(1e-4, np.random.default_rng(3))
    package = GyroPackage(coefficients, COLUMNS, 1e-4)
    section = coefficients.document["package"]
    assert isinstance(section, dict)
    covariance = sum(np.array(part["covariance"]) for part in section["components"].values())
    names = [name.split(".") for name in section["order"]]
    assert {name for _, name in names} > {"k2_v_per_dps2", "k3_v_per_dps3"}
    further = package.further_factors()
    assert further is not None
    errors = RateErrors(package.calibration_covariance(), np.eye(3), np.eye(3), further=further)
    for rate_dps in np.random.default_rng(4).uniform(-60.0, 60.0, (5, 3)):
        outputs = np.array([predicted_v(axis, rate_dps, None) for axis in coefficients.axes.values()])
        columns = []
        for own, name in names:
            step = 1e-3 * np.sqrt(covariance[names.index([own, name]), names.index([own, name])])
            solved = [_solved_dps(_moved(coefficients, own, name, sign * step), outputs, rate_dps) for sign in (1, -1)]
            columns.append(np.deg2rad(solved[0] - solved[1]) / (2.0 * step))
        derivatives = np.stack(columns, axis=-1)
        expected = derivatives @ covariance @ derivatives.T
        gain = np.kron(errors.basis(np.deg2rad(rate_dps)[:, None])[:, 0], np.eye(3))
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(gain @ errors.calibration @ gain.T / scale, expected / scale, atol=1e-3)


def _moved(coefficients: CoefficientSet, own: str, name: str, step: float) -> list[AxisNumbers]:
    return [
        replace(numbers, primary={**numbers.primary, name: numbers.primary[name] + step}) if axis == own else numbers
        for axis, numbers in coefficients.axes.items()
    ]


def _solved_dps(axes: list[AxisNumbers], outputs: FloatArray, start_dps: FloatArray) -> FloatArray:
    found = root(lambda rate: [predicted_v(axis, rate, None) for axis in axes] - outputs, start_dps, tol=1e-14)
    return np.asarray(found.x)


def test_a_bent_gyro_tells_the_rate_that_its_equation_says() -> None:
    """A scale factor that changes by 2 % at 60 °/s: far more than any gyro's, and still found."""
    coefficients = gyro_set(1e-4, np.random.default_rng(3))
    bent = {
        axis: replace(numbers, primary={**numbers.primary, "k3_v_per_dps3": 0.02 * 1.26 / 60.0**2})
        for axis, numbers in coefficients.axes.items()
    }
    package = GyroPackage(replace(coefficients, axes=bent), COLUMNS, 1e-4)
    rates_dps = np.random.default_rng(5).uniform(-60.0, 60.0, (50, 3))
    readings = {COLUMNS[axis]: predicted_v(numbers, rates_dps, None) for axis, numbers in bent.items()}
    np.testing.assert_allclose(np.rad2deg(package.rates_rad_s(readings).T), rates_dps, atol=1e-9)
    still = np.array([float(predicted_v(numbers, np.zeros(3), None)) for numbers in bent.values()])
    np.testing.assert_allclose(package.at_rest_v, still, atol=1e-15)


def test_after_a_rest_the_zero_is_as_uncertain_as_its_mean() -> None:
    """Standing still: σ² t (h + t/N) of each angle, N readings of the rest, h the interval."""
    sd_v, seconds = 0.01, 4.0
    still = volts(np.zeros((200 + 401, 3)), np.zeros((601, 3)))
    package = GyroPackage(gyro_set(1.0, np.random.default_rng(1)), COLUMNS, sd_v)
    found = whole(GyroAngles(package, Motion(100.0, rest_s=2.0)), still)
    sigma_dps = sd_v * np.linalg.norm(np.linalg.inv(package.k_v_per_rad_s), axis=1)
    expected = np.rad2deg(sigma_dps) * np.sqrt(seconds * (0.01 + seconds / 200))
    names = ("roll", "pitch", "yaw")  # the turns about x, y and z
    assert [found.columns[f"{name}_sd_deg"][-1] for name in names] == pytest.approx(expected, rel=1e-3)


def _cr_deg(turn: Rotation) -> tuple[float, float, float]:
    pitch, yaw, roll = turn.as_euler("YZX", degrees=True).tolist()
    return pitch, yaw, roll


def test_a_turn_of_the_reference_becomes_angles_as_scipy_turns_them() -> None:
    chance = np.random.default_rng(1)
    euler = np.stack([chance.uniform(-3, 3, 30), chance.uniform(-1.4, 1.4, 30), chance.uniform(-3, 3, 30)])
    turns = Rotation.from_euler("YZX", euler.T)
    np.testing.assert_allclose(cr_angles(turns.as_quat().T), euler, atol=1e-12)
    np.testing.assert_allclose(rotation_matrices(turns.as_quat().T), turns.as_matrix(), atol=1e-12)
    inverse = np.stack([turns_by_angle(own) for own in euler.T])
    step = 1e-6
    for axis in np.eye(3):
        moved = cr_angles((Rotation.from_rotvec(step * axis) * turns).as_quat().T) - euler
        sds = angle_sds(euler, np.broadcast_to(np.outer(axis, axis), (30, 3, 3)))
        np.testing.assert_allclose(sds, np.abs(moved) / step, atol=1e-4)
        np.testing.assert_allclose(np.einsum("nij,jn->ni", inverse, moved / step), np.tile(axis, (30, 1)), atol=1e-4)


def test_what_cannot_be_integrated_is_a_sentence() -> None:
    readings = volts(*ramp(100.0, 0.1))
    with pytest.raises(OutsideValidity, match="interval between samples is not known"):
        stream(Motion()).answer(readings)
    with pytest.raises(OutsideValidity, match="needed three gyros"):
        GyroPackage(GYROS, {"x": "x_v"})
    with pytest.raises(OutsideValidity, match="sampling rate: got 0 Hz"):
        Motion(0.0)
    with pytest.raises(ObservationsError, match="needs 4 samples or more"):
        whole(stream(Motion(100.0)), {name: values[:2] for name, values in readings.items()})
