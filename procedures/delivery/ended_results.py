"""After dwells of a finished run were taken back: its files are moved aside, its sets withdrawn in its archive."""

import shlex
from dataclasses import dataclass
from pathlib import Path

from ams.archive.refusals import without_password
from ams.errors import ArchiveError, WriteFailed
from procedures.delivery.set_aside import set_results_aside
from procedures.delivery.taken_back_sets import withdraw_taken_back
from procedures.journal.journal_reader import JournalReader


@dataclass(frozen=True)
class EndedResults:
    """What became of the results of before, a sentence each."""

    done: tuple[str, ...] = ()
    remains: tuple[str, ...] = ()
    """What could not be done, and how it is."""


def archive_kept_by(run: Path, otherwise: str) -> str:
    """Return the archive that a run keeps; of a simulated one that keeps none the one beside it; else ``otherwise``.

    One that is kept without its password is ``otherwise`` where that is the same one. Raises: JournalError.
    """
    with JournalReader.open(run) as reader:
        opened, is_simulated = reader.last_event("opened"), reader.header.is_simulated
    kept = "" if opened is None else str(opened.detail.get("archive") or "")
    if kept:
        return otherwise if without_password(otherwise) == kept else kept
    return f"sqlite:///{run.parent / 'archive.sqlite'}" if is_simulated else otherwise


def end_results(run: Path, archive_url: str) -> EndedResults:
    """End what rests on dwells that were taken back; the journal has told it already, so nothing is raised for a file
    or an archive that refuses. ``archive_url``: of the run.

    Raises: JournalError.
    """
    done: list[str] = []
    remains: list[str] = []
    again = f"calrig solve {shlex.quote(str(run))}"
    try:
        done += [sentence] if (sentence := set_results_aside(run)) else []
    except (OSError, WriteFailed) as error:
        remains.append(
            f"{error}; the sets, exports and report of before are where they were: do not use them; {again} moves them "
            "aside when the folder can be written"
        )
    shown = without_password(archive_url)
    try:
        gone = withdraw_taken_back(archive_url, run)
    except ArchiveError as error:
        remains.append(
            f"{error}; the sets of this run still stand in the archive {shown}: when it answers, {again} withdraws "
            "them there; until then do not use them"
        )
        return EndedResults(tuple(done), tuple(remains))
    if gone:
        named = ", ".join(f"{entry.sha256[:12]} of {entry.sensor}" for entry in gone)
        done.append(
            f"withdrawn in the archive {shown}: {'set' if len(gone) == 1 else 'sets'} {named}; not to be used any more"
        )
    return EndedResults(tuple(done), tuple(remains))
