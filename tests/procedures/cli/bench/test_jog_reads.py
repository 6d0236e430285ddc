"""What a look at the bench tells: nothing that nobody knows, and what it leaves out."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from command import call
from instrument_rigs import daq_and_f4t_rig_file
from table_bench import rig_file
from turning_rig import SERVO_FOR_PITCH, served

from procedures.errors import ExitStatus
from procedures.plan.plan import Plan
from procedures.run.watch.safe_state import make_safe
from rig.assembly.open_rig import open_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig
from rig.errors import DeviceSilent

NOT_KNOWN = "no pulse is sent, position not known"


def test_a_servo_without_a_pulse_stands_nowhere_that_is_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with served(tmp_path, ScaledClock(30.0), SERVO_FOR_PITCH) as (_, rig):
        seen = call(capsys, "jog", "--rig", rig, "--read", "--json", "--samples", 2).document
        assert (seen["positions_deg"]["pitch"], seen["positions_unknown"]) == (None, {"pitch": NOT_KNOWN})
        assert f"pitch: {NOT_KNOWN}" in call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--stop").out
        call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--home")
        assert (
            "positions_unknown" not in call(capsys, "jog", "--rig", rig, "--axis", "pitch", "--stop", "--json").document
        )


def test_the_safe_state_tells_no_position_of_a_servo_without_a_pulse(tmp_path: Path) -> None:
    with open_rig(read_rig(rig_file(tmp_path, SERVO_FOR_PITCH))) as rig:
        safe = make_safe(rig, cast("Plan", SimpleNamespace(steps=())), is_over=False)
    assert safe.detail()["unknown"] == {"pitch": NOT_KNOWN}
    assert set(safe.positions_deg) == {"roll"}
    assert safe.in_words == (
        f"Every other axis was told to stop and seen to stand: roll at 0.0000°; pitch: {NOT_KNOWN}; the run moved "
        "nothing since."
    )


def test_the_chamber_is_read_and_a_stream_that_is_not_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = call(capsys, "jog", "--rig", daq_and_f4t_rig_file(tmp_path), "--read", "--json", "--samples", 2)
    assert list(seen.document["temperatures_degc"]) == ["air"]
    assert "streams.imu: not read here (" in seen.err


def _silent(*_: object) -> float:
    raise DeviceSilent("air: no complete reply; see its power and its cable")


def test_a_chamber_that_is_off_is_named_and_keeps_nothing_else_from_being_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rig.devices.watlow_f4.WatlowF4.temperature_degc", _silent)
    rig = rig_file(tmp_path)
    seen = call(capsys, "jog", "--rig", rig, "--read", "--json", "--samples", 2)
    assert seen.status == ExitStatus.FAILED
    assert seen.document["temperatures_degc"] == {"air": None}
    assert set(seen.document["positions_deg"]) == {"pitch", "roll"}
    assert seen.document["readings"]
    assert "air: not read: air: no complete reply" in seen.err
    assert "air              does not answer" in call(capsys, "jog", "--rig", rig, "--read", "--samples", 2).out


@pytest.mark.parametrize("how", [("--json",), ()])
def test_a_stop_is_told_though_what_was_to_be_read_behind_it_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, how: tuple[str, ...]
) -> None:
    monkeypatch.setattr("procedures.cli.bench.jog.readings", _silent)
    seen = call(capsys, "jog", "--rig", rig_file(tmp_path), "--stop", "--read", *how)
    assert seen.status == ExitStatus.FAILED
    assert "no complete reply" in seen.err
    if how:
        assert seen.document["stopped"] == ["pitch", "roll"]
    else:
        assert "roll: stands still at " in seen.out


def test_a_stop_with_all_that_is_read_behind_it_is_one_document(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = rig_file(tmp_path)
    document = call(capsys, "jog", "--rig", rig, "--stop", "--read", "--json", "--samples", 2).document
    assert document["stopped"] == ["pitch", "roll"]
    assert document["readings"]
    out = call(capsys, "jog", "--rig", rig, "--stop", "--read", "--samples", 2).out
    assert out.count("roll: stands still at ") == 1
