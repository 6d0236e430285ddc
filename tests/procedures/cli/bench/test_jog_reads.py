"""What a look at the bench tells: nothing that nobody knows, and what it leaves out."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from command import call
from instrument_rigs import daq_and_f4t_rig_file
from table_bench import rig_file
from turning_rig import SERVO_FOR_PITCH, served

from procedures.plan.plan import Plan
from procedures.run.watch.safe_state import make_safe
from rig.assembly.open_rig import open_rig
from rig.clock import ScaledClock
from rig.description.read import read_rig

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
