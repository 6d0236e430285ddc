"""Laws of the locks where the machine folder takes no file: nothing is held unseen, but for a stop."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from full_machine_folder import MOUNTED, WAYS, MachineFolder, machine_folder_that_fills

from rig.errors import RigBusy
from rig.lines.lock import acquire, leave_use, owner_of, require_marks, uses

RESOURCE, NEVER_LOCKED = "/dev/null", "/dev/zero"


@pytest.fixture(params=WAYS)
def machine(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MachineFolder]:
    with machine_folder_that_fills(tmp_path, monkeypatch, request.param) as folder:
        yield folder


@pytest.mark.parametrize("resource", [RESOURCE, NEVER_LOCKED])
def test_fault_79_a_rig_is_not_taken_whose_use_would_leave_no_mark(machine: MachineFolder, resource: str) -> None:
    """Told are the folder, what it has free and what to do; the mark before it stays."""
    acquire([RESOURCE], "run night.toml").release()
    before = machine.marks()
    machine.fill()
    with pytest.raises(
        RigBusy,
        match=rf"{machine.path}/locks: takes no file: No space left on device \(\d+ bytes and \d+ files free\): .*"
        r"nothing was opened; make room there \(df, df -i\)",
    ):
        acquire([resource], "jog")
    with pytest.raises(RigBusy, match="takes no file"):
        require_marks()
    assert owner_of(resource) is None, "a lock was kept"
    assert (machine.marks(), machine.left_over()) == (before, [])
    machine.free()
    require_marks()
    acquire([resource], "jog").release()


@pytest.mark.parametrize("resource", [RESOURCE, NEVER_LOCKED])
def test_fault_79_a_stop_goes_through_and_destroys_no_mark(machine: MachineFolder, resource: str) -> None:
    acquire([RESOURCE], "run night.toml").release()
    before = machine.marks()
    machine.fill()
    with acquire([resource], "jog", for_stop=True):
        left = leave_use([resource], "jog --stop")
    assert [owner.purpose for owner in left.owners] == ["jog --stop"]
    assert "No space left on device" in left.unmarked
    assert (machine.marks(), machine.left_over()) == (before, [])
    assert [owner.purpose for owner in uses([RESOURCE])] == ["run night.toml"]


def test_a_stop_too_is_refused_while_another_has_the_rig(machine: MachineFolder) -> None:
    with acquire([RESOURCE], "run"):
        machine.fill()
        with pytest.raises(RigBusy, match="in use by"):
            acquire([RESOURCE], "jog", for_stop=True)


def test_fault_79_a_folder_that_takes_no_name_any_more_is_full_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every account may fill it with empty files as well."""
    with machine_folder_that_fills(tmp_path, monkeypatch, MOUNTED, size="64k,nr_inodes=12") as machine:
        acquire([RESOURCE], "run").release()
        machine.fill_with_names()
        with pytest.raises(RigBusy, match="takes no file: No space left on device"):
            acquire([NEVER_LOCKED], "jog")
        with acquire([NEVER_LOCKED], "jog", for_stop=True):
            pass


def test_a_mark_that_says_nothing_is_a_use_that_cannot_be_seen(tmp_path: Path) -> None:
    acquire([RESOURCE], "run", folder=tmp_path).release()
    (mark,) = tmp_path.glob("*.used")
    mark.write_text("")
    with pytest.raises(RigBusy, match="does not say who used the rig"):
        uses([RESOURCE], folder=tmp_path)
