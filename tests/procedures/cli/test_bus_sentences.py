"""What a user reads when a line fails: the device by its name in the rig file, and the cause."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from command import Outcome, call
from job_files import job
from table_bench import rig_file
from turning_rig import SERVO_FOR_PITCH, STAGE_FOR_ROLL

from rig.assembly.simulate import serve_rig, write_rig
from rig.clock import ScaledClock
from rig.description.fault_plan import FaultPlan, FaultRule
from rig.description.read import read_rig

FACTOR = 20.0
MACHINES = {
    "table": (),
    "servo": (SERVO_FOR_PITCH,),
    "stage": (STAGE_FOR_ROLL,),
    "both": (STAGE_FOR_ROLL, SERVO_FOR_PITCH),
}
ALWAYS: dict[str, Any] = {"every": 1}
CASES = {
    "wrong baud, stage": ("stage", "axes.roll", {"kind": "garble", **ALWAYS}, "check baud rate and parity"),
    "wrong baud, servo": ("servo", "axes.pitch", {"kind": "garble", **ALWAYS}, "check the baud rate"),
    "wrong baud, chamber": ("table", "environment.air", {"kind": "garble", **ALWAYS}, "check baud rate, parity"),
    "echo, table": ("table", "axes.pitch", {"kind": "echo", **ALWAYS}, "the question itself came back: an echo"),
    "echo, servo": ("servo", "axes.pitch", {"kind": "echo", **ALWAYS}, "the question itself came back: an echo"),
    "echo, stage": ("stage", "axes.roll", {"kind": "echo", **ALWAYS}, "the question itself came back: an echo"),
    "echo, chamber": ("table", "environment.air", {"kind": "echo", **ALWAYS}, "the question itself came back: an echo"),
    "damaged": ("stage", "axes.roll", {"kind": "flip-bit", **ALWAYS}, "its checksum is wrong"),
    "no power": ("stage", "axes.roll", {"kind": "power-cycle", "away_s": 1e6, "at_s": 0.0}, "check power"),
    "two cables swapped": (
        "both",
        "axes.pitch",
        {"kind": "swap", "other": "axes.roll", "on": "question", "nth": 1},
        "no two cables changed places",
    ),
    "unplugged while it talks": (
        "table",
        "axes.pitch",
        {"kind": "hang-up", "on": "question", "nth": 1},
        "check cable and adapter",
    ),
}


@contextmanager
def _served(folder: Path, machine: str, rules: dict[str, FaultRule]) -> Iterator[Path]:
    """The rig on pseudo-terminals with stable names, as adapters have."""
    links = folder / "by-id"
    links.mkdir()
    path = rig_file(folder, *MACHINES[machine])
    faults = FaultPlan(fault=rules) if rules else None
    with serve_rig(read_rig(path), ScaledClock(FACTOR), pty=True, links=links, faults=faults) as simulated:
        write_rig(path, simulated.addresses, FACTOR, folder / "ports.toml")
        yield folder / "ports.toml"


LONGER = ("wrong baud, servo", "wrong baud, chamber", "echo, table", "echo, stage", "no power")


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.soak] if case in LONGER else []) for case in CASES]
)
def test_a_failing_line_is_told_by_its_device_and_its_cause(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], case: str
) -> None:
    machine, line, rule, cause = CASES[case]
    with _served(tmp_path, machine, {"it": FaultRule(line=line, **rule)}) as rig:
        outcome = call(capsys, "devices", "--rig", rig)
    assert outcome.status == 1
    _names(outcome, line, cause)
    assert "axes.pitch: " in outcome.out, "the others are asked all the same"


def _names(outcome: Outcome, line: str, cause: str) -> None:
    (sentence,) = [text for text in outcome.err.splitlines() if text.startswith(f"calrig: {line} at ")][:1]
    assert cause in sentence


@pytest.mark.parametrize("command", ["jog", "devices", "run"])
def test_an_unplugged_adapter_and_one_that_came_back_under_another_name_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    procedure, _ = job(tmp_path)
    with _served(tmp_path, "table", {}) as rig:
        (tmp_path / "by-id" / "axes.pitch").rename(tmp_path / "by-id" / "axes.pitch-2")
        options = {
            "jog": ("jog", "--rig", rig, "--axis", "pitch", "--home"),
            "devices": ("devices", "--rig", rig),
            "run": ("run", procedure, "--rig", rig, "--out", tmp_path / "runs"),
        }[command]
        outcome = call(capsys, *options)
    assert outcome.status == 1
    _names(outcome, "axes.pitch", "it is unplugged, or was plugged in again under another name (`calrig devices`")


def test_a_table_that_lost_power_says_that_its_home_is_gone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cut = FaultRule(line="axes.pitch", kind="power-cycle", at_s=120.0, away_s=1.0)
    with _served(tmp_path, "table", {"cut": cut}) as rig:
        clock = ScaledClock(FACTOR)
        begun_s = clock.monotonic_s()
        assert call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--home").status == 0
        clock.sleep(begun_s + 122.0 - clock.monotonic_s())
        outcome = call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--to", 5)
    assert outcome.status == 2
    assert "pitch: the axis is not homed, so its position is not known; nothing moved; home it first" in outcome.err


def test_a_port_that_comes_back_as_another_node_is_found_by_its_stable_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replugged = FaultRule(line="axes.pitch", kind="rename", on="question", nth=(1,), away_s=20.0)
    with _served(tmp_path, "table", {"replugged": replugged}) as rig:
        outcome = call(capsys, "devices", "--rig", rig)
        assert outcome.status == 1
        ScaledClock(FACTOR).sleep(25.0)
        assert call(capsys, "devices", "--rig", rig).status == 0
