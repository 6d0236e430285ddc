"""Plans of what moves: what is planned, in which order, and what is refused before any port is opened."""

from pathlib import Path

import pytest
from motion_runs import motion_run

from procedures.cli.main import run_command
from procedures.errors import PlanError
from procedures.plan.plan import Plan
from procedures.plan.steps import Applied, Follow, Rest, Turn
from rig.errors import DescriptionError

TABLE, SERVO = "rate-table", "servo-mechanism"


def test_every_axis_turns_at_every_rate_in_both_senses_between_two_rests(tmp_path: Path) -> None:
    plan = motion_run(tmp_path, TABLE, "rates").plan
    first = [dwell.motion for dwell in plan.design_dwells if dwell.replication == 1]
    assert isinstance(first[0], Rest)
    assert isinstance(first[-1], Rest)
    turns = [motion for motion in first if isinstance(motion, Turn)]
    assert [(turn.turned_axis, turn.rate_dps) for turn in turns] == [
        (axis, sense * rate) for axis in ("pitch", "yaw", "roll") for rate in (10.0, 40.0) for sense in (1.0, -1.0)
    ]
    for turn in turns:
        assert turn.seconds >= 9.0
        assert turn.seconds * abs(turn.rate_dps) == pytest.approx(360.0 * turn.revolutions)  # whole revolutions
    assert len(plan.check_set) == 1  # at rest, measured again after every restart
    assert plan.replications == 4


def test_an_axis_between_limits_sweeps_in_one_sense_for_as_long(tmp_path: Path) -> None:
    plan = motion_run(tmp_path, SERVO, "gyro").plan
    turns = [dwell.motion for dwell in plan.design_dwells if isinstance(dwell.motion, Turn)]
    for turn in turns:
        assert turn.sweep_deg is not None
        assert (turn.sweep_deg[1] - turn.sweep_deg[0]) * turn.rate_dps > 0.0
        assert turn.seconds >= 300.0
        assert turn.seconds / turn.sweeps < abs(turn.sweep_deg[1] - turn.sweep_deg[0]) / abs(turn.rate_dps)
    assert {turn.sweep_deg for turn in turns if turn.turned_axis == "roll"} == {(-94.0, 94.0), (94.0, -94.0)}


def test_two_levels_lay_every_axis_along_and_against_the_field(tmp_path: Path) -> None:
    plan = motion_run(tmp_path, SERVO, "magnetometer").plan
    dwells = [dwell for dwell in plan.design_dwells if dwell.replication == 1]
    assert [dwell.applied for dwell in dwells] == [Applied("coil", 0.0)] * 6 + [Applied("coil", 40.0)] * 6
    # Of a field straight down, z down: nose down lays x along it, roll right wing down lays y along it.
    assert [(dwell.targets_deg["pitch"], dwell.targets_deg["roll"]) for dwell in dwells[:6]] == [
        (-90.0, 0.0), (90.0, 0.0), (0.0, 90.0), (0.0, -90.0), (0.0, 0.0), (-180.0, 0.0),
    ]  # fmt: skip


def test_a_profile_is_one_motion_a_replication(tmp_path: Path) -> None:
    plan = motion_run(tmp_path, TABLE, "harmonic").plan
    assert len(plan.design_dwells) == plan.replications == 3
    motion = plan.design_dwells[0].motion
    assert isinstance(motion, Follow)
    assert (motion.seconds, dict(motion.span_deg)) == (10.0, {"pitch": 10.0, "yaw": 10.0, "roll": 10.0})


@pytest.mark.parametrize(
    ("example", "procedure"),
    [
        (TABLE, "rates"),
        (TABLE, "harmonic"),
        (SERVO, "gyro"),
        (SERVO, "magnetometer"),
        (SERVO, "drift"),
        (SERVO, "accelerometer"),
    ],
)
def test_a_plan_is_the_same_text_when_it_is_read_back(tmp_path: Path, example: str, procedure: str) -> None:
    plan = motion_run(tmp_path, example, procedure).plan
    assert Plan.from_json(plan.to_json()) == plan
    assert Plan.from_json(plan.to_json()).sha256 == plan.sha256


IN_STEP = {"update_s = 0.027": "update_s = 0.02", "bin_s = 0.108": "bin_s = 0.1"}
ONE_WAY = {
    r"= 10.0": "= 0.01",
    "pitch = 0.125, yaw = 0.0625": "pitch = 0.25, yaw = 0.25",
    "duration_s = 0.01": "duration_s = 10.0",
}
NARROW = {r"limits_deg = \[-185.0, 185.0\]": "limits_deg = [-60.0, 60.0]"}
REFUSED = [
    (TABLE, "rates", {r"yaw_dps = .*\n": ""}, {}, r"toml:\d+: rates: .*three axes, yaw stand still"),
    (TABLE, "rates", {r"roll_dps = .*": "roll_dps = [500.0]"}, {}, r"rates\.roll_dps: .*allowed up to 200 °/s"),
    (TABLE, "rates", {"dwell_s = 9.0": "dwell_s = 90.0"}, {}, r"rates\.pitch_dps: .*the cables bear 5"),
    (TABLE, "rates", {}, {'measures = "rate"\nnominal_.*\n': ""}, r"procedure\.kind: .*measures = \"rate\""),
    (
        TABLE,
        "rates",
        {},
        {r"top_rate_dps = 200.0\nwrap_turns = 5.0\n": ""},
        r"rates\.pitch_dps: .*only goes to positions",
    ),
    (TABLE, "harmonic", {"roll = 10.0 }": "roll = 200.0 }"}, {}, r"profile\.span_deg\.roll: "),
    (TABLE, "harmonic", IN_STEP, {}, r"profile\.update_s: .*keep step"),
    (TABLE, "harmonic", ONE_WAY, {}, r"profile: .*three dimensions"),
    (SERVO, "gyro", {r"pitch_dps = .*": "pitch_dps = [1.0]"}, {}, r"rates\.pitch_dps: .*one unit of .* is 5 °/s"),
    (SERVO, "magnetometer", {r"40\.0": "400.0"}, {}, r"levels\.applied_ut: got 400 µT, allowed -100 to 100 µT"),
    (SERVO, "magnetometer", {'coil = "coil"': 'coil = "other"'}, {}, r"levels\.coil: got 'other', .*fields: coil"),
    (SERVO, "magnetometer", {}, NARROW, r"levels: MicroMag3\.x cannot be laid along"),
]


@pytest.mark.parametrize(("example", "procedure", "changes", "rig_changes", "expected"), REFUSED)
def test_the_impossible_is_refused_with_file_line_and_key(
    tmp_path: Path, example: str, procedure: str, changes: dict[str, str], rig_changes: dict[str, str], expected: str
) -> None:
    with pytest.raises(PlanError, match=expected):
        motion_run(tmp_path, example, procedure, changes, rig_changes)


NO_RATES = {r"\[rates\]": "[static]", r"(?m)^(pitch|yaw|roll)_dps.*\n|^dwell_s.*\n|^tolerance.*\n": ""}
TP_MODEL = {r'model = "gyro"': 'model = "pitch-roll"'}
WRONG = [
    (TABLE, "rates", NO_RATES, "rates: is missing"),
    (TABLE, "rates", TP_MODEL, r"solve\.model: got 'pitch-roll', allowed for kind 'rates'"),
    (TABLE, "harmonic", {r"frequency_hz.*\n": ""}, "needs a frequency_hz for every axis"),
    (TABLE, "harmonic", {"bin_s = 0.108": "bin_s = 0.1"}, r"no whole number of update_s"),
    (SERVO, "magnetometer", {r"\[40\.0\]": "[0.0, 40.0]"}, "applied_ut holds 0"),
    (SERVO, "gyro", {r"(?m)^(pitch|yaw|roll)_dps.*\n": ""}, "give pitch_dps, yaw_dps or roll_dps"),
]


@pytest.mark.parametrize(("example", "procedure", "changes", "expected"), WRONG)
def test_tables_that_do_not_go_together_are_refused(
    tmp_path: Path, example: str, procedure: str, changes: dict[str, str], expected: str
) -> None:
    with pytest.raises(DescriptionError, match=expected):
        motion_run(tmp_path, example, procedure, changes)


@pytest.mark.usefixtures("wide_terminal")
@pytest.mark.parametrize(
    ("example", "procedure", "line"),
    [
        (TABLE, "rates", "pitch at +40 °/s, 1 revolution in 9 s"),
        (TABLE, "harmonic", "harmonic motion of pitch 10°, yaw 10°, roll 10° for 10 s"),
        (SERVO, "gyro", "roll at -9 °/s, 20 sweeps, read for 300 s"),
        (SERVO, "magnetometer", "at rest at roll 90°, coil 40 µT for 60 s"),
        (SERVO, "drift", "at rest level for 1200 s"),
        (SERVO, "accelerometer", "at pitch -90°"),
    ],
)
def test_check_tells_every_dwell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], example: str, procedure: str, line: str
) -> None:
    motion_run(tmp_path, example, procedure)
    assert run_command(["check", str(tmp_path / "procedure.toml"), "--rig", str(tmp_path / "rig.toml")]) == 0
    assert line in capsys.readouterr().out
