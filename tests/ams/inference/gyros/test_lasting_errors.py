"""A filter's deviations hold what its sensors are wrong by alike in all rows, and no innovation shows."""

import numpy as np
import pytest
from line_sets import triad_set
from scipy.spatial.transform import Rotation
from solved_sets import gyro_set, tp_set

from ams.attitude.attitude_filter import FilterSettings
from ams.attitude.kalman import GyroNoise
from ams.frames import body_rates_rad_s
from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.field_aid import FieldAid
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.lasting_errors import turn_by_lasting_errors
from ams.inference.gyros.rates import Motion
from ams.inference.inference import Package
from ams.sets.coefficients import CoefficientSet

GYROS = gyro_set()
GYRO_V, FORCE_V = {a: f"{a}_v" for a in "xyz"}, {a: f"f{a}_v" for a in "xyz"}
RATE_HZ, NOISE_V, FORCE_SD_G = 20.0, 0.02, 0.003
SHIFT_G = 0.005
"""Standard deviation of what every offset shifted by."""


def with_shift(shift_g: float) -> CoefficientSet:
    """Return TP's set with an offset shift counted in the covariance of every axis."""
    found = tp_set()
    section = found.document["package"]
    order = section["order"]
    counted = np.zeros((len(order), len(order)))
    for axis, numbers in found.axes.items():
        place = order.index(f"{axis}.offset_v")
        counted[place, place] = (shift_g * np.linalg.norm(numbers.direction_v_per_g)) ** 2
    section["components"]["shift until the next calibration, offset"] = {
        "covariance": counted.tolist(), "degrees_of_freedom": None,
    }  # fmt: skip
    return found


def scene(chance: np.random.Generator, force_set: CoefficientSet) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return angles (n, 3) of 20 s of motion, and what both packages read, every offset of a force shifted."""
    time_s = np.arange(400) / RATE_HZ
    omega, phase = 2 * np.pi * chance.uniform(0.01, 0.05, 3), chance.uniform(0, 2 * np.pi, 3)
    size = np.deg2rad(chance.uniform(5, 25, 3))
    euler = size * np.sin(time_s[:, None] * omega + phase)
    euler[:, 1] -= euler[0, 1]
    rates = np.rad2deg(body_rates_rad_s(euler, size * omega * np.cos(time_s[:, None] * omega + phase)))
    force = -Rotation.from_euler("YZX", euler).inv().apply([0.0, 0.0, 1.0])
    noisy = force + FORCE_SD_G * chance.normal(size=force.shape)
    readings = {
        GYRO_V[a]: n.primary["offset_v"] + rates @ n.direction + NOISE_V * chance.normal(size=time_s.size)
        for a, n in GYROS.axes.items()
    }
    for axis, numbers in force_set.axes.items():
        shift_v = SHIFT_G * np.linalg.norm(numbers.direction_v_per_g) * chance.normal()
        readings[FORCE_V[axis]] = numbers.primary["offset_v"] + noisy @ numbers.direction_v_per_g + shift_v
    return np.rad2deg(euler), readings


def coverage(force_set: CoefficientSet, runs: int = 60) -> float:
    chance, inside = np.random.default_rng(31), []
    for _ in range(runs):
        euler, readings = scene(chance, force_set)
        gyros = GyroPackage(GYROS, GYRO_V, NOISE_V)
        found = AidedAngles(gyros, Package(force_set, FORCE_V), Motion(RATE_HZ), Aiding(FORCE_SD_G, 1e-6)).answer(
            readings
        )
        for index, name in ((0, "pitch"), (2, "roll")):
            off = np.abs(found.columns[f"{name}_deg"] - euler[:, index])
            inside += list((off < 1.96 * found.columns[f"{name}_sd_deg"])[[250, 399]])
    return float(np.mean(inside))


def test_an_offset_that_shifted_as_declared_is_in_the_deviations() -> None:
    """5 mg, 0.29°: without the set's count of it next to nothing is held."""
    assert coverage(with_shift(SHIFT_G)) == pytest.approx(0.95, abs=0.04)
    assert coverage(tp_set(), runs=20) < 0.4


@pytest.mark.parametrize("field_sd_ut", [0.2, 20.0])
@pytest.mark.parametrize("angles_deg", [(0.0, 0.0, 0.0), (30.0, -20.0, 50.0), (-70.0, 10.0, 160.0)])
def test_the_turn_is_that_of_the_attitude_that_fits_wrong_directions_best(
    angles_deg: tuple[float, float, float], field_sd_ut: float
) -> None:
    """Against Wahba's problem, solved by scipy, with the filter's weights and lasting errors of both directions."""
    chance, reference_ut = np.random.default_rng(5), (20.0, 5.0, 40.0)
    rotation = Rotation.from_euler("YZX", angles_deg, degrees=True)
    known, weights = np.array([[0.0, 0.0, -1.0], reference_ut]), [FORCE_SD_G**-2.0, field_sd_ut**-2.0]
    lasting_ut, turns = min(field_sd_ut, 0.5), []
    for _ in range(4000):
        wrong = np.outer([SHIFT_G, lasting_ut], np.ones(3)) * chance.normal(size=(2, 3))
        found = Rotation.align_vectors(known, rotation.inv().apply(known) + wrong, weights)[0]
        turns.append((found * rotation.inv()).as_rotvec())
    settings = FilterSettings(0.05, GyroNoise(1e-4, 1e-6), FORCE_SD_G, (0.0, 0.0, -1.0), reference_ut, field_sd_ut)
    package, quaternion = Package(with_shift(SHIFT_G), FORCE_V), rotation.as_quat()[:, None]
    aid = FieldAid(Package(triad_set(), {a: f"m{a}" for a in "xyz"}), reference_ut, lasting_ut)
    turn = turn_by_lasting_errors(package, aid, settings, quaternion, {})[0]
    np.testing.assert_allclose(turn, np.cov(np.array(turns).T), atol=0.08 * np.abs(turn).max())
    alone = FilterSettings(0.05, GyroNoise(1e-4, 1e-6), FORCE_SD_G)
    assert not turn_by_lasting_errors(package, None, alone, quaternion, {})[0][2].any()
