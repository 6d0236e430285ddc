"""What the planner refuses before any port is opened (every port here is closed)."""

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
from procedures.plan.plan import Plan
from rig.abilities.targets import check_target, is_on_increment
from rig.errors import DescriptionError, RequestRefused

PITCH = "pitch_deg = { from = -30.0, to = 30.0, step = 10.0 }"
ROLL = "roll_deg = { from = -180.0, to = 180.0, step = 90.0 }"


def plan_of(folder: Path, *changes: tuple[str, str], more: str = "", rig_more: str = "") -> Plan:
    return make_plan(rig_file(folder, more=rig_more), procedure_file(folder, *changes, more=more))


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
    entry = ("replications = 2", "replications = 1")
    grid = [('"D1"', '"D"'), (PITCH, "pitch_deg = [0.0, 30.0]"), (ROLL, "roll_deg = [0.0, 90.0]")]
    assert "1 × 4 dwells for 4 parameters leave no degree of freedom" in refusal(tmp_path, entry, *grid)


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


def test_an_unknown_supply_channel_is_refused_by_the_rig_file(tmp_path):
    with pytest.raises(DescriptionError, match=r"chain\.dmm\.x\.supply_channel: no channel 'dmm\.v' \(allowed: dmm\.t"):
        rig_file(tmp_path, more='[chain."dmm.x"]\nsupply_channel = "dmm.v"\n')


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
            check_target("pitch", axis, angle_deg)


def test_an_end_that_the_chamber_may_not_go_to_is_refused_before_the_night(tmp_path):
    """Every dwell was measured, and then the run tripped at every resume: no set, no export, no archive."""
    more = "[environment]\nplateaus_degc = [20.0]\nend_degc = 200.0\n"
    said = refusal(tmp_path, more=more, rig_more=AIR)
    assert "environment.end_degc: air: setpoint 200 °C, allowed -60 to 150 °C" in said
