"""The plan of a run: what it holds, and what it refuses before any port is opened (every port here is closed)."""

from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_files import AIR, procedure_file, rig_file

from procedures.description.procedure_file import Order
from procedures.errors import ExitStatus, PlanError
from procedures.kinds.planner import make_plan
from procedures.plan.plan import Plan, summary
from procedures.plan.steps import Dwell, Soak
from rig.devices.targets import check_target, is_on_increment
from rig.errors import DescriptionError, RequestRefused

PITCH = "pitch_deg = { from = -30.0, to = 30.0, step = 10.0 }"
ROLL = "roll_deg = { from = -180.0, to = 180.0, step = 90.0 }"


def plan_of(folder: Path, *changes: tuple[str, str], more: str = "", rig_more: str = "") -> Plan:
    return make_plan(rig_file(folder, more=rig_more), procedure_file(folder, *changes, more=more))


def test_minus_90_to_90_by_10_is_exactly_19_values(tmp_path):
    plan = plan_of(tmp_path, (PITCH, "pitch_deg = { from = -90.0, to = 90.0, step = 10.0 }"))
    assert plan.design.pitch_values_deg == tuple(float(angle) for angle in range(-90, 91, 10))


def test_steps_of_a_tenth_hold_decimals_and_not_their_binary_neighbours(tmp_path):
    rig = rig_file(tmp_path, ("increment_deg = 1.0", "increment_deg = 0.0001"))
    procedure = procedure_file(tmp_path, (PITCH, "pitch_deg = { from = -1.0, to = 1.0, step = 0.1 }"))
    assert make_plan(rig, procedure).design.pitch_values_deg[13] == 0.3


def test_every_replication_holds_every_point_once(tmp_path):
    plan = plan_of(tmp_path)
    for replication in (1, 2):
        labels = [dwell.point for dwell in plan.design_dwells if dwell.replication == replication]
        assert sorted(labels) == list(range(1, 36))


def test_a_burst_that_the_unit_cannot_hold_is_refused_before_a_port_is_opened(tmp_path):
    # 34970A/34972A: a reading memory of 50 000 (UG-K p. 122); a procedure may ask for 100 000.
    daq = (
        f'driver = "{driver}"\nresource = "prologix+socket://127.0.0.1:1#22"'
        for driver in ("hp3458a", 'scpi-daq"\nmodel = "34970A')
    )
    rig = rig_file(tmp_path, tuple(daq), *((f"scanner = {n}", f"channel = {100 + n}") for n in (1, 2, 3, 4)))
    assert make_plan(rig, procedure_file(tmp_path, more="[dwell]\nsamples = 50000\n")).dwell.samples == 50_000
    with pytest.raises(PlanError, match=r"toml:\d+: dwell\.samples: readouts\.dmm holds 50000 .* got 50001"):
        make_plan(rig, procedure_file(tmp_path, more="[dwell]\nsamples = 50001\n"))
    assert make_plan(rig_file(tmp_path), procedure_file(tmp_path, more="[dwell]\nsamples = 100000\n"))


def test_steps_are_numbered_in_their_order(tmp_path):
    plan = plan_of(tmp_path, more="[check]\nreference_every = 7\n[environment]\nplateaus_degc = [20.0]\n", rig_more=AIR)
    assert [step.step for step in plan.steps] == list(range(len(plan.steps)))


def test_the_check_set_of_a_full_roll_circle_is_a_six_point_tumble(tmp_path):
    plan = plan_of(tmp_path, (PITCH, "pitch_deg = { from = -90.0, to = 90.0, step = 30.0 }"))
    pitch, roll = (np.deg2rad([dwell.targets_deg[axis] for dwell in plan.check_set]) for axis in ("pitch", "roll"))
    force = np.stack([np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    assert np.allclose(force @ force.T, 2.0 * np.eye(3))
    assert [step.purpose for step in plan.dwells[:6]] == ["check"] * 6
    assert {(dwell.replication, dwell.point) for dwell in plan.check_set} == {(0, 0)}


def test_check_attitudes_are_attitudes_of_the_design(tmp_path):
    plan = plan_of(tmp_path)
    design = {(point.pitch_deg, point.roll_deg) for point in plan.design.points}
    checked = [(dwell.targets_deg["pitch"], dwell.targets_deg["roll"]) for dwell in plan.check_set]
    assert set(checked) <= design
    assert len(set(checked)) == 6


def test_the_reference_attitude_comes_after_every_so_many_design_dwells(tmp_path):
    plan = plan_of(tmp_path, more="[check]\nreference_every = 20\npitch_deg = 5.0\n")
    places, design_dwells = [], 0
    for dwell in plan.dwells:
        design_dwells += dwell.purpose == "design"
        if dwell.purpose == "reference":
            places.append(design_dwells)
            assert dwell.targets_deg == {"pitch": 5.0, "roll": 0.0}
    assert places == [20, 40, 60]


def test_each_plateau_is_soaked_once_and_holds_all_its_replications(tmp_path):
    plan = plan_of(tmp_path, more="[environment]\nplateaus_degc = [10.0, 30.0, 10.0]\n", rig_more=AIR)
    assert [(soak.environment, soak.setpoint_degc) for soak in plan.soaks] == [
        ("air", 10.0),
        ("air", 30.0),
        ("air", 10.0),
    ]
    assert plan.replications == 6
    labels = [step.replication if isinstance(step, Dwell) else -1 for step in plan.steps if _is_of_the_plot(step)]
    assert [label for label, last in zip(labels, [None, *labels], strict=False) if label != last] == [
        -1, 1, 2, -1, 3, 4, -1, 5, 6,
    ]  # fmt: skip


def _is_of_the_plot(step) -> bool:
    return isinstance(step, Soak) or step.purpose == "design"


def test_axes_move_from_outside_in_and_a_yaw_axis_stays_at_zero(tmp_path):
    yaw = '[axes.yaw]\ndriver = "indexing-table"\nport = "socket://127.0.0.1:1"\nincrement_deg = 1.0\n'
    plan = plan_of(tmp_path, rig_more=yaw + "limits_deg = [-90.0, 90.0]\nspeed_dps = 5.0\naxis = 3\n")
    assert plan.axes == ("pitch", "yaw", "roll")
    assert {tuple(dwell.targets_deg) for dwell in plan.dwells} == {("pitch", "yaw", "roll")}
    assert {dwell.targets_deg["yaw"] for dwell in plan.dwells} == {0.0}


def test_a_plan_comes_back_from_its_json_equal_with_the_same_hash(tmp_path):
    more = "[check]\nreference_every = 7\n[environment]\nplateaus_degc = [20.0]\n[stop]\nmax_duration_s = 90000.0\n"
    plan = plan_of(tmp_path, more=more, rig_more=AIR)
    again = Plan.from_json(plan.to_json())
    assert again == plan
    assert again.sha256 == plan.sha256
    assert all(list(a.targets_deg) == list(b.targets_deg) for a, b in zip(plan.dwells, again.dwells, strict=True))


def test_the_hash_tells_plans_apart(tmp_path):
    assert plan_of(tmp_path).sha256 == plan_of(tmp_path).sha256
    assert plan_of(tmp_path).sha256 != plan_of(tmp_path, ("replications = 2", "replications = 3")).sha256


def test_a_plan_of_another_version_is_refused(tmp_path):
    text = plan_of(tmp_path).to_json().replace('"version":1', '"version":2', 1)
    with pytest.raises(PlanError, match="plan version: got 2, allowed 1"):
        Plan.from_json(text, "plan.json")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"version":1}', '{"version":1,"title":3}'])
def test_what_is_no_plan_is_refused(text):
    with pytest.raises(PlanError, match=r"plan\.json: "):
        Plan.from_json(text, "plan.json")


def test_a_summary_has_everything_but_steps_and_points(tmp_path):
    assert {"title", "axes", "channels", "expected"} <= set(summary(plan_of(tmp_path)))
    assert "steps" not in summary(plan_of(tmp_path))


def test_an_order_of_chance_is_drawn_once_and_kept(tmp_path):
    procedure = procedure_file(tmp_path, more='order = "random"\n')
    rig = rig_file(tmp_path)
    assert make_plan(rig, procedure, fresh_seed=3) == make_plan(rig, procedure, fresh_seed=3)
    assert make_plan(rig, procedure, fresh_seed=3).seed == 3
    first, second = make_plan(rig, procedure), make_plan(rig, procedure)
    assert first.seed is not None
    assert first.seed != second.seed
    by_replication = [[d.point for d in first.design_dwells if d.replication == label] for label in (1, 2)]
    assert by_replication[0] != by_replication[1]


def test_a_seeded_order_is_the_files(tmp_path):
    procedure = procedure_file(tmp_path, more='order = "seeded"\nseed = 11\n')
    assert make_plan(rig_file(tmp_path), procedure).seed == 11
    assert make_plan(rig_file(tmp_path), procedure) == make_plan(rig_file(tmp_path), procedure)


def test_a_tumble_has_six_points_with_roll_and_four_without(tmp_path):
    tumble = [('kind = "grid"', 'kind = "tumble"'), ('kind = "D1"', 'kind = "T"'), (PITCH, ""), (ROLL, "")]
    assert len(plan_of(tmp_path, *tumble).design.points) == 6
    rig = rig_file(
        tmp_path, ('"three-axis package"', '"single-axis package"'), (', y = "dmm.y", z = "dmm.z" }\nnom', " }\nnom")
    )
    procedure = procedure_file(tmp_path, *tumble, more='[solve]\nmodel = "pitch-only"\n')
    assert len(make_plan(rig, procedure).design.points) == 4


def refusal(folder: Path, *changes: tuple[str, str], more: str = "", rig_more: str = "", rig_changes=()) -> str:
    with pytest.raises(PlanError) as caught:
        make_plan(rig_file(folder, *rig_changes, more=rig_more), procedure_file(folder, *changes, more=more))
    assert caught.value.exit_status is ExitStatus.WRONG_REQUEST
    return str(caught.value).replace(str(folder), "")


def test_a_point_beyond_a_limit_is_refused_with_axis_point_and_distance(tmp_path):
    text = refusal(tmp_path, rig_changes=[("limits_deg = [-180.0, 180.0]", "limits_deg = [-180.0, 25.0]")])
    assert text.startswith("/procedure.toml:8: design.pitch_deg: point 31 asks for pitch 30°, allowed -180 to 25°")
    assert "5° too far" in text
    assert "nothing moved" in text


def test_a_limit_is_inside_and_the_least_angle_beyond_it_is_not(tmp_path):
    def with_limit(high_deg):
        return [("limits_deg = [-180.0, 180.0]", f"limits_deg = [-30.0, {high_deg}]"), ("= 1.0", "= 0.1")]

    assert make_plan(rig_file(tmp_path, *with_limit(30.0)), procedure_file(tmp_path)).steps
    assert "0.1° too far" in refusal(tmp_path, rig_changes=with_limit(29.9))


def test_the_approach_to_a_point_must_stay_inside_the_limits_too(tmp_path):
    change = ("limits_deg = [-180.0, 180.0]", "limits_deg = [-30.0, 30.0]\napproach_deg = 2.0")
    assert "2° too far with its approach of 2°" in refusal(tmp_path, rig_changes=[change])


def test_an_angle_off_the_increment_is_refused_with_its_neighbours(tmp_path):
    text = refusal(tmp_path, (PITCH, "pitch_deg = { from = -30.0, to = 30.0, step = 7.5 }"))
    assert text.startswith("/procedure.toml:8: design.pitch_deg: point 6 asks for pitch -22.5°")
    assert "multiples of 1°" in text
    assert "nearest -23° and -22°" in text
    assert "20 of 45 points" in text


def test_increments_count_from_the_tables_zero(tmp_path):
    off = ("increment_deg = 1.0", "increment_deg = 1.0\nzero_deg = 0.5\nsign = -1")
    assert "nearest -30.5° and -29.5°" in refusal(tmp_path, rig_changes=[off])
    halves = (PITCH, "pitch_deg = [-29.5, -10.5, 0.5, 10.5, 29.5]")
    assert make_plan(rig_file(tmp_path, off), procedure_file(tmp_path, halves, ('"D1"', '"D0"'))).steps


@settings(max_examples=100, deadline=None)
@given(increment=st.sampled_from([0.0001, 0.1, 0.3, 1.0, 15.0]), multiple=st.integers(-300, 300))
def test_every_decimal_multiple_of_an_increment_is_allowed(increment, multiple):
    from decimal import Decimal

    from rig.devices.indexing_table import IndexingTableSettings

    axis = IndexingTableSettings(
        driver="indexing-table", port="twin", limits_deg=(-180.0, 180.0), speed_dps=1.0, increment_deg=increment
    )
    angle = float(Decimal(repr(increment)) * multiple)
    assert is_on_increment(axis.table_deg(angle), increment)
    assert not is_on_increment(axis.table_deg(angle + increment / 2.0), increment)


def test_a_missing_axis_is_refused(tmp_path):
    text = refusal(tmp_path, rig_changes=[("[axes.roll]", "[axes.yaw]")])
    assert (
        "/procedure.toml:9: design.roll_deg: needs the axis roll, which the rig does not have (it has: pitch, yaw)"
        in text
    )


def test_fewer_points_than_parameters_are_refused(tmp_path):
    text = refusal(tmp_path, ('"D1"', '"D"'), (PITCH, "pitch_deg = [0.0]"), (ROLL, "roll_deg = [0.0, 90.0, 180.0]"))
    assert (
        "/procedure.toml:6: design: 3 different attitudes for 4 parameters (offset, sensitivity, coning angle, azimuth)"
        in text
    )


def test_as_many_dwells_as_parameters_leave_no_uncertainty(tmp_path):
    one = ("replications = 2", "replications = 1")
    grid = [('"D1"', '"D"'), (PITCH, "pitch_deg = [0.0, 30.0]"), (ROLL, "roll_deg = [0.0, 90.0]")]
    assert "1 × 4 dwells for 4 parameters leave no degree of freedom" in refusal(tmp_path, one, *grid)


def test_roll_at_one_value_only_is_refused_naming_the_parameters(tmp_path):
    text = refusal(tmp_path, (ROLL, "roll_deg = [0.0]"))
    assert text.startswith("/procedure.toml:9: design.roll_deg: roll at one value only (0°): coning and azimuth")
    assert 'solve.model = "pitch-only"' in text
    assert "roll at one value only" in refusal(tmp_path, (ROLL, ""))


def test_pitch_at_one_value_only_is_refused_naming_the_parameters(tmp_path):
    text = refusal(tmp_path, ('"D1"', '"D0"'), (PITCH, "pitch_deg = [30.0]"))
    assert "pitch at one value only (30°): offset and k forward cannot be determined" in text


def test_a_design_blind_to_one_parameter_is_refused(tmp_path):
    text = refusal(tmp_path, ('"D1"', '"D"'), (ROLL, "roll_deg = [0.0, 180.0]"))
    assert "these attitudes cannot tell k right of model pitch-roll apart" in text


def test_temperature_terms_need_a_temperature_reading(tmp_path):
    assert "SN1 has no temperature channel" in refusal(tmp_path, more='[solve]\ntemperature = "estimate"\n')


def test_known_coefficients_must_be_given_for_every_axis_and_no_other(tmp_path):
    known = "{ offset_tc_v_per_degc = 1e-5, sensitivity_tc_per_degc = 1e-5, reference_temperature_degc = 20.0 }"
    more = f'[solve]\ntemperature = "apply"\nknown_temperature = {{ "SN1.x" = {known}, "SN2.x" = {known} }}\n'
    text = refusal(tmp_path, more=more, rig_more=AIR)
    assert "coefficients of SN1.y are missing" in text
    assert "the rig has no SN2.x (it has: SN1.x, SN1.y, SN1.z)" in text


@pytest.mark.parametrize(
    ("plateaus", "sentence"),
    [("[20.0, 23.0, 20.0]", "span 3 °C, needed 5 °C"), ("[10.0, 20.0, 30.0]", "correlated by 1.00, allowed 0.8")],
)
def test_plateaus_that_cannot_tell_temperature_from_time_are_refused(tmp_path, plateaus, sentence):
    more = f'[environment]\nplateaus_degc = {plateaus}\n[solve]\ntemperature = "estimate"\n'
    assert sentence in refusal(tmp_path, more=more, rig_more=AIR)


def test_plateaus_need_an_environment_of_the_rig(tmp_path):
    more = "[environment]\nplateaus_degc = [20.0]\n"
    assert "plateaus need one environment of the rig, which has: none" in refusal(tmp_path, more=more)
    assert "got 'oven', the rig has: air" in refusal(tmp_path, more=more + 'name = "oven"\n', rig_more=AIR)


def test_without_roll_a_sensor_along_y_is_refused(tmp_path):
    text = refusal(tmp_path, (ROLL, ""), more='[solve]\nmodel = "pitch-only"\n')
    assert "solve.model: SN1.y: model pitch-only: got nominal axis y, allowed x or z" in text


def test_a_d1_that_is_none_is_refused_with_file_and_line(tmp_path):
    text = refusal(tmp_path, (PITCH, "pitch_deg = [-30.0, 0.0, 20.0]"))
    assert text.startswith("/procedure.toml:7: design.kind: pitch: got 3 values from -30° to 20°")


def test_a_file_of_points_stands_beside_the_procedure(tmp_path):
    (tmp_path / "points.csv").write_text("pitch_deg,roll_deg\n0,0\n30,0\n0,90\n0,180\n-30,90\n", encoding="utf-8")
    changes = [('kind = "D1"', 'kind = "file"\nfile = "points.csv"'), (PITCH, ""), (ROLL, "")]
    assert len(plan_of(tmp_path, *changes).design.points) == 5
    (tmp_path / "points.csv").unlink()
    assert "points.csv: the points cannot be read" in refusal(tmp_path, *changes)


def test_a_tumble_with_angles_of_its_own_is_refused(tmp_path):
    text = refusal(tmp_path, ('kind = "grid"', 'kind = "tumble"'), ('kind = "D1"', 'kind = "T"'))
    assert '/procedure.toml:8: design.pitch_deg: kind = "T" has attitudes of its own' in text


def test_every_reason_is_told_at_once(tmp_path):
    text = refusal(
        tmp_path, (PITCH, "pitch_deg = { from = -187.5, to = 187.5, step = 7.5 }"), (ROLL, "roll_deg = [0.0]")
    )
    assert len(text.splitlines()) == 3


def test_the_expected_duration_counts_moves_settling_and_readings(tmp_path):
    dwell = "[dwell]\nsamples = 10\nsettle = { window_s = 1.0, windows = 2, min_s = 2.0, max_s = 60.0 }\n"
    plan = plan_of(tmp_path, more=dwell)
    turns = [
        (abs(there.targets_deg[axis] - here.targets_deg[axis]), speed_dps)
        for here, there in pairwise(plan.dwells)
        for axis, speed_dps in (("pitch", 5.0), ("roll", 10.0))
    ]
    moving_s = sum(turn_deg / speed_dps + 1.3 for turn_deg, speed_dps in turns if turn_deg)  # 1.3 s: lift, seat, lock
    reading_s = 3 * 10 * 2 * 10 / 50  # channels × samples × autozero × NPLC / 50 Hz
    around_s = 2 * (0.5 + 1.3) + 3.0  # two axes home, the standstill at the end
    assert plan.expected.p50_s == pytest.approx(moving_s + (6 + 2 * 35) * (2.0 + reading_s) + around_s)
    assert plan.expected.p90_s > plan.expected.p50_s


def test_temperatures_and_supplies_are_read_with_the_outputs(tmp_path):
    own = '[sensors.SN1.temperature]\nchannel = "dmm.t"\noffset_degc = 0.0\nslope_degc_per_v = 100.0\n'
    assert plan_of(tmp_path, rig_more=own).channels == ("dmm.x", "dmm.y", "dmm.z", "dmm.t")
    supply = '[chain."dmm.x"]\nsupply_channel = "dmm.t"\n[chain."dmm.y"]\nsupply_channel = "dmm.t"\n'
    assert plan_of(tmp_path, rig_more=supply).channels == ("dmm.x", "dmm.y", "dmm.z", "dmm.t")


def test_an_unknown_supply_channel_is_refused_by_the_rig_file(tmp_path):
    with pytest.raises(DescriptionError, match=r"chain\.dmm\.x\.supply_channel: no channel 'dmm\.v' \(allowed: dmm\.t"):
        rig_file(tmp_path, more='[chain."dmm.x"]\nsupply_channel = "dmm.v"\n')


def test_an_axis_approached_from_one_side_turns_twice_at_every_dwell(tmp_path):
    from procedures.plan.step_times import move_s

    axes = rig_file(tmp_path, ("speed_dps = 5.0", "speed_dps = 5.0\napproach_deg = -2.0")).axes
    turns_s = (10.0 - 2.0) / 5.0 + 2.0 / 5.0 + 2 * 1.3  # to 2° below, then up; lift, seat and lock both times
    assert move_s(axes, {"pitch": 0.0, "roll": 5.0}, {"pitch": 10.0, "roll": 5.0}) == pytest.approx(turns_s)
    stay_s = 2.0 / 5.0 + 2.0 / 5.0 + 2 * 1.3
    assert move_s(axes, {"pitch": 10.0, "roll": 5.0}, {"pitch": 10.0, "roll": 5.0}) == pytest.approx(stay_s)


@settings(max_examples=75, deadline=None)
@given(
    low=st.sampled_from([-180, -78, -73, -70, -69]),
    high=st.sampled_from([180, 78, 73, 70, 69]),
    increment=st.sampled_from(["0.1", "0.5", "2.5", "7.0"]),
    sign=st.sampled_from([1, -1]),
    zero=st.sampled_from(["0.0", "0.5", "-3.0"]),
    approach=st.sampled_from(["0.0", "1.0", "-2.5", "7.0"]),
    step=st.sampled_from(["2.5", "5.0", "7.0", "10.0"]),
    order=st.sampled_from(get_args(Order)),
)
def test_whatever_is_not_refused_passes_the_drivers_own_check(
    tmp_path_factory, low, high, increment, sign, zero, approach, step, order
):
    """The driver's check before a move is the judge: every target, and every approach to it."""
    folder = tmp_path_factory.mktemp("files")
    machine = f"limits_deg = [{low}.0, {high}.0]\nsign = {sign}\nzero_deg = {zero}\napproach_deg = {approach}"
    rig = rig_file(
        folder, ("limits_deg = [-180.0, 180.0]", machine), ("increment_deg = 1.0", f"increment_deg = {increment}")
    )
    pitch = "pitch_deg = { from = -70.0, to = 70.0, step = " + step + " }"
    procedure = procedure_file(folder, (PITCH, pitch), more=f'order = "{order}"\n')
    try:
        plan = make_plan(rig, procedure)
    except PlanError:
        with pytest.raises(RequestRefused):
            _send_everywhere(rig.axes["pitch"], [float(angle) for angle in np.arange(-70.0, 70.1, float(step))])
    else:
        _send_everywhere(rig.axes["pitch"], [dwell.targets_deg["pitch"] for dwell in plan.dwells])


def _send_everywhere(axis, targets_deg):
    for target_deg in targets_deg:
        for angle_deg in {target_deg, target_deg + axis.approach_deg}:
            check_target("pitch", angle_deg, axis.sign * angle_deg + axis.zero_deg, axis.limits_deg, axis.increment_deg)
