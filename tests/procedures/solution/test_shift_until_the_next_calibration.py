"""What a sensor may shift by until its next calibration: declared as a limit, it stands in every angle told with it."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from example_files import EXAMPLE_RIG, ROOT
from physics_scenes import campaigns
from small_run import bench
from solved import provenance

from ams.calibration.calibrate import calibrate
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SHIFTS, SHIFTS_WITHIN, SharedError
from ams.observations import Observations
from ams.sets.coefficients import build_set
from procedures.check.check_report import check
from procedures.delivery.deliver import solve_run
from procedures.kinds.read import read_procedure
from procedures.solution.type_b import shared_errors
from rig.description.read import read_rig
from rig.errors import DescriptionError

ARCSEC = np.pi / 180.0 / 3600.0
V_PER_G = 2.5


def test_a_limit_of_each_axis_is_an_error_of_its_own(tmp_path) -> None:
    lines = "largest_offset_shift_v = 1.2e-4\nlargest_sensitivity_shift = 2e-4\n"
    path = tmp_path / "rig.toml"
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    path.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\n{lines}"), encoding="utf-8")
    rig = read_rig(path)
    sensor = rig.sensors["SN1047"]
    found = {error.name: error for error in shared_errors(rig, sensor)["x"]}
    offset, gain = (found[name] for name in SHIFTS)
    assert (offset.effect, offset.standard_uncertainty) == ("reading", pytest.approx(1.2e-4 / sqrt(3.0)))
    assert (gain.effect, gain.standard_uncertainty) == ("gain", pytest.approx(2e-4 / sqrt(3.0)))
    course, gain_course = (found[name] for name in SHIFTS_WITHIN)
    assert (course.effect, course.standard_uncertainty) == ("reading-course", offset.standard_uncertainty)
    assert (gain_course.effect, gain_course.standard_uncertainty) == ("gain-course", gain.standard_uncertainty)
    assert all(error.is_of_one_channel for error in (offset, gain, course, gain_course))
    at_rest = {error.name for error in shared_errors(rig, sensor, counts_shift=False)["x"]}
    assert at_rest == found.keys() - {*SHIFTS, *SHIFTS_WITHIN}


@pytest.mark.parametrize(
    "key",
    [
        "largest_offset_shift_v",
        "largest_nonlinearity_v",
        "use_temperature_degc = [10.0, 30.0]\nlargest_offset_tc_v_per_degc",
    ],
)
def test_volts_of_a_sensor_that_is_read_in_counts_are_refused(tmp_path, key: str) -> None:
    path = tmp_path / "rig.toml"
    text = (ROOT / "examples" / "servo-mechanism" / "rig.toml").read_text(encoding="utf-8")
    serial = text.partition("[sensors.")[2].partition("]")[0]
    path.write_text(text.replace(f"[sensors.{serial}]\n", f"[sensors.{serial}]\n{key} = 1e-4\n"))
    with pytest.raises(DescriptionError, match=f"{key.rpartition(chr(10))[2]}.*not read in volts"):
        read_rig(path)


def test_check_expects_it_and_the_run_states_it(tmp_path) -> None:
    """Half-widths of what the outcome of one run does not make: the shift takes nearly all of them."""
    declared = "largest_offset_shift_v = 1e-3\nlargest_sensitivity_shift = 1e-3\nnominal_sensitivity_v_per_g"
    made = bench(tmp_path, rig=(("nominal_sensitivity_v_per_g", declared),))
    made.run(tmp_path / "run")
    solved = solve_run(tmp_path / "run").sensors["SN1"].calibration
    assert solved is not None
    for expected in check(made.rig, read_procedure(tmp_path / "procedure.toml")).forecast.expected:
        stated = {item.name: item.interval_95 for item in solved.axes[expected.axis].parameters}
        interval, half = stated["offset_v"], expected.half_width_95["offset_v"]
        assert interval is not None
        assert half == pytest.approx(0.5 * (interval[1] - interval[0]), rel=0.1)
        assert half == pytest.approx(1.96e-3 / sqrt(3.0), rel=0.1)


def _held(size_arcsec: float, limit_arcsec: float, count: int, seed: int) -> tuple[float, float]:
    """Return which share of the intervals of rows that nothing flags holds its angle, and which share is flagged."""
    drawn = campaigns("use-shifted-offset", size_arcsec, np.random.default_rng(seed), count)
    axes, schedule = drawn.use.setup.axes, drawn.use.schedule
    calibration = drawn.calibration
    u_v = limit_arcsec * ARCSEC * V_PER_G / sqrt(3.0)
    shift = [SharedError(SHIFTS[0], "reading", u_v, "limit", is_of_one_channel=True)] if u_v else []
    request = CalibrationRequest(shared_errors=dict.fromkeys(axes, tuple(shift)))
    grid = calibration.schedule.grid_rows()
    pitch, roll = (np.deg2rad(angle[grid]) for angle in (calibration.schedule.pitch_deg, calibration.schedule.roll_deg))
    replication, point = (index.ravel() for index in np.indices(grid.shape))
    held, flags = [], []
    for index in range(count):
        outputs = {axis: calibration.output_v[index, grid.ravel(), 0, at] for at, axis in enumerate(axes)}
        rows = Observations(replication, point, pitch.ravel(), roll.ravel(), outputs)
        package = Package(build_set(calibrate(rows, request), provenance()), {axis: f"{axis}_v" for axis in axes})
        readings = {f"{axis}_v": drawn.use.output_v[index, :, 0, at] for at, axis in enumerate(axes)}
        noise_v = drawn.use.setup.noise_arcsec * ARCSEC * V_PER_G
        answer = replace(inference(package, reading_sd_v=noise_v), intervals=True).infer(readings)
        is_flagged = np.array([flag != "" for flag in answer["flag"]])
        for name, truth in (("pitch", schedule.pitch_deg), ("roll", schedule.roll_deg)):
            away_deg = np.abs((answer[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0)
            held.append((away_deg <= answer[f"{name}_half_95_deg"])[~is_flagged])
        flags.append(is_flagged.mean())
    return float(np.concatenate(held).mean()), float(np.mean(flags))


def test_angles_after_a_shift_within_the_limit_are_held_and_without_it_are_not() -> None:
    """An offset that moves by half of its limit: silent below the threshold of redundancy, unless it is declared."""
    held, flagged = _held(5.0, 10.0, 8, 3)
    silent, _ = _held(5.0, 0.0, 8, 3)
    assert held > 0.93
    assert flagged < 0.01
    assert silent < 0.93


@pytest.mark.thorough
@pytest.mark.parametrize("size_arcsec", [0.0, 2.0, 5.0, 10.0])
def test_up_to_the_limit_itself_angles_are_held(size_arcsec: float) -> None:
    assert _held(size_arcsec, 10.0, 40, 7)[0] > 0.93
