"""Every set that a row is read by has to be valid for it: temperature, rates and angles, or the flag says so."""

from dataclasses import replace

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from solved_sets import gyro_set, package_set, tp_set

from ams.inference.gyros.aided_rates import AidedAngles, Aiding
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inference.inference import Package, inference
from ams.inference.watch.frozen_outputs import FrozenOutputs
from ams.sets.coefficients import CoefficientSet

OUTSIDE = "temperature outside the validity of the set"
DEGC = np.array([22.0, 31.0, np.nan, 19.0, 24.0, 22.0])
GYRO_V, FORCE_V = {a: f"{a}_v" for a in "xyz"}, {a: f"f{a}_v" for a in "xyz"}


def valid_at(coefficients: CoefficientSet, *degc: float) -> CoefficientSet:
    low, high = degc
    return replace(coefficients, validity=replace(coefficients.validity, temperature_degc=(low, high)))


def standing(rate_dps: float, rows: int = DEGC.size) -> dict[str, np.ndarray]:
    """Return what gyros read that turn about x by one rate, and accelerometers that stand upright."""
    gyros, force = gyro_set().axes, tp_set().axes
    turning = np.array([rate_dps, 0.0, 0.0])
    read = {GYRO_V[a]: axis.primary["offset_v"] + axis.direction @ turning for a, axis in gyros.items()}
    upright = np.array([0.0, 0.0, -1.0])
    read |= {FORCE_V[a]: axis.primary["offset_v"] + axis.direction_v_per_g @ upright for a, axis in force.items()}
    return {name: np.full(rows, value) for name, value in read.items()}


@pytest.mark.parametrize("rest_s", [0.0, 3.0, 1.0], ids=["turning", "at-rest", "first-rows-at-rest"])
def test_gyros_say_at_which_rows_they_were_as_warm_as_never_in_their_calibration(rest_s: float) -> None:
    angles = GyroAngles(GyroPackage(valid_at(gyro_set(), 20.0, 24.0), GYRO_V, 0.02), Motion(2.0, rest_s=rest_s))
    first, last = angles.answer({**standing(0.0), "temperature_degc": DEGC}), angles.finish()
    assert [OUTSIDE in flag for flag in (*first.flags, *last.flags)] == [False, True, False, True, False, False]


@pytest.mark.parametrize("which", ["gyros", "accelerometers"])
def test_the_filter_says_so_of_each_of_its_sets(which: str) -> None:
    gyros, force = gyro_set(), tp_set()
    if which == "gyros":
        gyros = valid_at(gyros, 20.0, 24.0)
    else:
        force = valid_at(force, 20.0, 24.0)
    angles = AidedAngles(GyroPackage(gyros, GYRO_V, 0.02), Package(force, FORCE_V), Motion(2.0), Aiding(0.003, 1e-6))
    found = angles.answer({**standing(0.0), "temperature_degc": DEGC})
    assert [OUTSIDE in flag for flag in found.flags] == [False, True, False, True, False, False]


@pytest.mark.parametrize(("rate_dps", "is_beyond"), [(79.0, False), (81.0, True), (-81.0, True)])
def test_the_filter_says_which_rates_are_beyond_those_of_the_calibration(rate_dps: float, *, is_beyond: bool) -> None:
    """Gyros alone said so; beside accelerometers the same set did not."""
    angles = AidedAngles(GyroPackage(gyro_set(), GYRO_V, 0.02), Package(tp_set(), FORCE_V), Motion(2.0), Aiding(0.003))
    found = angles.answer(standing(rate_dps))
    assert all(("rate outside the validity of the set" in flag) == is_beyond for flag in found.flags)


@pytest.mark.parametrize(("pitch_deg", "is_beyond"), [(29.0, False), (31.0, True)])
def test_the_filter_says_at_which_attitude_its_accelerometers_were_never_calibrated(
    pitch_deg: float, *, is_beyond: bool
) -> None:
    force = tp_set()
    force = replace(force, validity=replace(force.validity, pitch_deg=(-30.0, 30.0)))
    angles = AidedAngles(GyroPackage(gyro_set(), GYRO_V, 0.02), Package(force, FORCE_V), Motion(2.0), Aiding(0.003))
    tilted, pitch = standing(0.0), np.deg2rad(pitch_deg)
    along = np.array([np.sin(pitch), 0.0, -np.cos(pitch)])
    for name, axis in force.axes.items():
        tilted[FORCE_V[name]] = np.full(DEGC.size, axis.primary["offset_v"] + axis.direction_v_per_g @ along)
    found = angles.answer(tilted)
    assert found.columns["pitch_deg"][0] == pytest.approx(pitch_deg, abs=1e-6)
    assert all(("pitch outside the validity of the set" in flag) == is_beyond for flag in found.flags)


def test_the_second_package_is_held_against_its_own_calibration() -> None:
    """The sting package does not sense roll and is valid at any; the model package is valid at −60° to 45°."""
    rolls_deg = (-61.0, -59.0, 44.0, 46.0, 170.0)
    read: dict[str, np.ndarray] = {}
    for package, table in (("sting", TABLE_3_STING), ("model", TABLE_3_MODEL)):
        for axis, truth in table.items():
            volts = [accelerometer_v(axis, truth, (10.0, 5.0, roll_deg), package) for roll_deg in rolls_deg]
            read[f"{package}_{axis}_v"] = np.array(volts)
    read["temperature_degc"] = np.array([22.0, 22.0, 22.0, 22.0, 40.0])
    sting, model = (
        Package(coefficients, {axis: f"{name}_{axis}_v" for axis in coefficients.axes})
        for name, coefficients in (
            ("sting", package_set("sting")),
            ("model", valid_at(package_set("model"), 20.0, 24.0)),
        )
    )
    found = inference(sting, model, reading_sd_v=1e-6).answer(read)
    assert found.columns["roll_deg"] == pytest.approx(rolls_deg, abs=1e-6)
    assert ["roll outside the validity of the set" in flag for flag in found.flags] == [True, False, False, True, True]
    assert [OUTSIDE in flag for flag in found.flags] == [False, False, False, False, True]


def test_rows_without_a_temperature_are_counted() -> None:
    package = Package(valid_at(tp_set(), 20.0, 24.0), FORCE_V)
    read = {name: values for name, values in standing(0.0).items() if name in FORCE_V.values()}
    with_column, without = (FrozenOutputs(inference(package, reading_sd_v=1e-6), {}) for _ in range(2))
    with_column.answer({**read, "temperature_degc": DEGC})
    without.answer(read)
    assert (with_column.rows_without_temperature, without.rows_without_temperature) == (1, 6)
