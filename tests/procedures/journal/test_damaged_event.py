"""An event that is none is named by whoever reads it, as by the verification of the whole journal."""

from pathlib import Path

import apsw
import pytest
from finished_job import FinishedJob

from procedures.errors import JournalError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE


def test_an_event_without_a_moment_is_named(finished_job: FinishedJob, tmp_path: Path) -> None:
    run = finished_job.copied_to(tmp_path)
    connection = apsw.Connection(str(run / JOURNAL_FILE))
    connection.execute("UPDATE events SET utc = 'not a time' WHERE sequence = 9")
    connection.close()
    with JournalReader.open(run) as reader:
        with pytest.raises(JournalError, match=r"event 9 \(.*\) is not as it was written"):
            list(reader.events())
        with pytest.raises(JournalError, match=r"event 9 \(.*\) is not as it was written"):
            reader.verify()
