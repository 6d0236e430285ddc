"""The calibrations of the reports on twins: SR's three on the servo mechanism, CR's gyros on the rate table.

The truths are the reports' own numbers, written here once more: SR's conversion equations, CR table 4.
"""

import json
import os
import signal
from collections.abc import Mapping
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from motion_runs import MotionRun, motion_run
from scipy.stats import t as student
from small_run import dwells_of, in_child, measured

from ams.archive.sign_offs import SignOff
from ams.exports.formats import load_set
from ams.exports.verify import verify
from ams.sets.apply import sensed_level
from ams.sets.canonical import listed, number, table
from ams.sets.verdict_conditions import NO_DIRECTIONS, NO_STANDARD_OF_RATES, verdict_conditions
from procedures.certificate.grounds import Grounds, gaps_of
from procedures.delivery.deliver import SolvedRun, deliver, sensors_document, sets_of, solve_run
from procedures.records.states import State
from procedures.report.truth import truth_of
from procedures.run.dwell.turning import RateWatch
from procedures.run.resume import resume
from rig.abilities.abilities import TurnLook

# SR, "Calibration and Conversion Equations": real = A·reading + B per axis.
SR_ACCELEROMETER = {"x": (1.0032, 0.02066), "y": (1.0278, -0.0659), "z": (1.0119, -0.0243)}
SR_GYRO = {"x": (1.0443, 2.44732), "y": (0.9744, -0.561), "z": (0.9962, -0.588447)}
SR_MAGNETOMETER = {"x": (0.997, -52.865 / 31.24), "y": (0.997, -52.865 / 31.24), "z": (1.000015, -101.32 / 31.24)}
# CR table 4: B (V), S (V/(deg/s)), C (deg), A (deg).
CR_TABLE_4 = {"x": (0.051, 1.25, 0.11, 0.14), "y": (0.052, 1.26, 0.12, 0.15), "z": (0.053, 1.27, 0.13, 0.16)}
CONFIDENCE = 0.999
"""Of every interval here: of a few dozen none should miss."""

FASTER = {
    r"dwell_s = 300.0": "dwell_s = 40.0",
    r"replications = \d": "replications = 3",
    r"\[10.0, 20.0\]": "[20.0]",
    r"\[9.0, 13.5\]": "[13.5]",
}


def _require_inside(solved: SolvedRun, sensor: str, truths: Mapping[str, Mapping[str, float]]) -> None:
    """Every parameter's interval at 99.9 %, by its own standard uncertainty and degrees of freedom, holds the truth."""
    calibration = solved.sensors[sensor].calibration
    assert calibration is not None, solved.failures
    for axis, wanted in truths.items():
        estimates = {estimate.name: estimate for estimate in calibration.axes[axis].parameters}
        for name, truth in wanted.items():
            estimate = estimates[name]
            assert estimate.value is not None, name
            assert estimate.standard_uncertainty is not None
            factor = float(student.ppf(0.5 + CONFIDENCE / 2.0, estimate.effective_degrees_of_freedom))
            allowed = factor * estimate.standard_uncertainty
            assert abs(estimate.value - truth) <= allowed, f"{axis} {name}: {estimate.value} ± {allowed}, {truth}"


def _lines(truths: Mapping[str, tuple[float, float]], unit: str) -> dict[str, dict[str, float]]:
    return {
        axis: {f"gain_{unit}_per_{unit}": gain, f"offset_{unit}": offset} for axis, (gain, offset) in truths.items()
    }


def _require_a_set_that_turns_readings_into_levels(
    solved: SolvedRun, sensor: str, truths: Mapping[str, tuple[float, float]], level: float, within: float
) -> None:
    """What SR's own real = A·reading + B says of a level, the set says as well."""
    entry = sets_of(solved)[sensor]
    entry.check_vectors(sensor)
    levels = np.array([level, -level, 0.5 * level])
    readings = {axis: (own - offset) / gain for own, (axis, (gain, offset)) in zip(levels, truths.items(), strict=True)}
    assert sensed_level(entry, readings) == pytest.approx(levels, abs=within)


def _table_4(without: str = "") -> dict[str, dict[str, float]]:
    names = ("offset_v", "sensitivity_v_per_dps", "coning_deg", "azimuth_deg")
    return {
        axis: {name: value for name, value in zip(names, values, strict=True) if name != without}
        for axis, values in CR_TABLE_4.items()
    }


@pytest.mark.thorough
def _told_of_gravity(solved: SolvedRun, sensor: str) -> bool:
    """Whether it is said, once, that what gravity does to the sensor's zero was not measured."""
    calibration = solved.sensors[sensor].calibration
    assert calibration is not None
    return [text.startswith("g-sensitivity of the gyros was not measured") for text in calibration.remarks].count(
        True
    ) == 1


def test_sr_accelerometer_up_and_down_on_the_servo_mechanism(tmp_path: Path) -> None:
    small = motion_run(tmp_path, "servo-mechanism", "accelerometer", {"replications = 6": "replications = 4"})
    solved = small.solved()
    _require_inside(solved, "SCA3000", _lines(SR_ACCELEROMETER, "g"))
    assert not _told_of_gravity(solved, "SCA3000")
    _require_a_set_that_turns_readings_into_levels(solved, "SCA3000", SR_ACCELEROMETER, 1.0, 2e-3)
    # The servos are off by 0.75° and 0.5°: measured, not commanded, attitudes were recorded and led to the targets.
    for dwell in solved.record.dwells:
        assert dwell.motion is not None
        assert dwell.motion.commanded_deg["pitch"] - dwell.measured_deg["pitch"] == pytest.approx(-0.75, abs=0.06)
        for axis, target_deg in dwell.targets_deg.items():
            assert (dwell.measured_deg[axis] - target_deg + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.1)


def test_sr_without_a_reference_the_servo_s_own_error_enters(tmp_path: Path) -> None:
    """What closing the loop is for: half a degree of pitch at ±90° is invisible, of pitch at 0° it is 0.013 g."""
    open_loop = {r"closes_loop = true": "closes_loop = false"}
    small = motion_run(
        tmp_path, "servo-mechanism", "accelerometer", {"replications = 6": "replications = 2"}, open_loop
    )
    solved = small.solved()
    for dwell in solved.record.dwells:
        assert dwell.motion is not None
        assert dwell.measured_deg["pitch"] == pytest.approx(dwell.targets_deg["pitch"] + 0.75, abs=0.06)
    _require_inside(solved, "SCA3000", _lines(SR_ACCELEROMETER, "g"))  # fitted at the measured attitude


def test_sr_gyro_at_constant_rates_on_the_servo_mechanism(tmp_path: Path) -> None:
    """Forty seconds a dwell here; the report's five minutes are below, for the long evening."""
    solved = motion_run(tmp_path, "servo-mechanism", "gyro", FASTER).solved()
    _require_inside(solved, "ITG3200", _lines(SR_GYRO, "dps"))
    assert _told_of_gravity(solved, "ITG3200")
    _require_a_set_that_turns_readings_into_levels(solved, "ITG3200", SR_GYRO, 15.0, 0.5)


@pytest.mark.soak
@pytest.mark.timeout(1200)
def test_intervals_of_a_set_of_lines_hold_the_truth_over_forty_seeds(tmp_path: Path) -> None:
    """240 intervals at 95 %: of so many independent ones 215 hold the truth or more in 99.9 %."""
    held = 0
    for seed in range(40):
        folder = tmp_path / str(seed)
        folder.mkdir()
        another = {r"seed = 11": f"seed = {1000 + seed}"}
        solved = motion_run(folder, "servo-mechanism", "accelerometer", None, another).solved()
        for axis, (gain, offset) in SR_ACCELEROMETER.items():
            parameters = table(table(table(sets_of(solved)["SCA3000"].document["axes"])[axis])["parameters"])
            for name, truth in (("gain_g_per_g", gain), ("offset_g", offset)):
                low, high = map(number, listed(table(parameters[name])["interval_95"]))
                held += low <= truth <= high
    assert held >= 215


@pytest.mark.soak
def test_sr_gyro_with_dwells_of_five_minutes_at_one_sample_a_second(tmp_path: Path) -> None:
    solved = motion_run(tmp_path, "servo-mechanism", "gyro").solved()
    _require_inside(solved, "ITG3200", _lines(SR_GYRO, "dps"))
    turned = [dwell for dwell in solved.record.dwells if dwell.motion and dwell.motion.turned_deg]
    assert all(dwell.readings["imu.gx"].samples.size >= 300 for dwell in turned)
    assert all(dwell.readings["imu.gx"].interval_s == 1.0 for dwell in turned)


@pytest.mark.parametrize(
    "known", ["", pytest.param("\nsurroundings_ut = [22.0, -3.0, 40.0]", marks=pytest.mark.thorough)]
)
def test_sr_magnetometer_with_and_without_the_coil_s_field_the_earth_s_known_or_not(tmp_path: Path, known: str) -> None:
    changes = {r"rest_s = 60.0": f"rest_s = 15.0{known}", r"replications = 4": "replications = 3"}
    solved = motion_run(tmp_path, "servo-mechanism", "magnetometer", changes).solved()
    _require_inside(solved, "MicroMag3", _lines(SR_MAGNETOMETER, "ut"))
    _require_a_set_that_turns_readings_into_levels(solved, "MicroMag3", SR_MAGNETOMETER, 30.0, 0.7)
    calibration = solved.sensors["MicroMag3"].calibration
    assert calibration is not None
    names = [estimate.name for estimate in calibration.axes["z"].parameters]
    assert ("surroundings_ut" in names) == (not known)
    if not known:
        _require_inside(solved, "MicroMag3", {axis: {"surroundings_ut": 40.0} for axis in "xyz"})
    rig = solved.record.rig
    for axis, found in calibration.axes.items():
        text = truth_of(rig, "MicroMag3", axis, solved.sensors["MicroMag3"].observations, found)
        towards = {name: value for name, value in text.items() if name.startswith("towards_")}
        assert len(towards) == 2
        _require_inside(solved, "MicroMag3", {axis: towards})
    document = json.loads(json.dumps(sensors_document(solved), allow_nan=False))["MicroMag3"]
    assert (document["model"], document["convention"]) == ("linear", "SR")
    assert set(document["axes"]["x"]["parameters"]["gain_ut_per_ut"]) >= {
        "value",
        "standard_uncertainty",
        "interval_95",
    }
    assert document["axes"]["x"]["standard_error_ut"] < 0.5
    design = [dwell for dwell in solved.record.dwells if dwell.purpose == "design"]
    assert [dwell.motion.field_ut["coil"] for dwell in design if dwell.motion] == [*[0.0] * 6, *[40.0] * 6] * 3


@pytest.mark.thorough
def test_sr_magnetometer_by_the_difference_that_a_magnet_makes(tmp_path: Path) -> None:
    """SR 4.1.3: 'real' is the reading with the magnet less the mean of the two differences, in the sensor's own units.

    For a straight sensor in no other field, reading = zero ± S·H: the differences are ±S·H and their mean S·H, so real
    is the zero itself in both directions, as the reading without the magnet is: there are no two levels.
    """
    changes = {r"rest_s = 60.0": 'rest_s = 15.0\nmethod = "magnet-difference"', r"replications = 4": "replications = 3"}
    solved = motion_run(tmp_path, "servo-mechanism", "magnetometer", changes).solved()
    calibration = solved.sensors["MicroMag3"].calibration
    assert calibration is not None
    for axis in "xyz":
        gain, offset = calibration.axes[axis].parameters
        assert gain.value == pytest.approx(1.0, abs=0.01)  # the method's own answer: the sensor in its own units
        assert offset.value == pytest.approx(0.0, abs=0.5)


def test_cr_gyros_by_constant_rates_on_the_rate_table(tmp_path: Path) -> None:
    changes = {r"replications = 4": "replications = 3", r"\[10.0, 40.0\]": "[40.0]"}
    solved = motion_run(tmp_path, "rate-table", "rates", changes).solved()
    _require_inside(solved, "ENC03J", _table_4())
    assert _told_of_gravity(solved, "ENC03J")
    _require_told_that_no_standard_is_behind_the_rates(solved)
    _require_a_set_for_the_rates_that_were_turned(solved, tmp_path)


def _require_told_that_no_standard_is_behind_the_rates(solved: SolvedRun) -> None:
    """The example's axes have none: a remark of the run, a finding of every axis, a gap of the certificate."""
    calibration = solved.sensors["ENC03J"].calibration
    assert calibration is not None
    (said,) = [text for text in calibration.remarks if text.startswith(NO_STANDARD_OF_RATES)]
    assert "(pitch, yaw, roll)" in said
    for axis in calibration.axes.values():
        (finding,) = [finding for finding in axis.findings if finding.kind == "rate-undeclared"]
        assert (finding.text, finding.is_significant) == (said, False)
        (leaning,) = [finding for finding in axis.findings if finding.kind == "table-undeclared"]
        assert leaning.text.startswith(f"{NO_DIRECTIONS} (pitch, yaw, roll): ")
    assert "the directions of the table's axes" in verdict_conditions(calibration.remarks)
    entry = sets_of(solved)["ENC03J"]
    gaps = list(gaps_of(Grounds("1", date(2026, 3, 2), entry, None, SignOff(entry.sha256, (), ()))))
    assert gaps.count(said) == 1
    assert sum(gap.startswith(NO_DIRECTIONS) for gap in gaps) == 1


def _require_a_set_for_the_rates_that_were_turned(solved: SolvedRun, folder: Path) -> None:
    delivery = deliver(solved, f"sqlite:///{folder / 'archive.sqlite'}")
    found = load_set(delivery.sets["ENC03J"])
    assert found.model == "gyro"
    assert found.validity.rate_dps == pytest.approx((-40.0, 40.0), abs=0.01)
    assert found.validity.yaw_deg == pytest.approx((0.0, 0.0), abs=1e-6)
    rates = [vector["yaw_rate_dps"] for vector in found.test_vectors["forward"]]  # type: ignore[union-attr, index, call-overload]
    assert min(rates) < -10.0 < 10.0 < max(rates)
    assert verify(delivery.sets["ENC03J"]).forward_vectors == 9
    assert delivery.archived is not None
    page = delivery.report.read_text(encoding="utf-8")
    for text in (
        "Rates from position and time",
        "+40",
        "u(drift) (ppm)",
        "Residuals",
        "without a standard of the rates",
    ):
        assert text in page


@pytest.mark.thorough
def test_cr_gyros_by_the_harmonic_profile_on_the_rate_table(tmp_path: Path) -> None:
    solved = motion_run(tmp_path, "rate-table", "harmonic").solved()
    _require_inside(solved, "ENC03J", _table_4())
    dwell = next(dwell for dwell in solved.record.dwells if dwell.purpose == "design")
    assert dwell.motion is not None
    (stream,) = dwell.motion.streams
    assert (stream.missing, stream.doubled, stream.doubtful) == (0, 0, 0)
    assert stream.offset_uncertainty_s < 1e-3


def test_cr_accelerometers_on_the_ramp_are_solved_at_the_angles_that_were_measured(tmp_path: Path) -> None:
    """CR table 3, model package. Ten degrees and real noise tell offset and sensitivities hardly apart: it says so."""
    solved = motion_run(tmp_path, "rate-table", "ramp", {"replications = 4": "replications = 3"}).solved()
    calibration = solved.sensors["ADXL105"].calibration
    assert calibration is not None
    _require_inside(solved, "ADXL105", {"x": {"offset_v": 1.26, "sensitivity_v_per_g": 0.52}, "y": {"offset_v": 1.28}})
    for axis in "xyz":
        assert calibration.axes[axis].standard_error_v < 3.0 * 0.0005 / 10.0**0.5  # the angles explain the rest
        assert any("tell the parameters apart poorly" in warning for warning in calibration.axes[axis].warnings)


def test_an_offset_at_rest_and_a_drift_verdict(tmp_path: Path) -> None:
    """White noise σ at 1 sample/s: the Allan deviation at T is σ/√T, the angle error √2·σ·√T: 0.1 °/s drifts 3.1°."""
    solved = motion_run(tmp_path, "servo-mechanism", "drift").solved()
    for axis, (gain, offset) in SR_GYRO.items():
        text = solved.sensors["ITG3200"].static[axis]
        assert text.mean == pytest.approx(-offset / gain, abs=5.0 * 0.1 / 1200.0**0.5)
        assert text.random_walk_per_sqrt_s == pytest.approx(0.1, rel=0.1)
        assert text.drift_deg == pytest.approx(2.0 * 2.0**0.5 * 0.1 * 120.0**0.5, rel=0.4)  # few means of 120 s
        assert text.holds is False
    assert all(found.holds for found in solved.sensors["SCA3000"].static.values())
    assert {found.drift_deg for found in solved.sensors["MicroMag3"].static.values()} == {None}
    assert not solved.failures
    document = json.loads(json.dumps(sensors_document(solved), allow_nan=False))
    assert document["ITG3200"]["static"]["x"]["verdict"].endswith("beyond the allowed ±0.1°")
    terms = {term["name"]: term["value"] for term in document["ITG3200"]["static"]["x"]["noise_terms"]}
    assert terms["white"] is not None


def _run_until_a_look(small: MotionRun, run_dir: Path, fatal: int) -> None:
    """In a process of its own: SIGKILL at that look at a turning axis."""
    looks, take = iter(range(1, 10_000)), RateWatch.take

    def look(self: RateWatch, turn_look: TurnLook) -> None:
        if next(looks) == fatal:
            os.kill(os.getpid(), signal.SIGKILL)
        take(self, turn_look)

    RateWatch.take = look  # type: ignore[assignment, method-assign]
    small.run(run_dir)


@pytest.mark.thorough
def test_a_run_that_was_killed_while_it_turned_goes_on_to_the_same_numbers(tmp_path: Path) -> None:
    changes = {r"replications = 4": "replications = 2", r"\[10.0, 40.0\]": "[40.0]"}
    small = motion_run(tmp_path, "rate-table", "rates", changes)
    assert small.run(tmp_path / "whole").state is State.FINISHED
    _, status = os.waitpid(in_child(lambda: _run_until_a_look(small, tmp_path / "killed", 60)), 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    done = len(measured(dwells_of(tmp_path / "killed")))
    assert resume(tmp_path / "killed", "tester", "after the kill").state is State.FINISHED
    assert 0 < done < len(measured(dwells_of(tmp_path / "killed"))) == 16
    whole, killed = (solve_run(tmp_path / name).sensors["ENC03J"].calibration for name in ("whole", "killed"))
    assert whole is not None
    assert killed is not None
    for axis in "xyz":
        for parameter, other in zip(whole.axes[axis].parameters, killed.axes[axis].parameters, strict=True):
            assert parameter.value == pytest.approx(other.value, rel=1e-9, abs=1e-9)
            assert parameter.standard_uncertainty == pytest.approx(other.standard_uncertainty, rel=1e-6)
