"""Laws of the rig lock: one controller, told by name, and nobody blocked by the dead."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rig.errors import RigBusy
from rig.lines.lock import acquire, canonical, owner_of, owners

ROOT = Path(__file__).resolve().parents[3]
HOLD = """
import sys
from pathlib import Path
from rig.lines.lock import acquire
with acquire([sys.argv[2]], "run night.toml", folder=Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


@contextmanager
def _holder(folder: Path, resource: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", HOLD, str(folder), resource]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        try:
            yield process
        finally:
            process.kill()


def test_fault_38_a_second_process_is_refused_and_told_who_holds_it(tmp_path: Path) -> None:
    with _holder(tmp_path, "/dev/null") as process:
        with pytest.raises(
            RigBusy, match=rf"/dev/null: in use by process {process.pid} \(run night.toml\) since .*nothing was opened"
        ):
            acquire(["/dev/null"], "jog", folder=tmp_path)
        owner = owner_of("/dev/null", folder=tmp_path)
        assert owner is not None
        assert (owner.pid, owner.purpose) == (process.pid, "run night.toml")


def test_the_lock_of_a_killed_process_blocks_nobody(tmp_path: Path) -> None:
    with _holder(tmp_path, "/dev/null") as process:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        assert any("night.toml" in path.read_text() for path in tmp_path.glob("*.lock"))  # its text is still there
        assert owners(folder=tmp_path) == []
        acquire(["/dev/null"], "jog", folder=tmp_path).release()


def test_the_same_process_is_a_second_controller_too(tmp_path: Path) -> None:
    port = "socket://bench:4001"
    with acquire([port], "run", folder=tmp_path), pytest.raises(RigBusy, match=f"process {os.getpid()}"):
        acquire([port], "jog", folder=tmp_path)
    acquire(["socket://bench:4001"], "jog", folder=tmp_path).release()


def test_all_or_none_is_taken(tmp_path: Path) -> None:
    with acquire(["b"], "run", folder=tmp_path):
        with pytest.raises(RigBusy):
            acquire(["a", "b", "c"], "jog", folder=tmp_path)
        assert [owner.resource for owner in owners(folder=tmp_path)] == [canonical("b")]


def test_two_names_of_one_port_are_one_lock(tmp_path: Path) -> None:
    link = tmp_path / "by-id"
    link.symlink_to("/dev/null")
    with acquire([str(link)], "run", folder=tmp_path), pytest.raises(RigBusy):
        acquire(["/dev/null"], "jog", folder=tmp_path)
    with acquire(["socket://Bench:4001", "socket://bench:4001"], "run", folder=tmp_path) as lock:
        assert lock.resources == ("socket://bench:4001",)


def test_what_is_held_is_readable_and_ends_with_the_release(tmp_path: Path) -> None:
    lock = acquire(["/dev/null"], "run night.toml", folder=tmp_path)
    (file,) = tmp_path.glob("*.lock")
    assert json.loads(file.read_text())["pid"] == os.getpid()
    lock.release()
    lock.release()
    assert file.read_text() == ""
    assert owner_of("/dev/null", folder=tmp_path) is None
    assert owner_of("never locked", folder=tmp_path) is None


def test_looking_does_not_refuse_a_controller(tmp_path: Path) -> None:
    acquire(["/dev/null"], "run", folder=tmp_path).release()
    for _ in range(50):
        assert owner_of("/dev/null", folder=tmp_path) is None
        acquire(["/dev/null"], "run", folder=tmp_path).release()
