"""Files are complete or as they were."""

import fcntl
import os
import signal
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO

import pytest
from small_run import in_child
from solved import provenance, solved_package

from ams.errors import SetError, WriteFailed
from ams.exports.formats import export_set
from ams.sets.coefficients import build_set
from ams.whole_file import replace_file, whole_file, write_whole


def test_a_file_is_replaced_whole_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    write_whole(path, b"first")
    write_whole(path, b"second")
    assert path.read_bytes() == b"second"
    assert os.listdir(tmp_path) == ["set.json"]


@pytest.mark.skipif(sys.platform == "win32", reason="nobody is killed so, and no lock tells the dead from the living")
@pytest.mark.parametrize("content", [b"", b"<svg>" * 10_000])
def test_what_a_killed_writer_left_is_gone_when_the_file_is_written_again(tmp_path: Path, content: bytes) -> None:
    """And nothing else: what a living one writes, and what is another file's, stays."""
    path = tmp_path / "residuals.svg"

    def work() -> None:
        with whole_file(path) as file:
            file.write(content)
            file.flush()
            os.kill(os.getpid(), signal.SIGKILL)

    os.waitpid(in_child(work), 0)
    (left,) = os.listdir(tmp_path)
    assert left.startswith(".residuals.svg.")
    assert list(tmp_path.glob("*.svg")) == []
    others = [
        ".residuals.svg.0123abcd.partial.kept",
        ".xresiduals.svg.0123abcd.partial",
        ".another.svg.0123abcd.partial",
    ]
    for name in others:
        (tmp_path / name).touch()
    with whole_file(path) as living:
        living.write(b"living")
        write_whole(path, b"again")
        assert path.read_bytes() == b"again"
    assert path.read_bytes() == b"living"
    assert sorted(os.listdir(tmp_path)) == sorted([*others, path.name])


@pytest.mark.skipif(sys.platform == "win32", reason="no lock tells the dead from the living there")
def test_one_that_is_taken_for_dead_before_it_is_held_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, taken = fcntl.flock, []

    def late(file: IO[bytes], kind: int) -> None:
        if not taken:
            taken.append(os.listdir(tmp_path)[0])
            (tmp_path / taken[0]).unlink()
        real(file, kind)

    monkeypatch.setattr(fcntl, "flock", late)
    write_whole(tmp_path / "set.json", b"content")
    assert (tmp_path / "set.json").read_bytes() == b"content"
    assert os.listdir(tmp_path) == ["set.json"]


@pytest.mark.parametrize(("is_synced", "expected"), [(True, ["fsync", "replace", "fsync"]), (False, ["replace"])])
def test_the_content_is_synced_before_it_gets_its_name_and_the_folder_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_synced: bool, expected: list[str]
) -> None:
    """Unless nothing of it is worth a wait for the disk: then it is as whole, and not synced."""
    calls: list[str] = []
    for name in ("fsync", "replace"):
        real = getattr(os, name)

        def recorded(*arguments: object, name: str = name, real: Callable[..., object] = real) -> object:
            calls.append(name)
            return real(*arguments)

        monkeypatch.setattr(os, name, recorded)
    replace_file(tmp_path / "set.json", b"content", is_synced=is_synced)
    assert calls == expected


def test_a_refused_write_leaves_the_target_and_the_folder_as_they_were(tmp_path: Path) -> None:
    target = tmp_path / "set.json"
    (target / "inside").mkdir(parents=True)
    with pytest.raises(WriteFailed, match=r"set\.json: cannot be written: Is a directory; nothing was changed there"):
        write_whole(target, b"content")
    assert os.listdir(tmp_path) == ["set.json"]


def test_a_full_disk_leaves_the_target_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "set.json"
    write_whole(path, b"first")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(WriteFailed, match="No space left on device"):
        write_whole(path, b"second")
    assert path.read_bytes() == b"first"
    assert os.listdir(tmp_path) == ["set.json"]


def test_a_folder_that_cannot_be_synced_is_told_as_what_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The new content is there: a message that nothing was changed would be false."""
    path, real = tmp_path / "set.json", os.fsync
    write_whole(path, b"first")

    def full_for_folders(descriptor: int) -> None:
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(5, "Input/output error")
        real(descriptor)

    monkeypatch.setattr(os, "fsync", full_for_folders)
    with pytest.raises(WriteFailed, match=r"set\.json: was written, but its folder could not be synced: Input/output"):
        write_whole(path, b"second")
    assert path.read_bytes() == b"second"
    assert os.listdir(tmp_path) == ["set.json"]


def test_a_missing_folder_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(WriteFailed, match=r"cannot be written: No such file or directory; .*check the folder"):
        write_whole(tmp_path / "none" / "set.json", b"content")


def test_an_unknown_format_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    with pytest.raises(SetError, match="SN1047: export: unknown format: got 'xls', allowed are c, c-fixed, csv"):
        export_set(build_set(solved_package(), provenance()), "xls", tmp_path / "set.xls")
    assert os.listdir(tmp_path) == []


def test_a_name_of_another_format_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    with pytest.raises(SetError, match=r"set\.mat: export: the name does not end as the format's files do"):
        export_set(build_set(solved_package(), provenance()), "json", tmp_path / "set.mat")
    assert os.listdir(tmp_path) == []


def test_nobody_else_puts_a_file_into_place() -> None:
    root = Path(__file__).parents[2]
    sources = [path for package in ("ams", "rig", "procedures") for path in (root / package).rglob("*.py")]
    assert {path.relative_to(root).as_posix() for path in sources if "os.replace(" in path.read_text("utf-8")} == {
        "ams/whole_file.py",
        "rig/guard/process.py",  # runs without what is installed
        "rig/machine_room.py",  # marks that other accounts read; rig knows nothing of ams
        "procedures/cli/run/detach.py",  # a log that a child has open gets its name
    }
