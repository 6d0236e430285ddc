"""Where the journal of an archived run lies."""

from pathlib import Path

from ams.archive.runs import list_runs
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.taken_away import require_not_taken_away


def archived_run(run_id: str, archive_url: str) -> Path:
    """Return the folder that a run was published from.

    Raises: RequestError where the archive has no such run, or its journal is not there any more or is another one;
    ams.errors.ArchiveError; JournalError.
    """
    entries = [entry for entry in list_runs(archive_url) if entry.run_id == run_id]
    if not entries:
        raise RequestError(f"{run_id}: the archive has no such run; nothing was read; calrig archive list names them")
    folder = Path(entries[-1].folder)
    require_not_taken_away(folder)
    if not (folder / JOURNAL_FILE).exists():
        raise RequestError(
            f"{run_id}: its journal is no longer in {folder}; nothing was read; give the folder that it was moved to"
        )
    with JournalReader.open(folder) as reader:
        contents = reader.contents()
    if not {entry.journal_sha256 for entry in entries} & set(contents):
        raise RequestError(
            f"{run_id}: the journal in {folder} is not the one that was archived; nothing was read; give the folder of "
            "the run that is meant"
        )
    return folder
