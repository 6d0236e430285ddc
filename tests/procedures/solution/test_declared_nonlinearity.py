"""How far an output may be from its equation: declared as a limit, it stands in every angle told with the set."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from example_files import EXAMPLE_RIG
from physics_scenes import campaigns
from small_run import bench
from solved import provenance
from solved_campaigns import columns_of, rows_of

from ams.calibration.calibrate import calibrate
from ams.inference.inference import Package, inference
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import NONLINEARITY, SharedError
from ams.sets.coefficients import build_set
from procedures.check.check_report import check
from procedures.delivery.deliver import solve_run
from procedures.kinds.read import read_procedure
from procedures.solution.type_b import shared_errors
from rig.description.read import read_rig
from rig.errors import DescriptionError

V_PER_G = 2.5


def test_a_limit_of_the_data_sheet_is_an_error_of_each_axis(tmp_path) -> None:
    path = tmp_path / "rig.toml"
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    path.write_text(text.replace("[sensors.SN1047]\n", "[sensors.SN1047]\nlargest_nonlinearity_v = 6e-5\n"))
    rig = read_rig(path)
    for errors in shared_errors(rig, rig.sensors["SN1047"]).values():
        (error,) = (error for error in errors if error.name == NONLINEARITY)
        assert (error.effect, error.is_of_one_channel) == ("departure", True)
        assert error.standard_uncertainty == pytest.approx(6e-5 / sqrt(3.0))
        assert "60 µV" in error.stated


@pytest.mark.parametrize("value", ["-1e-5", "nan", "true", '"1e-5"'])
def test_what_is_no_limit_is_refused(tmp_path, value: str) -> None:
    path = tmp_path / "rig.toml"
    text = EXAMPLE_RIG.read_text(encoding="utf-8")
    path.write_text(text.replace("[sensors.SN1047]\n", f"[sensors.SN1047]\nlargest_nonlinearity_v = {value}\n"))
    with pytest.raises(DescriptionError, match="largest_nonlinearity_v"):
        read_rig(path)


def test_check_expects_it_and_the_run_states_it(tmp_path) -> None:
    """Half-widths of what the outcome of one run does not make: the declared limit takes nearly all of them."""
    made = bench(
        tmp_path, rig=(("nominal_sensitivity_v_per_g", "largest_nonlinearity_v = 1e-3\nnominal_sensitivity_v_per_g"),)
    )
    made.run(tmp_path / "run")
    solved = solve_run(tmp_path / "run").sensors["SN1"].calibration
    assert solved is not None
    for expected in check(made.rig, read_procedure(tmp_path / "procedure.toml")).forecast.expected:
        stated = {item.name: item.interval_95 for item in solved.axes[expected.axis].parameters}
        interval, half = stated["offset_v"], expected.half_width_95["offset_v"]
        assert interval is not None
        assert half == pytest.approx(0.5 * (interval[1] - interval[0]), rel=0.1)
        assert half == pytest.approx(1.96e-3 / sqrt(6.0), rel=0.1)


def _held(limit_ug: float, count: int, seed: int) -> float:
    """Return which share of the intervals of unflagged rows holds its angle, of sensors with a step of 5 µg."""
    chance = np.random.default_rng(seed)
    drawn = campaigns("k0-asymmetry", 5.0, chance, count)
    axes, rows = drawn.setup.axes, rows_of(drawn)
    pitch_deg, roll_deg = chance.uniform(-80.0, 80.0, 60), chance.uniform(-180.0, 180.0, 60)
    read_v = drawn.true_output_v(pitch_deg, roll_deg)[:, :, 0]
    limit_v = limit_ug * 1e-6 * V_PER_G
    errors = (SharedError(NONLINEARITY, "departure", limit_v / sqrt(3.0), is_of_one_channel=True),) if limit_ug else ()
    request = CalibrationRequest(shared_errors=dict.fromkeys(axes, errors))
    held = []
    for index in range(count):
        seen = replace(rows, outputs={axis: columns_of(drawn, axis)[:, index] for axis in axes})
        package = Package(build_set(calibrate(seen, request), provenance()), {axis: f"{axis}_v" for axis in axes})
        answer = replace(inference(package, reading_sd_v=1e-9), intervals=True).infer(
            {f"{axis}_v": read_v[index, :, at] for at, axis in enumerate(axes)}
        )
        is_good = np.array([flag == "" for flag in answer["flag"]])
        for name, truth in (("pitch", pitch_deg), ("roll", roll_deg)):
            away_deg = np.abs((answer[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0)
            held.append((away_deg <= answer[f"{name}_half_95_deg"])[is_good])
    return float(np.concatenate(held).mean())


def test_angles_of_a_sensor_with_a_step_at_zero_are_held_within_its_limit_and_without_it_are_not() -> None:
    assert _held(2.5, 8, 3) > 0.93
    assert _held(0.0, 8, 3) < 0.93


@pytest.mark.thorough
@pytest.mark.parametrize("limit_ug", [2.5, 5.0])
def test_up_to_the_limit_itself_angles_are_held(limit_ug: float) -> None:
    assert _held(limit_ug, 30, 7) > 0.93
