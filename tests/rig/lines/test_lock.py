"""Laws of the rig lock: one controller, told by name, and nobody blocked by the dead."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from psutil import net_if_addrs

from rig.errors import RigBusy
from rig.lines.lock import (
    account,
    acquire,
    address_of,
    canonical,
    identity_of,
    lock_folder,
    owner_of,
    serial_of,
)

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
        assert any("night.toml" in path.read_text() for path in tmp_path.glob("*.owner"))  # its text is still there
        assert owner_of("/dev/null", folder=tmp_path) is None
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
        held = [owner_of(resource, folder=tmp_path) for resource in ("a", "b", "c")]
        assert [owner.resource if owner else None for owner in held] == [None, canonical("b"), None]


def test_two_names_of_one_port_are_one_lock(tmp_path: Path) -> None:
    link = tmp_path / "by-id"
    link.symlink_to("/dev/null")
    with acquire([str(link)], "run", folder=tmp_path), pytest.raises(RigBusy):
        acquire(["/dev/null"], "jog", folder=tmp_path)
    with acquire(["socket://Bench:4001", "socket://bench:4001"], "run", folder=tmp_path) as lock:
        assert lock.resources == ("socket://bench:4001",)


def test_what_is_held_is_readable_and_ends_with_the_release(tmp_path: Path) -> None:
    lock = acquire(["/dev/null"], "run night.toml", folder=tmp_path)
    (file,) = tmp_path.glob("*.owner")
    assert json.loads(file.read_text())["pid"] == os.getpid()
    lock.release()
    lock.release()
    assert not file.exists()
    assert owner_of("/dev/null", folder=tmp_path) is None
    assert owner_of("never locked", folder=tmp_path) is None


def test_looking_does_not_refuse_a_controller(tmp_path: Path) -> None:
    acquire(["/dev/null"], "run", folder=tmp_path).release()
    for _ in range(50):
        assert owner_of("/dev/null", folder=tmp_path) is None
        acquire(["/dev/null"], "run", folder=tmp_path).release()


SAME = [
    ("socket://localhost:4001", "socket://127.0.0.1:4001"),
    ("socket://[::1]:4001", "socket://127.0.0.1:4001"),
    ("socket://LOCALHOST:4001", "rfc2217://127.0.0.1:4001"),
    ("socket://127.0.0.1:4001/", "socket://127.0.0.2:4001"),
    ("socket://127.0.0.1:4001", "socket://[::ffff:127.0.0.1]:4001"),
    ("socket://192.0.2.7:4001", "socket://[::ffff:192.0.2.7]:4001"),
    ("socket://192.0.2.7:4001", "socket://[::ffff:c000:207]:4001"),
]


@pytest.mark.parametrize(("entry", "other"), SAME)
def test_fault_38_two_names_of_one_address_are_one_lock(tmp_path: Path, entry: str, other: str) -> None:
    with (
        acquire([entry], "run", folder=tmp_path),
        pytest.raises(RigBusy, match=rf"in use by process {os.getpid()} \(run\) since"),
    ):
        acquire([other], "jog", folder=tmp_path)


def test_fault_38_an_address_of_this_machine_s_own_is_this_machine() -> None:
    """Whoever reaches a device at localhost reaches it at every address that this machine has."""
    own = {
        address.address
        for addresses in net_if_addrs().values()
        for address in addresses
        if address.family in (socket.AF_INET, socket.AF_INET6) and "%" not in address.address
    }
    assert {address_of(address) for address in own} == {address_of("localhost")}
    assert address_of("192.0.2.7") == "192.0.2.7"


def test_fault_38_a_board_is_one_wherever_the_command_was_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    locks = tmp_path / "locks"
    locks.mkdir()
    for folder in ("anna", "bert"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path / "anna")
    with acquire(["GPIB0"], "run", folder=locks):
        monkeypatch.chdir(tmp_path / "bert")
        for name in ("GPIB0", "gpib0", "GPIB"):
            with pytest.raises(RigBusy, match="GPIB0: in use by process"):
                acquire([name], "jog", folder=locks)
        acquire(["GPIB1"], "jog", folder=locks).release()


def test_other_ports_and_other_hosts_are_others(tmp_path: Path) -> None:
    ports = ["socket://127.0.0.1:4001", "socket://127.0.0.1:4002", "socket://192.0.2.7:4001"]
    with acquire(ports, "run", folder=tmp_path) as lock:
        assert len(list(tmp_path.glob("*.lock"))) == len(lock.resources) == 3


@pytest.mark.parametrize("other", ["socket://127.0.0.1:04001", "rfc2217://lab@localhost:4001", "socket://[::1]:4001/"])
def test_a_port_in_another_spelling_is_one_lock(tmp_path: Path, other: str) -> None:
    with (
        acquire(["socket://127.0.0.1:4001"], "run", folder=tmp_path),
        pytest.raises(RigBusy, match="in use by process"),
    ):
        acquire([other], "jog", folder=tmp_path)


def test_two_nodes_of_one_device_are_one_lock(tmp_path: Path) -> None:
    """By the device's numbers, so that a second node made by hand is no way around."""
    assert identity_of("/dev/null") == "character device 1 3"
    link = tmp_path / "by-path"
    link.symlink_to("/dev/null")
    assert identity_of(str(link)) == identity_of("/dev/null")


def test_a_device_is_known_by_its_serial_number() -> None:
    assert serial_of("Zaber device 50921, serial 12345, firmware 7.38, number 1") == (
        "device Zaber device 50921, serial 12345"
    )
    assert serial_of("VN-100, serial number: 0100012345, firmware 3") == "device VN-100, serial number: 0100012345"
    for silent in ("HP3458A", "Oriental AZ, unit 2, current 100 %", "serial 0000", "a serial adapter"):
        assert serial_of(silent) is None


def test_another_runtime_folder_is_no_other_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("CALRIG_MACHINE_FOLDER", raising=False)
    before = lock_folder()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    assert lock_folder() == before


def test_all_accounts_may_lock_and_none_may_remove_what_another_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("CALRIG_MACHINE_FOLDER", str(tmp_path / "calrig"))
    assert lock_folder().stat().st_mode & 0o7777 == 0o1777
    with acquire(["socket://127.0.0.1:1"], "run"):
        modes = {path.suffix: path.stat().st_mode & 0o777 for path in lock_folder().iterdir()}
    assert modes == {".lock": 0o644, ".owner": 0o644, ".used": 0o644}


AS_NOBODY = """
import encodings.idna  # from a folder that the other account may not be able to read
import os
from rig.errors import RigBusy
from rig.lines.lock import acquire
os.setgid(65534)
os.setuid(65534)
try:
    acquire(["socket://localhost:4001"], "jog").release()
    print("got it")
except RigBusy as error:
    print(error)
"""


@pytest.mark.skipif(os.getuid() != 0, reason="needs two accounts")
def test_fault_38_another_account_is_refused_and_told_who() -> None:
    """And gets the rig when it is free, through the very files that this account made."""

    def told() -> str:
        command = [sys.executable, "-c", AS_NOBODY]
        return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True).stdout

    with acquire(["socket://127.0.0.1:4001"], "run night.toml"):
        assert f"in use by process {os.getpid()} (run night.toml) of {account()} since" in told()
    assert told() == "got it\n"
    acquire(["socket://127.0.0.1:4001"], "run").release()
