"""What stands in the place of a run's files and is none of them: a link is not followed, a pipe is not waited for."""

import os
from pathlib import Path

import pytest

from procedures.errors import JournalError, RequestError, StorageFailed
from procedures.journal.sidecar.owner import OWNER_FILE, is_owned, owned_since, owning
from procedures.journal.storage import JOURNAL_FILE, CommittedCount, require_journal_file

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")


def test_a_lock_that_is_a_link_leaves_its_target_as_it_is(tmp_path: Path) -> None:
    target = tmp_path / "precious"
    target.write_text("precious")
    (tmp_path / OWNER_FILE).symlink_to(target)
    with pytest.raises(RequestError, match=r"owner\.lock: is no plain file"), owning(tmp_path):
        pass
    assert target.read_text() == "precious"


@pytest.mark.timeout(20)
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    for name in (OWNER_FILE, JOURNAL_FILE):
        os.mkfifo(tmp_path / name)
    with pytest.raises(RequestError, match=r"owner\.lock: is no plain file"), owning(tmp_path):
        pass
    with pytest.raises(RequestError, match=r"owner\.lock: is no plain file"):
        is_owned(tmp_path)
    assert owned_since(tmp_path) is None
    with pytest.raises(JournalError, match=r"journal\.sqlite: is no plain file"):
        require_journal_file(tmp_path / JOURNAL_FILE)
    count = CommittedCount(tmp_path / JOURNAL_FILE)
    os.mkfifo(count.path)
    with pytest.raises(JournalError, match=r"journal\.count: is no plain file"):
        count.read()
    with pytest.raises(StorageFailed, match=r"journal\.count: cannot be written"):
        count.write("run", 1, 1)
