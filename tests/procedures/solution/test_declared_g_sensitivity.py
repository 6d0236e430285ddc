"""What gravity does to the zeros of gyros: declared as a limit, it stands in every rate and angle told with a set."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from example_files import ROOT
from motion_runs import motion_run
from solved import provenance

from ams.analysis.calibration_budget import axis_budget
from ams.calibration.calibrate import calibrate
from ams.frames import AXES, euler_rates_rad_s, from_level_axes
from ams.inference.gyros.gyro_package import GyroPackage
from ams.inference.gyros.rates import GyroAngles, Motion
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import G_SENSITIVITY, SharedError
from ams.observations import Observations
from ams.sets.canonical import table
from ams.sets.coefficients import CoefficientSet, build_set
from procedures.check.check_report import check
from procedures.delivery.deliver import sets_of
from procedures.kinds.read import read_procedure
from procedures.solution.type_b import shared_errors
from rig.description.read import read_rig
from rig.errors import DescriptionError

KEY = "largest_g_sensitivity_dps_per_g"
RATE_TABLE = ROOT / "examples" / "rate-table" / "rig.toml"
LIMIT = 0.02
"""°/s per g, of an ordinary MEMS gyro; the noise of a dwell is that of 0.0001 °/s."""
V_PER_DPS, NOISE_V, HZ = 1.25, 1e-4, 20.0
DOWN = np.array([0.0, 0.0, 1.0])


def declared(path, sensor: str, value: str, source=RATE_TABLE):  # type: ignore[no-untyped-def]
    text = source.read_text(encoding="utf-8")
    assert f"[sensors.{sensor}]\n" in text
    path.write_text(text.replace(f"[sensors.{sensor}]\n", f"[sensors.{sensor}]\n{KEY} = {value}\n"), encoding="utf-8")
    return path


def test_a_limit_of_the_data_sheet_is_an_error_of_each_gyro(tmp_path) -> None:
    rig = read_rig(declared(tmp_path / "rig.toml", "ENC03J", "0.05"))
    for errors in shared_errors(rig, rig.sensors["ENC03J"]).values():
        (error,) = (error for error in errors if error.name == G_SENSITIVITY)
        assert (error.effect, error.kind, error.is_of_one_channel) == ("specific-force", "limit", True)
        assert error.standard_uncertainty == pytest.approx(0.05 / sqrt(3.0))
        assert "0.05 °/s per g" in error.stated
    for errors in shared_errors(rig, rig.sensors["ADXL105"]).values():
        assert not any(error.name == G_SENSITIVITY for error in errors)


@pytest.mark.parametrize("value", ["-0.01", "nan", "inf", "true", '"0.01"'])
def test_what_is_no_limit_is_refused(tmp_path, value: str) -> None:
    with pytest.raises(DescriptionError, match=KEY):
        read_rig(declared(tmp_path / "rig.toml", "ENC03J", value))


@pytest.mark.parametrize(
    ("example", "sensor", "measures"),
    [("rate-table", "ADXL105", "acceleration"), ("servo-mechanism", "MicroMag3", "field")],
)
def test_of_what_is_no_gyro_it_is_refused(tmp_path, example: str, sensor: str, measures: str) -> None:
    source = ROOT / "examples" / example / "rig.toml"
    with pytest.raises(DescriptionError, match=f"{KEY} is what gravity does to a gyro.*measures {measures}; remove it"):
        read_rig(declared(tmp_path / "rig.toml", sensor, "0.01", source))


def stages(*, tumbled: bool) -> tuple[np.ndarray, np.ndarray]:
    """Rates of a table's three stages and the mean turn of the package meanwhile, (N, 3) °/s and (N, 3, 3).

    Whole turns about a level axis leave no mean force across it; ``tumbled``: at rest the package also stands on its
    head, as often as upright, and the stage about the vertical turns it so as well.
    """
    velocity, turns = [], []
    for head in (1.0, -1.0) if tumbled else (1.0, 1.0):
        upright = np.diag([1.0, head, head])
        for axis, own in enumerate((np.diag([1.0, 0.0, 0.0]), np.diag([0.0, 1.0, 0.0]), upright)):
            for rate in (-40.0, -10.0, 10.0, 40.0):
                velocity.append(rate * np.eye(3)[axis])
                turns.append(own)
        velocity += [np.zeros(3)] * 2
        turns += [upright] * 2
    return np.array(velocity), np.array(turns)


def drawn_rows(force_v_per_g: np.ndarray, chance: np.random.Generator, *, tumbled: bool = False) -> Observations:
    """Three replications of gyros whose zeros follow the force by the rows of (3, 3)."""
    velocity, turns = stages(tumbled=tumbled)
    velocity, turns, points = np.tile(velocity, (3, 1)), np.tile(turns, (3, 1, 1)), len(velocity)
    output = 0.05 + V_PER_DPS * velocity - turns @ DOWN @ force_v_per_g.T
    output = output + NOISE_V * chance.standard_normal(output.shape)
    still = np.zeros(3 * points)
    return Observations(
        np.repeat(np.arange(3), points), np.tile(np.arange(points), 3), still, still,
        {axis: output[:, index] for index, axis in enumerate(AXES)},
        yaw_rad=still, euler_rate_rad_s=euler_rates_rad_s(np.zeros((len(still), 3)), np.deg2rad(velocity)),
        from_level=turns,
    )  # fmt: skip


def request(limit: float) -> CalibrationRequest:
    error = SharedError(G_SENSITIVITY, "specific-force", limit / sqrt(3.0), "limit", is_of_one_channel=True)
    shared = dict.fromkeys(AXES, (error,)) if limit else {}
    return CalibrationRequest(model="gyro", nominal_axes={axis: axis for axis in AXES}, shared_errors=shared)


def within(limit: float, chance: np.random.Generator) -> np.ndarray:
    """(3, 3) V/g, every gyro with a vector of the whole length of the limit in a direction of its own."""
    towards = chance.standard_normal((3, 3))
    return np.asarray(limit * V_PER_DPS * towards / np.linalg.norm(towards, axis=1, keepdims=True))


def set_of(rows: Observations, limit: float) -> CoefficientSet:
    origin = replace(provenance(), yaw_range_deg=(0.0, 0.0), rate_range_dps=(-60.0, 60.0))
    return build_set(calibrate(rows, request(limit)), origin)


@pytest.mark.parametrize(("tumbled", "mean_g"), [(False, 12.0 / 28.0), (True, 0.0)])
def test_the_offset_is_as_uncertain_as_the_farthest_attitude_is_away(*, tumbled: bool, mean_g: float) -> None:
    """One g against the mean force of the calibration, which is none where every attitude has its opposite."""
    chance = np.random.default_rng(1)
    rows = drawn_rows(within(LIMIT, chance), chance, tumbled=tumbled)
    solved = calibrate(rows, request(LIMIT))
    for label, axis in solved.axes.items():
        (line,) = (line for line in axis_budget(axis, request(LIMIT).shared_errors[label]).lines
                   if line.source == G_SENSITIVITY)  # fmt: skip
        assert line.type == "B"
        expected_v = LIMIT * V_PER_DPS / sqrt(3.0) * (1.0 + mean_g)
        assert line.contributions["offset_v"] == pytest.approx(expected_v, rel=0.02)
        assert line.contributions["sensitivity_v_per_dps"] < 1e-3 * V_PER_DPS * LIMIT
    without = replace(rows, from_level=None)
    (part,) = (part for part in calibrate(without, request(LIMIT)).axes["x"].variance_components
               if part.name == G_SENSITIVITY)  # fmt: skip
    assert sqrt(part.covariance[0, 0]) == pytest.approx(2.0 * LIMIT * V_PER_DPS / sqrt(3.0), rel=1e-3)


def _at_end(stream: GyroAngles, read_v: np.ndarray) -> dict[str, float]:
    parts = stream.answer({f"{axis}_v": read_v[:, index] for index, axis in enumerate(AXES)}), stream.finish()
    return {name: float(np.concatenate([part.columns[name] for part in parts])[-1]) for name in parts[0].columns}


def _held(limit: float, roll_deg: float, count: int, seed: int, *, tumbled: bool = False) -> float:
    """Return which share of the intervals holds pitch, yaw and roll after ten seconds at rest, at that roll."""
    chance = np.random.default_rng(seed)
    turn = from_level_axes(*np.deg2rad([np.zeros(1), np.zeros(1), np.full(1, roll_deg)]))[0]
    held = []
    for _ in range(count):
        force = within(LIMIT, chance)
        coefficients = set_of(drawn_rows(force, chance, tumbled=tumbled), limit)
        read_v = 0.05 - force @ turn @ DOWN + NOISE_V * chance.standard_normal((round(10.0 * HZ), 3))
        stream = GyroAngles(
            GyroPackage(coefficients, {axis: f"{axis}_v" for axis in AXES}, NOISE_V),
            Motion(HZ, start_deg=(0.0, 0.0, roll_deg)),
        )
        found = _at_end(stream, read_v)
        for name, truth in (("pitch", 0.0), ("yaw", 0.0), ("roll", roll_deg)):
            away = (found[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0
            held.append(abs(away) <= 1.96 * found[f"{name}_sd_deg"])
    return float(np.mean(held))


@pytest.mark.parametrize("roll_deg", [90.0, 180.0])
def test_rates_of_gyros_that_were_calibrated_upright_are_held_on_their_side_and_on_their_head(roll_deg: float) -> None:
    assert _held(LIMIT, roll_deg, 12, 3) >= 0.95
    assert _held(0.0, roll_deg, 12, 3) < 0.5


@pytest.mark.thorough
@pytest.mark.parametrize("tumbled", [False, True])
@pytest.mark.parametrize("roll_deg", [0.0, 45.0, 90.0, 135.0, 180.0])
def test_they_are_held_at_every_attitude(*, tumbled: bool, roll_deg: float) -> None:
    assert _held(LIMIT, roll_deg, 140, 5, tumbled=tumbled) >= 0.95


def _held_after_rest(limit: float, count: int, seed: int) -> float:
    """The zero is taken upright, over two seconds; then the package is turned on its head within one and stays."""
    chance = np.random.default_rng(seed)
    held = []
    time_s = np.arange(round(13.0 * HZ)) / HZ
    roll_deg = 180.0 * np.clip(time_s - 2.0, 0.0, 1.0)
    rate_dps = np.where((time_s >= 2.0) & (time_s < 3.0), 180.0, 0.0)
    turns = from_level_axes(np.zeros_like(time_s), np.zeros_like(time_s), np.deg2rad(roll_deg))
    for _ in range(count):
        force = within(LIMIT, chance)
        coefficients = set_of(drawn_rows(force, chance, tumbled=True), limit)
        read_v = 0.05 + V_PER_DPS * rate_dps[:, None] * np.eye(3)[0] - turns @ DOWN @ force.T
        read_v = read_v + NOISE_V * chance.standard_normal(read_v.shape)
        package = GyroPackage(coefficients, {axis: f"{axis}_v" for axis in AXES}, NOISE_V)
        stream = GyroAngles(package, Motion(HZ, interpolation="hold", rest_s=2.0))
        found = _at_end(stream, read_v)
        at_end = 180.0 * np.cumsum(rate_dps > 0.0)[-1] / HZ
        for name, truth in (("pitch", 0.0), ("yaw", 0.0), ("roll", at_end)):
            away = (found[f"{name}_deg"] - truth + 180.0) % 360.0 - 180.0
            held.append(abs(away) <= 1.96 * found[f"{name}_sd_deg"])
    return float(np.mean(held))


def test_a_zero_that_was_taken_at_rest_holds_at_the_attitude_of_the_rest() -> None:
    assert _held_after_rest(LIMIT, 12, 7) >= 0.95
    assert _held_after_rest(0.0, 12, 7) < 0.6


def test_the_run_states_it_once_and_check_expects_it(tmp_path) -> None:
    short = {r"replications = 4": "replications = 2", r"\[10.0, 40.0\]": "[90.0]", r"dwell_s = 9.0": "dwell_s = 4.0"}
    made = motion_run(
        tmp_path, "rate-table", "rates", short, {r"\[sensors.ENC03J\]\n": f"[sensors.ENC03J]\n{KEY} = 0.5\n"}
    )
    solved = made.solved()
    sensor = solved.sensors["ENC03J"]
    assert sensor.calibration is not None
    assert not any("g-sensitivity" in text for text in (*sensor.calibration.remarks, *sensor.calibration.warnings))
    section = table(table(sets_of(solved)["ENC03J"].document["axes"])["x"])
    assert table(section["notes"])[KEY] == pytest.approx(0.5)
    assert G_SENSITIVITY in table(table(section["primary"])["components"])
    for axis, budget in sensor.budgets.items():
        (line,) = (line for line in budget.lines if line.source == G_SENSITIVITY)
        assert "0.5 °/s per g" in line.stated
        stated = {item.name: item.interval_95 for item in sensor.calibration.axes[axis].parameters}["offset_v"]
        (expected,) = (
            item
            for item in check(made.rig, read_procedure(tmp_path / "procedure.toml")).forecast.expected
            if item.axis == axis and "offset_v" in item.half_width_95
        )
        assert stated is not None
        assert expected.half_width_95["offset_v"] == pytest.approx(0.5 * (stated[1] - stated[0]), rel=0.1)
