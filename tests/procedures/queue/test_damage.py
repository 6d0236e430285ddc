"""A queue file that is damaged is one sentence, and is left as it is."""

import shutil
from pathlib import Path

import apsw
import pytest

from procedures.errors import JournalError
from procedures.queue.store import FILE, QueueStore
from rig.clock import SystemClock


def test_a_text_that_is_none_and_a_broken_schema_are_sentences(tmp_path: Path) -> None:
    store = QueueStore(tmp_path, SystemClock())
    store.change(lambda _queue: None)
    path = tmp_path / FILE
    whole = tmp_path / "whole.sqlite"
    connection = apsw.Connection(str(path))
    connection.execute("PRAGMA journal_mode=DELETE")
    connection.close()
    shutil.copyfile(path, whole)
    connection = apsw.Connection(str(path))
    connection.execute("INSERT INTO events VALUES (1, CAST(x'8c' AS TEXT), 'x', '{}', '', '')")
    connection.close()
    with pytest.raises(JournalError, match=r"queue\.sqlite: is damaged \(.*\); nothing was changed; keep the file"):
        store.read()
    path.write_bytes(whole.read_bytes().replace(b"CREATE TABLE", b"CREATE \x8cABLE"))
    for leftover in tmp_path.glob(f"{FILE}-*"):
        leftover.unlink()
    with pytest.raises(JournalError, match=r"queue\.sqlite: (is damaged|cannot be used)"):
        store.read()
