"""A file as a lock, by the kernel's way of this system and by that of Windows."""

from pathlib import Path

import pytest
from without_posix import locking_of_windows

from rig import file_lock
from rig.clock import SystemClock


@pytest.fixture(params=["this system", "Windows"])
def lock(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    if request.param == "Windows":
        monkeypatch.setattr(file_lock, "_FLOCK", None)
        monkeypatch.setattr(file_lock, "_WINDOWS", locking_of_windows())
    path = tmp_path / "a lock"
    path.write_text("who was here before\n", encoding="utf-8")
    return path


def test_one_holds_it_until_it_is_closed_and_what_it_says_can_be_read(lock: Path) -> None:
    clock = SystemClock()
    with open(lock, "a+", encoding="utf-8") as mine, open(lock, encoding="utf-8") as other:
        assert file_lock.take(mine, clock, 1)
        file_lock.say(mine, "I")
        assert file_lock.is_held(other)
        assert not file_lock.take(other, clock, 2)
        assert lock.read_text(encoding="utf-8") == "I"
    with open(lock, encoding="utf-8") as other:
        assert not file_lock.is_held(other)


def test_looking_leaves_it_to_whoever_comes(lock: Path) -> None:
    with open(lock, encoding="utf-8") as looker:
        assert not file_lock.is_held(looker)
    with open(lock, "a+", encoding="utf-8") as mine:
        assert file_lock.take(mine, SystemClock(), 1)
