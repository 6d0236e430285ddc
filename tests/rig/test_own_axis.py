"""An axis that is no part of the package keeps what the package's own promise (examples/own_axis)."""

from importlib import import_module
from pathlib import Path

import pytest
from command import call
from own_axis_rig import own_axis_rig

from rig.errors import DeviceNonsense
from rig.testing import DAMAGES, LINES, MISTAKEN, keep_promises, rig_on, survive_damage


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return own_axis_rig(tmp_path, monkeypatch)


@pytest.mark.parametrize("line", LINES)
def test_it_keeps_the_laws_of_axes(path: Path, line: str) -> None:
    with rig_on(line, path) as rig:
        keep_promises(rig, "axes.pitch")
        keep_promises(rig, "axes.roll")
    assert [file.name for file in path.parent.iterdir()] == ["rig.toml"], "nothing is written beside the user's file"


def test_no_damage_to_its_line_makes_a_wrong_number(path: Path) -> None:
    every = DAMAGES | MISTAKEN
    survive_damage(path, "axes.roll", lambda rig: rig.axes["roll"].state().position_deg, 1e-9, damages=every)


@pytest.mark.usefixtures("path")
def test_its_frames_are_those_of_its_manual() -> None:
    codec = import_module("stage_axis.codec")
    assert codec.question(1, 2, codec.GO, -90_000).hex() == "010267fffea07077"
    assert codec.read_answer("pitch", 1, 2, bytes.fromhex("010200fffea07010")) == -90_000
    for wrong in ("010200fffea07011", "020200fffea07011", "010200fffea070"):
        with pytest.raises(DeviceNonsense):
            codec.read_answer("pitch", 1, 2, bytes.fromhex(wrong))


def test_the_command_knows_it(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = call(capsys, "devices", "--rig", path)
    assert outcome.status == 0
    assert "axes.roll: TURN-2 serial 31007, motor 2" in outcome.out
    assert "nothing stops it" not in outcome.out
