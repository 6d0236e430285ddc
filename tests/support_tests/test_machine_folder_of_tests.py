"""Sessions of tests that run beside each other, and a laboratory's rig on the same machine, share no lock."""

import subprocess
import sys
from pathlib import Path

import pytest
from machine_folder_of_tests import enter_machine_folder, leave_machine_folder

from rig.lines.lock import acquire, lock_folder
from rig.machine_folder import FOLDERS, OVERRIDE

ELSEWHERE = "import sys; from rig.lines.lock import acquire; acquire(sys.argv[1:], 'run').release(); print('got it')"


def test_a_session_keeps_its_locks_from_everybody_elses() -> None:
    assert str(lock_folder().parent) not in {f"{location}/calrig" for location in FOLDERS}


def test_what_one_session_holds_another_may_take(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The rig file that a stored run names is one path for both."""
    rig_file = str(tmp_path / "rig.toml")
    monkeypatch.setenv(OVERRIDE, str(lock_folder().parent))
    with acquire([rig_file], "run"):
        other = enter_machine_folder()
        try:
            command = [sys.executable, "-c", ELSEWHERE, rig_file]
            assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "got it\n"
        finally:
            leave_machine_folder(other)
    assert not other.exists()
