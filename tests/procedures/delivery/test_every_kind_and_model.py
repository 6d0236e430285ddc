"""Every kind of run by every model that it offers: from the twin to the archive, and to the next run's pilot.

What serves all kinds asks each for its numbers by the names of its own form; a name taken for granted shows here.
"""

from collections.abc import Callable
from pathlib import Path

import pytest
from motion_runs import motion_run
from small_run import RIG, Bench, bench

from ams.archive.lessons import past_lessons
from procedures.delivery.deliver import deliver, solve_run
from procedures.delivery.parts import DONE, NOT_DUE
from procedures.errors import RequestError
from procedures.kinds.read import read_procedure
from procedures.kinds.registry import KINDS
from procedures.solution.pilot import pilot_of, shown_in

pytestmark = pytest.mark.usefixtures("no_report")

YAW = (
    "[readouts.dmm]",
    '[axes.yaw]\ndriver = "indexing-table"\nport = "twin"\nincrement_deg = 1.0\nlimits_deg = [-90.0, 90.0]\n'
    "speed_dps = 180.0\naxis = 3\n[readouts.dmm]",
)
X_ALONE = (
    ('model = "three-axis package"', 'model = "single-axis package"'),
    ('channels = { x = "dmm.x", y = "dmm.y", z = "dmm.z" }', 'channels = { x = "dmm.x" }'),
    *((line, "") for line in RIG.splitlines() if line.startswith(("y = ", "z = "))),
)
DESIGN = (
    'kind = "D"\npitch_deg = { from = -30.0, to = 30.0, step = 30.0 }\n'
    "roll_deg = { from = -180.0, to = 90.0, step = 90.0 }\n"
)
CHECKS = "[check]\nreference_every = 7\n"
Laid = Callable[[Path], Bench]
"""A folder to the run that its files ask for."""


def attitudes(kind: str, model: str, design: str = DESIGN, *rig: tuple[str, str]) -> Laid:
    changes = (
        ('kind = "grid"', f'kind = "{kind}"'), (DESIGN, design), (CHECKS, f'[solve]\nmodel = "{model}"\n')
    )  # fmt: skip
    return lambda folder: bench(folder, rig, changes)


def motions(example: str, procedure: str, model: str, **changes: str) -> Laid:
    wanted = {r'model = ".*"': f'model = "{model}"', r"replications = \d": "replications = 2"}
    wanted |= {rf"{key} = .*": f"{key} = {value}" for key, value in changes.items()}

    def laid(folder: Path) -> Bench:
        made = motion_run(folder, example, procedure, wanted)
        return Bench(folder, made.rig, made.plan)

    return laid


PITCHES = 'kind = "D"\npitch_deg = { from = -60.0, to = 60.0, step = 30.0 }\nroll_deg = [0.0]\n'
GIMBAL = DESIGN + "yaw_deg = [-30.0, 0.0, 30.0]\n"
UP_DOWN = 'kind = "up-down"\norder = "raster"\n'
WIDE = "{ pitch = 60.0, yaw = 60.0, roll = 60.0 }"
SPEEDS = {"pitch_dps": "[90.0]", "yaw_dps": "[90.0]", "roll_dps": "[90.0]", "dwell_s": "4.0"}
CASES: dict[tuple[str, str, str], Laid] = {
    ("grid", "linear", "D"): attitudes("grid", "linear"),
    ("grid", "pitch-only", "D"): attitudes("grid", "pitch-only", PITCHES, *X_ALONE),
    ("grid", "pitch-roll", "D"): attitudes("grid", "pitch-roll"),
    ("grid", "pitch-yaw-roll", "D"): attitudes("grid", "pitch-yaw-roll", GIMBAL, YAW),
    ("tumble", "linear", "up-down"): attitudes("tumble", "linear", UP_DOWN),
    ("tumble", "pitch-only", "T"): attitudes("tumble", "pitch-only", 'kind = "T"\n', *X_ALONE),
    ("tumble", "pitch-roll", "up-down"): attitudes("tumble", "pitch-roll", UP_DOWN),
    ("tumble", "pitch-yaw-roll", "up-down"): attitudes("tumble", "pitch-yaw-roll", UP_DOWN, YAW),
    ("profile", "gyro", "harmonic"): motions("rate-table", "harmonic", "gyro"),
    ("profile", "pitch-yaw-roll", "ramp"): motions("rate-table", "ramp", "pitch-yaw-roll", span_deg=WIDE),
    ("profile", "pitch-roll", "ramp"): motions(
        "rate-table", "ramp", "pitch-roll", span_deg="{ pitch = 60.0, roll = 60.0 }"
    ),
    ("rates", "gyro", "table"): motions("rate-table", "rates", "gyro", **SPEEDS),
    ("rates", "linear", "table"): motions("rate-table", "rates", "linear", **SPEEDS),
    ("static", "linear", "rest"): motions("servo-mechanism", "drift", "linear", duration_s="120.0", use_s="20.0"),
    ("two-level", "linear", "coil"): motions("servo-mechanism", "magnetometer", "linear", rest_s="5.0"),
}
"""By kind, model, and how it is laid out."""

LONG = ("profile", "rates")
"""Kinds whose streams are read sample by sample: a few times as long as the others."""


def test_no_kind_and_no_model_is_left_out() -> None:
    offered = {(name, model) for name, kind in KINDS.items() for model in kind.models}
    assert {(kind, model) for kind, model, _ in CASES} == offered


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=[pytest.mark.thorough] if case[0] in LONG else []) for case in CASES],
    ids="-".join,
)
def test_a_run_is_archived_whole_and_the_next_may_take_it_for_its_pilot(
    case: tuple[str, str, str], tmp_path: Path
) -> None:
    laid = CASES[case](tmp_path)
    outcome = laid.run(tmp_path / "run")
    assert outcome.exit_status == 0, outcome.reason
    solved, url = solve_run(tmp_path / "run"), f"sqlite:///{tmp_path / 'archive.sqlite'}"
    assert not solved.failures
    procedure = read_procedure(tmp_path / "procedure.toml")
    foreseen = set(KINDS[case[0]].forecast(laid.rig, procedure, laid.plan).remarks)
    for sensor in solved.sensors.values():
        if sensor.calibration is not None:
            assert foreseen <= {*sensor.calibration.remarks, *sensor.calibration.warnings}, "what a check tells"
    delivery = deliver(solved, url)
    assert not delivery.failures
    is_archived = case[0] != "static"
    assert (delivery.parts["lessons"] == DONE) == is_archived
    assert is_archived or delivery.parts["lessons"].startswith(NOT_DUE)
    shown = shown_in(solved.record, solved.sensors)
    assert bool(shown) == (case[1] != "gyro" and case[0] in ("grid", "tumble", "profile")), "of accelerometers alone"
    if shown:
        assert pilot_of(solved.record, solved.sensors, laid.rig).shown == shown
    else:
        with pytest.raises(RequestError, match="no solved sensor with two replications or more"):
            pilot_of(solved.record, solved.sensors, laid.rig)
    if is_archived:
        (lesson,) = past_lessons(url, laid.rig.rig.name, simulated=True, most=2)
        assert {(part.sensor, part.axis) for part in lesson.components} == set(shown)
