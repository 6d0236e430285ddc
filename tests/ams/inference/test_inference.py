"""Angles from sets: explicit rotations come back, stated standard deviations cover, singular attitudes are named."""

import numpy as np
import pytest
from cr_outputs import TABLE_3_MODEL, TABLE_3_STING, accelerometer_v
from package_outputs import TRUTH, output_v
from solved_sets import package_set, tp_set
from stated_lines import line_sensor

from ams.attitude import flag_codes
from ams.calibration.calibrate import calibrate
from ams.calibration_result import VarianceComponent
from ams.errors import OutsideValidity
from ams.inference.inference import Inference, Package, inference
from ams.inference.package.packages import angles_from_sting
from ams.inference.watch.doubts import doubts_of
from ams.inference.watch.faulty_axis import Cause
from ams.inference.watch.watched_axes import WatchedAxes
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations
from ams.sets.coefficients import CoefficientSet, build_set
from ams.sets.provenance import Provenance

ATTITUDES = [(-35.0, -20.0), (5.0, 60.0), (12.5, -75.0), (40.0, 30.0), (0.0, 0.0)]


def packaged(coefficients: CoefficientSet, prefix: str = "") -> Package:
    return Package(coefficients, {axis: f"{prefix}{axis}_v" for axis in coefficients.axes})


def tp_readings(axes: str, attitudes: list[tuple[float, float]]) -> dict[str, np.ndarray]:
    return {f"{axis}_v": np.array([output_v(axis, TRUTH[axis], p, r) for p, r in attitudes]) for axis in axes}


@pytest.mark.parametrize("axes", ["xyz", "xy", "xz", "x"])
def test_angles_of_explicit_rotations_come_back(axes: str) -> None:
    attitudes = [(p, r) for p, r in ATTITUDES if not (axes == "xz" and r <= 5.0)] if axes == "xz" else ATTITUDES
    readings = tp_readings(axes, attitudes)
    pitch, roll = np.array(attitudes).T
    if axes == "x":
        readings["roll_deg"] = roll
    found = inference(packaged(tp_set(axes)), reading_sd_v=1e-6, right_wing_down=True).infer(readings)
    assert found["flag"] == ("",) * len(attitudes)
    np.testing.assert_allclose(found["pitch_deg"], pitch, atol=1e-9)
    np.testing.assert_allclose(found["roll_deg"], roll, atol=1e-9)


def cr_readings(eulers: list[tuple[float, float, float]]) -> dict[str, np.ndarray]:
    tables = {"sting": TABLE_3_STING, "model": TABLE_3_MODEL}
    return {
        f"{package}_{axis}_v": np.array([accelerometer_v(axis, truth, euler, package) for euler in eulers])
        for package, table in tables.items()
        for axis, truth in table.items()
    }


def pair(reading_sd_v: float | None) -> Inference:
    return inference(packaged(package_set("sting"), "sting_"), packaged(package_set("model"), "model_"), reading_sd_v)


def test_two_packages_give_pitch_yaw_and_roll_of_explicit_rotations() -> None:
    eulers = [(-35.0, 10.0, 40.0), (20.0, -15.0, -55.0), (30.0, 24.0, 5.0), (3.0, -4.0, 0.0)]
    found = pair(1e-6).infer(cr_readings(eulers))
    assert found["flag"] == ("",) * 4
    for name, expected in zip(("pitch", "yaw", "roll"), np.array(eulers).T, strict=True):
        np.testing.assert_allclose(found[f"{name}_deg"], expected, atol=1e-8)


def test_a_sting_package_alone_gives_pitch_and_yaw_and_says_that_roll_is_not_sensed() -> None:
    found = inference(packaged(package_set("sting"), "sting_"), reading_sd_v=1e-6).infer(
        cr_readings([(25.0, 9.0, 40.0)])
    )
    assert (found["pitch_deg"][0], found["yaw_deg"][0]) == pytest.approx((25.0, 9.0), abs=1e-8)
    assert np.isnan(found["roll_deg"][0])
    assert found["flag"] == ("roll not sensed: sting package alone",)


def test_standard_deviations_of_two_packages_are_those_of_a_monte_carlo() -> None:
    eulers, chance = [(20.0, -15.0, -30.0)], np.random.default_rng(4)
    clean = cr_readings(eulers)
    noisy = {name: value + 1e-4 * chance.normal(size=4000) for name, value in clean.items()}
    found = pair(1e-4).infer(noisy)
    for name in ("pitch", "yaw", "roll"):
        assert np.mean(found[f"{name}_sd_deg"]) == pytest.approx(np.std(found[f"{name}_deg"]), rel=0.05)


@pytest.mark.parametrize("axes", [pytest.param("xyz", marks=pytest.mark.thorough), "xy", "x"])
def test_stated_standard_deviations_cover_calibration_and_reading(axes: str) -> None:
    chance, sigma = np.random.default_rng(8), 3e-4
    readings = tp_readings(axes, ATTITUDES[:4])
    truth = dict(zip(("pitch_deg", "roll_deg"), np.array(ATTITUDES[:4]).T, strict=True))
    held: dict[str, list[bool]] = {"pitch_deg": [], "roll_deg": []}
    for _ in range(160):
        how = inference(packaged(tp_set(axes, sigma, chance)), reading_sd_v=0.3 * sigma)
        noisy = {name: values + 0.3 * sigma * chance.normal(size=4) for name, values in readings.items()}
        found = how.infer({**noisy, "roll_deg": truth["roll_deg"]})
        for name in held if axes != "x" else ("pitch_deg",):
            held[name] += list(np.abs(found[name] - truth[name]) < 1.98 * found[name.replace("_deg", "_sd_deg")])
    for name, inside in held.items():
        assert not inside or np.mean(inside) == pytest.approx(0.95, abs=0.025), name


def test_singular_attitudes_are_nan_and_named() -> None:
    up = inference(packaged(tp_set()), reading_sd_v=1e-5).infer(tp_readings("xyz", [(90.0, 20.0)]))
    assert np.isnan(up["roll_deg"][0])
    assert up["pitch_deg"][0] == pytest.approx(90.0, abs=1e-5)
    assert up["flag"] == ("roll singular",)
    sideways = inference(packaged(tp_set("xy")), reading_sd_v=1e-5).infer(tp_readings("xy", [(10.0, 90.0)]))
    assert np.isnan(sideways["roll_deg"][0])
    assert "singular" in sideways["flag"][0] or "beyond" in sideways["flag"][0]
    level = pair(1e-5).infer(cr_readings([(0.0, 10.0, 30.0)]))
    assert np.isnan(level["yaw_deg"][0])
    assert level["roll_deg"][0] == pytest.approx(30.0, abs=1e-6)
    assert level["pitch_deg"][0] == pytest.approx(0.0, abs=1e-6)
    assert level["flag"] == ("yaw singular: pitch near zero",)


def test_two_packages_that_disagree_are_flagged_with_what_may_be_wrong_and_good_ones_hardly_ever() -> None:
    """Three of six readings are to spare. An error of the sting's y is a yaw, which lengthens f by next to nothing."""
    eulers, chance = [(20.0, -15.0, -30.0), (-25.0, 10.0, 35.0)], np.random.default_rng(7)
    clean = cr_readings(eulers)
    good = {n: np.repeat(v, 4000) + 1e-4 * chance.normal(size=8000) for n, v in clean.items()}
    alarms = pair(1e-4).answer(good).codes != 0
    assert 0.0002 < np.mean(alarms) < 0.002  # 0.1 % is asked for
    for name in (name for name in clean if name != "sting_y_v"):
        bad = {n: np.repeat(v, 50) + 1e-4 * chance.normal(size=100) for n, v in clean.items()}
        bad[name] = bad[name] + 3e-3
        flags = pair(1e-4).infer(bad)["flag"]
        package, axis, _ = name.split("_")
        text = "x" if axis == "x" else "y or z"
        assert all(flag.startswith("redundancy: ") for flag in flags), name
        assert np.mean([flag == f"redundancy: suspect {text} of the {package} package" for flag in flags]) > 0.95, name


@pytest.mark.parametrize(("name", "package", "axis"), [("sting_x_v", 0, 0), ("model_y_v", 1, 1), ("model_z_v", 1, 2)])
def test_rows_of_many_attitudes_part_what_one_row_of_two_packages_does_not(name: str, package: int, axis: int) -> None:
    chance = np.random.default_rng(8)
    eulers = [tuple(chance.uniform((-30.0, -20.0, -90.0), (30.0, 20.0, 90.0)).tolist()) for _ in range(80)]
    readings = {n: v + 1e-4 * chance.normal(size=v.size) for n, v in cr_readings(eulers).items()}
    readings[name] = readings[name] + 3e-3
    watched = WatchedAxes(pair(1e-4))
    flags = [flag for flag in watched.answer(readings).flags if "redundancy" in flag]
    watched.finish()
    causes = [judgement.cause for judgement in watched.judged().judgements]
    assert watched.judged().judgements[package].axis == axis
    assert causes[1 - package] is Cause.NOTHING
    who = f"{'xyz'[axis]} of the {('sting', 'model')[package]} package"
    said = [f"redundancy: suspect {who}" in flag for flag in flags]
    assert sum(said) > 40
    others = [flag for flag, is_so in zip(flags, said, strict=True) if not is_so]
    assert all(f"redundancy: {who} proven wrong by other rows" in flag for flag in others)
    assert len(flags) == 80
    (text,) = doubts_of(watched, is_flagged_throughout=True)
    assert f"{('sting', 'model')[package]} package: 80 rows" in text


def test_a_sting_package_that_disagrees_is_flagged_and_no_axis_named() -> None:
    readings = {name: value.copy() for name, value in cr_readings([(25.0, 9.0, 0.0)]).items() if "sting" in name}
    readings["sting_x_v"] += 0.01
    found = inference(packaged(package_set("sting"), "sting_"), reading_sd_v=1e-4).infer(readings)
    assert found["flag"] == ("redundancy: outputs disagree; roll not sensed: sting package alone",)


@pytest.mark.parametrize(("dof", "is_flagged"), [(3.0, False), (1e6, True)])
def test_a_calibration_of_few_replications_is_not_blamed_on_the_readings(dof: float, is_flagged: bool) -> None:
    """Five deviations of a calibration: Student's bound at 99.9 % is 12.9 of them with three degrees of freedom."""
    of_offset = np.diag([1e-3**2, 0.0, 0.0, 0.0])
    part = VarianceComponent("replications", of_offset, dof)
    sensors = [line_sensor(0.0, np.eye(3)[index], of_offset, 1e-7, (part,)) for index in range(3)]
    force = np.array([[np.sin(0.5), 0.0, -np.cos(0.5)]])
    along = force / np.linalg.norm(force)
    found = angles_from_sting(sensors, force + 5e-3 * along)
    assert bool(found.codes[0] & flag_codes.REDUNDANCY) == is_flagged


def test_an_angle_beyond_the_calibration_keeps_its_number_and_is_named() -> None:
    found = pair(1e-6).infer(cr_readings([(35.0, 9.0, 10.0)]))
    assert found["pitch_deg"][0] == pytest.approx(35.0, abs=1e-8)
    assert found["flag"] == ("pitch outside the validity of the set",)


def bent_and_warm(pitch_deg: float, roll_deg: float, rise_degc: float, axis: str) -> float:
    """v = b + b1 dT + (1 + s1 dT)(k·f + fᵀQf), written out."""
    clean, offset = output_v(axis, TRUTH[axis], pitch_deg, roll_deg), TRUTH[axis][0]
    return offset + 1e-3 * rise_degc + (1.0 - 2e-3 * rise_degc) * (clean - offset)


def test_temperature_is_taken_off_before_angles_are_inferred() -> None:
    grid = [(p, r, t) for t in (10.0, 30.0, 31.0, 11.0) for p in range(-60, 61, 30) for r in range(-120, 181, 60)]
    pitch, roll, warm = np.array(grid).T
    outputs = {a: np.array([bent_and_warm(p, r, t - 20.0, a) for p, r, t in grid]) for a in "xyz"}
    points = len(grid) // 4
    rows = Observations(
        np.repeat(np.arange(4), points), np.tile(np.arange(points), 4), np.deg2rad(pitch), np.deg2rad(roll), outputs,
        temperature_degc=warm,
    )  # fmt: skip
    solved = calibrate(rows, CalibrationRequest(temperature="estimate", reference_temperature_degc=20.0, extended="no"))
    from solved_sets import SITE

    ranges = {"pitch_range_deg": (-60.0, 60.0), "roll_range_deg": (-180.0, 180.0)}
    coefficients = build_set(solved, Provenance("T1", **SITE, **ranges, temperature_range_degc=(10.0, 31.0)))
    readings = {
        f"{a}_v": np.array([bent_and_warm(20.0, 50.0, 6.0, a), bent_and_warm(-10.0, 5.0, 15.0, a)]) for a in "xyz"
    }
    found = inference(packaged(coefficients), reading_sd_v=1e-6).infer(
        {**readings, "temperature_degc": np.array([26.0, 35.0])}
    )
    np.testing.assert_allclose(found["pitch_deg"], (20.0, -10.0), atol=1e-6)
    np.testing.assert_allclose(found["roll_deg"], (50.0, 5.0), atol=1e-6)
    assert found["flag"] == ("", "temperature outside the validity of the set")


def test_a_soft_mount_is_taken_off_at_the_attitude_itself() -> None:
    pitch, roll = np.deg2rad(
        np.array([(p, r) for p in range(-90, 91, 15) for r in range(-180, 180, 30)], dtype=float)
    ).T
    f = np.stack([np.sin(pitch), -np.cos(pitch) * np.sin(roll), -np.cos(pitch) * np.cos(roll)])
    k = {"x": (2.5, 0.01, 0.02), "y": (0.01, 2.4, 0.0), "z": (0.0, 0.02, 2.6)}

    def bent(axis: str, f: np.ndarray) -> np.ndarray:
        return 0.01 + np.asarray(k[axis]) @ f + 0.003 * (f[0] ** 2 - f[2] ** 2) + 2 * 0.002 * f[0] * f[1]

    count = pitch.size
    rows = Observations(np.ones(count, dtype=int), np.arange(count), pitch, roll, {a: bent(a, f) for a in "xyz"})
    solved = calibrate(rows, CalibrationRequest(extended="yes"))
    from solved_sets import SITE

    ranges = {"pitch_range_deg": (-90.0, 90.0), "roll_range_deg": (-180.0, 180.0)}
    coefficients = build_set(solved, Provenance("Q1", **SITE, **ranges))
    at = np.deg2rad([33.0]), np.deg2rad([-48.0])
    f = np.stack([np.sin(at[0]), -np.cos(at[0]) * np.sin(at[1]), -np.cos(at[0]) * np.cos(at[1])])
    found = inference(packaged(coefficients), reading_sd_v=1e-6).infer({f"{a}_v": bent(a, f) for a in "xyz"})
    assert (found["pitch_deg"][0], found["roll_deg"][0]) == pytest.approx((33.0, -48.0), abs=1e-9)


def test_what_a_set_cannot_tell_is_refused() -> None:
    from solved_sets import gyro_set

    with pytest.raises(OutsideValidity, match="gyros sense rates"):
        inference(packaged(gyro_set()))
    with pytest.raises(OutsideValidity, match="got 2 axes, needed 3"):
        inference(Package(package_set("sting"), {"x": "x_v", "y": "y_v"}))
    with pytest.raises(OutsideValidity, match="one axis tells pitch only where it lies along x"):
        inference(packaged(tp_set("z")))
    with pytest.raises(OutsideValidity, match="allowed 0 V or more"):
        inference(packaged(tp_set()), reading_sd_v=-1.0)
