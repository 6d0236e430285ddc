"""Gyros and accelerometers together: truths turned by scipy, stated deviations that cover, stretches not used."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, package_set, tp_set

from ams.errors import OutsideValidity
from ams.frames import body_rates_rad_s
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import Motion
from ams.inference.inference import Package

GYROS, FORCE = gyro_set(), tp_set()
GYRO_V, FORCE_V = {a: f"{a}_v" for a in "xyz"}, {a: f"f{a}_v" for a in "xyz"}
NOISE_V, FORCE_SD_G, RATE_HZ = 0.02, 0.003, 20.0


def scene(chance: np.random.Generator, seconds: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the angles (n, 3) of a motion of random phases, and what the sensors read of it."""
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    omega, phase = 2 * np.pi * chance.uniform(0.01, 0.05, 3), chance.uniform(0, 2 * np.pi, 3)
    size = np.deg2rad(chance.uniform(5, 25, 3))
    euler = size * np.sin(time_s[:, None] * omega + phase)
    euler[:, 1] -= euler[0, 1]
    rates = np.rad2deg(body_rates_rad_s(euler, size * omega * np.cos(time_s[:, None] * omega + phase)))
    force = -Rotation.from_euler("YZX", euler).inv().apply([0.0, 0.0, 1.0])
    readings = {}
    for axis, numbers in GYROS.axes.items():
        clean = numbers.primary["offset_v"] + rates @ numbers.direction
        readings[GYRO_V[axis]] = clean + NOISE_V * chance.normal(size=time_s.size)
    noisy = force + FORCE_SD_G * chance.normal(size=force.shape)
    for axis, numbers in FORCE.axes.items():
        readings[FORCE_V[axis]] = numbers.primary["offset_v"] + noisy @ numbers.direction_v_per_g
    return np.rad2deg(euler), readings


def aided(motion: Motion | None = None) -> AidedAngles:
    gyros = GyroPackage(GYROS, GYRO_V, NOISE_V)
    return AidedAngles(gyros, Package(FORCE, FORCE_V), motion or Motion(RATE_HZ), Aiding(FORCE_SD_G, 1e-6))


def test_stated_deviations_cover_and_the_innovations_are_those_of_the_assumptions() -> None:
    chance = np.random.default_rng(3)
    inside, means = [], []
    for _ in range(60):
        euler, readings = scene(chance, 20.0)
        found = aided()
        answer = found.answer(readings)
        for index, name in enumerate(("pitch", "yaw", "roll")):
            off = np.abs(answer.columns[f"{name}_deg"] - euler[:, index])
            inside += list((off < 1.96 * answer.columns[f"{name}_sd_deg"])[[100, 250, 399]])
        means.append(float(found.consistency().split("force ")[1].split()[0]))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.03)
    assert np.mean(means) == pytest.approx(3.0, abs=0.06)


def test_errors_against_a_known_attitude_are_those_of_the_covariance() -> None:
    """The mean over the ends of many runs is three; here over whole runs, whose rows go together."""
    chance, means = np.random.default_rng(8), []
    aiding = Aiding(FORCE_SD_G, 1e-6, zero_sd_dps=0.05)
    for _ in range(40):
        euler, readings = scene(chance, 10.0)
        zeros_dps = 0.05 * chance.normal(size=3)
        for axis, numbers in GYROS.axes.items():
            readings[GYRO_V[axis]] = readings[GYRO_V[axis]] + numbers.direction @ zeros_dps
        truth = dict(zip(("true_pitch_deg", "true_yaw_deg", "true_roll_deg"), euler.T, strict=True))
        found = AidedAngles(GyroPackage(GYROS, GYRO_V, NOISE_V), Package(FORCE, FORCE_V), Motion(RATE_HZ), aiding)
        found.answer({**readings, **truth})
        means.append(float(found.consistency().split("(NEES) ")[1].split()[0]))
    assert np.mean(means) == pytest.approx(3.0, abs=0.8)


def test_gravity_bounds_what_gyros_alone_lose() -> None:
    chance = np.random.default_rng(4)
    euler, readings = scene(chance, 60.0)
    shifted = {name: values + (0.05 if name in GYRO_V.values() else 0.0) for name, values in readings.items()}
    gyros = GyroPackage(GYROS, GYRO_V, NOISE_V)
    covariance = 1e-6 * np.eye(12)
    gyros.__dict__["calibration_covariance"] = lambda: covariance
    found = AidedAngles(gyros, Package(FORCE, FORCE_V), Motion(RATE_HZ), Aiding(FORCE_SD_G, 1e-6)).answer(shifted)
    off = np.abs(found.columns["pitch_deg"] - euler[:, 0])
    assert off[-200:].max() < 0.3  # 0.05 V is 0.04 °/s: 2.4 degrees in this minute


def test_accelerated_stretches_are_not_used_and_missing_readings_are_told() -> None:
    chance = np.random.default_rng(5)
    euler, readings = scene(chance, 30.0)
    for axis, numbers in FORCE.axes.items():
        readings[FORCE_V[axis]][200:300] += 0.5 * numbers.direction_v_per_g[0]  # half a g along x, for five seconds
    readings["y_v"][400] = np.nan
    readings["fz_v"][420] = np.nan
    found = aided().answer(readings)
    flags = found.flags
    assert set(flags[205:300]) == {"force not used: package accelerates"}
    assert "bridged" in flags[400]
    assert flags[420] == "reading missing or not a number"
    for index, name in enumerate(("pitch", "yaw", "roll")):
        off = np.abs(found.columns[f"{name}_deg"] - euler[:, index])
        assert np.all(off < 5.0 * found.columns[f"{name}_sd_deg"] + 1e-9), name


def test_pieces_make_the_whole() -> None:
    _, readings = scene(np.random.default_rng(6), 5.0)
    once, found = aided().answer(readings), aided()
    parts = [found.answer({n: v[own] for n, v in readings.items()}) for own in np.array_split(np.arange(100), 7)]
    for name, values in once.columns.items():
        np.testing.assert_allclose(np.concatenate([part.columns[name] for part in parts]), values, rtol=1e-12)
    assert np.concatenate([part.codes for part in parts]).tolist() == once.codes.tolist()


def test_sets_that_tell_no_force_are_refused() -> None:
    gyros, sting = GyroPackage(GYROS, GYRO_V, NOISE_V), package_set("sting")
    with pytest.raises(OutsideValidity, match="needed three accelerometers in TP's convention"):
        AidedAngles(gyros, Package(sting, FORCE_V), Motion(RATE_HZ), Aiding())
    with pytest.raises(OutsideValidity, match=r"got a standard deviation of 1e-09 g"):
        Aiding(1e-9)
