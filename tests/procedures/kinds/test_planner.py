"""The plan of a run: what it holds."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from planning_files import AIR, procedure_file, rig_file

from procedures.errors import PlanError
from procedures.kinds.planner import make_plan
from procedures.plan.plan import Plan
from procedures.plan.step_times import axis_move_s
from procedures.plan.steps import Dwell, Soak

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
        f'driver = "{driver}"\nresource = "prologix+socket://127.0.0.1:7#22"'
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
    indices, design_dwells = [], 0
    for dwell in plan.dwells:
        design_dwells += dwell.purpose == "design"
        if dwell.purpose == "reference":
            indices.append(design_dwells)
            assert dwell.targets_deg == {"pitch": 5.0, "roll": 0.0}
    assert indices == [20, 40, 60]


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


def test_an_axis_approached_from_one_side_turns_twice_at_every_dwell(tmp_path):
    pitch = rig_file(tmp_path, ("speed_dps = 5.0", "speed_dps = 5.0\napproach_deg = -2.0")).axes["pitch"]
    turns_s = (10.0 - 2.0) / 5.0 + 2.0 / 5.0 + 2 * 1.3  # to 2° below, then up; lift, seat and lock both times
    assert axis_move_s(pitch, 0.0, 10.0) == pytest.approx(turns_s)
    stay_s = 2.0 / 5.0 + 2.0 / 5.0 + 2 * 1.3
    assert axis_move_s(pitch, 10.0, 10.0) == pytest.approx(stay_s)
