"""Crash points: off in normal use, refused where anything is real, and a kill exactly where a test wants it."""

import os
import signal
from pathlib import Path

import pytest
from example_files import EXAMPLE_RIG
from small_run import in_child

from rig.assembly.open_rig import open_rig
from rig.crash_points import VARIABLE, CrashPoint, crash_point
from rig.description.read import read_rig
from rig.errors import RequestRefused


def test_without_the_variable_nothing_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    for point in CrashPoint:
        crash_point(point)


def test_fault_72p_a_rig_with_a_real_port_is_refused_before_anything_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One device on a real port beside twins: the port does not exist, and is not even looked for."""
    text = EXAMPLE_RIG.read_text(encoding="utf-8").replace('port = "twin"', 'port = "/dev/serial/by-id/none"', 1)
    rig_file = tmp_path / "rig.toml"
    rig_file.write_text(text.replace('time = "virtual"', 'time = "real"'), encoding="utf-8")
    monkeypatch.setenv(VARIABLE, "after-commit:3")
    with pytest.raises(RequestRefused) as refused:
        open_rig(read_rig(rig_file))
    assert str(refused.value) == (
        "/dev/serial/by-id/none: CALRIG_CRASH_POINT is set to 'after-commit:3': it kills the program in the middle of "
        "its work, and is allowed only where every device is a twin; nothing was opened; unset it"
    )


@pytest.mark.parametrize(("wanted", "survived"), [("moved:1", 3), ("move-sent:3", 2), ("any:1", 0), ("any:3", 2)])
def test_the_process_dies_at_the_passage_that_was_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, wanted: str, survived: int
) -> None:
    monkeypatch.setenv(VARIABLE, wanted)
    passed = tmp_path / "passed"

    def work() -> None:
        for number in range(1, 4):
            crash_point(CrashPoint.MOVE_SENT)
            passed.write_text(str(number))

    _, status = os.waitpid(in_child(work), 0)
    assert (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL) is (survived < 3)
    assert (int(passed.read_text()) if passed.exists() else 0) == survived
