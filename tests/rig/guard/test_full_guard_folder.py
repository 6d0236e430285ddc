"""Laws of a stop guard that nobody would find: nothing moves by it, and a stop needs none."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from full_machine_folder import MOUNTED, SIZE, MachineFolder, machine_folder_that_fills
from small_disk import small_disk
from turning_rig import STAGE_FOR_ROLL, served

from procedures.cli.main import run_command
from rig.assembly.open_rig import open_rig
from rig.clock import SystemClock
from rig.description.read import read_rig
from rig.errors import GuardLost, RigBusy
from rig.guard.ask import of_rig
from rig.machine_folder import OVERRIDE
from rig.motion.move import home_and_arrive

CLOCK = SystemClock()


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MachineFolder]:
    with machine_folder_that_fills(tmp_path, monkeypatch, MOUNTED) as folder:
        yield folder


def test_fault_79_a_rig_is_not_opened_for_motion_where_its_guard_could_not_be_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the locks lie there is room."""
    (tmp_path / "calrig").mkdir()
    monkeypatch.setenv(OVERRIDE, str(tmp_path / "calrig"))
    with (
        small_disk(tmp_path / "calrig" / "guards", SIZE) as disk,
        served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (simulated, rig_file),
    ):
        disk.fill()
        with pytest.raises(RigBusy, match="takes no file: No space left on device"):
            open_rig(read_rig(rig_file), rig_file=rig_file)
        with open_rig(read_rig(rig_file), rig_file=rig_file, for_stop=True) as rig:
            rig.axes["roll"].stop()
        assert simulated.world.axes["roll"].rate_dps(CLOCK.monotonic_s()) == 0.0


def test_fault_79_nothing_begins_to_move_once_its_guard_could_not_be_found(
    tmp_path: Path, machine: MachineFolder
) -> None:
    """The disk was full after the rig was opened and before the first motion; when it has room, the next one begins."""
    with (
        served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file),
        open_rig(read_rig(rig_file), rig_file=rig_file) as rig,
    ):
        roll = rig.axes["roll"]
        machine.fill()
        with pytest.raises(GuardLost, match=r"would not find it; nothing was moved; make room there"):
            home_and_arrive(roll, rig.clock, rig.clock.sleep)
        assert not roll.state().is_homed
        assert of_rig(str(rig_file)) == []
        machine.free()
        home_and_arrive(roll, rig.clock, rig.clock.sleep)
        (guard,) = of_rig(str(rig_file))
        assert int(guard["pid"]) == os.getpid()


def test_fault_79_a_stop_by_hand_is_obeyed_while_the_folder_is_full_and_says_who_was_not_told(
    tmp_path: Path, machine: MachineFolder, capsys: pytest.CaptureFixture[str]
) -> None:
    with served(tmp_path, CLOCK, STAGE_FOR_ROLL) as (_, rig_file):
        with open_rig(read_rig(rig_file), rig_file=rig_file):
            pass
        machine.fill()
        assert run_command(["jog", "--rig", str(rig_file), "--axis", "roll", "--home"]) != 0
        refused = capsys.readouterr().err
        assert "takes no file: No space left on device" in refused
        assert "nothing was opened" in refused
        assert run_command(["jog", "--rig", str(rig_file), "--stop"]) == 0
        told = capsys.readouterr()
        assert "roll: stands still at" in told.out
        assert "no queue of another account is told of this" in told.err
