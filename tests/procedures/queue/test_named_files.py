"""What an item of a queue was added with is what is run: files that its two files name are looked at as these are."""

import sys
from pathlib import Path

import pytest
from named_files_scene import DIALECT, INDEX_ERRORS, MOVE, OTHER_MOVE, POINTS, bench_with_files, replace_text
from queue_scene import ANNA

from procedures.kinds.read import read_procedure
from procedures.queue.adding import add_run
from procedures.queue.state import Item, ItemState, folded
from procedures.queue.store import QueueStore, folder_of_rig
from procedures.queue.world import RigWorld
from rig.clock import SystemClock

PASSES = (sys.executable, "-c", "")
"""In place of ``calrig check``: nothing speaks against it."""
REFUSES = (sys.executable, "-c", "raise SystemExit('another refusal')")


@pytest.fixture
def item(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Item:
    monkeypatch.setattr("procedures.queue.adding.checked", lambda *_: [])
    bench_with_files(tmp_path)
    procedure = read_procedure(tmp_path / "procedure.toml")
    added = add_run(
        tmp_path / "queues", SystemClock(), procedure, tmp_path / "rig.toml", tmp_path / "runs", ANNA,
        not_before="", not_after="",
    )  # fmt: skip
    assert added.state is ItemState.WAITING, added.reasons
    return added


def _world(folder: Path, command: tuple[str, ...] = PASSES) -> RigWorld:
    return RigWorld(folder, SystemClock(), lambda _rig: [], command=command)


@pytest.mark.parametrize(
    ("file", "was", "becomes", "key"),
    [
        (POINTS, "30,90\n", "90,90\n", "procedure file: design.file"),
        (DIALECT, MOVE, OTHER_MOVE, "rig file: axes.pitch.dialect"),
        (INDEX_ERRORS, "0,-1.0,0.2", "0,-2.0,0.2", "rig file: axes.pitch.index_table"),
    ],
)
def test_an_item_whose_named_file_was_changed_since_it_was_added_is_refused_by_its_name(
    item: Item, tmp_path: Path, file: str, was: str, becomes: str, key: str
) -> None:
    assert _world(tmp_path).check(item) == []
    replace_text(tmp_path / file, was, becomes)
    sentence = f"{tmp_path / file} ({key}): was changed since the item was added; add it again"
    assert _world(tmp_path).check(item) == [sentence]
    assert _world(tmp_path, REFUSES).check(item) == [sentence], "what another file is refused for tells nothing of this"
    replace_text(tmp_path / file, becomes, was)
    assert _world(tmp_path).check(item) == []
    (tmp_path / file).unlink()
    (told,) = _world(tmp_path).check(item)
    assert told.startswith(f"{tmp_path / file} ({key}): cannot be read: ")


@pytest.mark.parametrize("file", ["procedure.toml", "rig.toml", POINTS])
def test_a_file_that_is_changed_while_the_item_is_checked_is_refused(item: Item, tmp_path: Path, file: str) -> None:
    changes_it = (sys.executable, "-c", f"open({str(tmp_path / file)!r}, 'a').write('\\n')")
    assert _world(tmp_path, changes_it).check(item) == [
        f"{tmp_path / file}{' (procedure file: design.file)' * (file == POINTS)}: was changed since the item was "
        "added; add it again"
    ]


def test_an_item_of_before_they_were_kept_is_read(item: Item, tmp_path: Path) -> None:
    assert {named.key for named in item.named_files} == {
        "axes.pitch.dialect", "axes.pitch.index_table", "axes.roll.dialect", "design.file",
    }  # fmt: skip
    (added,) = QueueStore(folder_of_rig(tmp_path / "queues", "bench of twins"), SystemClock()).read().events
    del added.detail["named_files"]  # type: ignore[attr-defined]
    (of_before,) = folded([added]).items
    assert of_before.named_files == ()
    replace_text(tmp_path / POINTS, "30,90\n", "90,90\n")
    assert _world(tmp_path).check(of_before) == []
