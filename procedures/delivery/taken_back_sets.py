"""Archived sets whose dwells were taken back since: their run's journal says so, and the archive is told.

They are withdrawn, by the name of who took the dwells back: from then on all that is said of a withdrawn set is said of
them. Where an archive was not told, as a second one, or one that did not answer, whoever signs, exports or certifies a
set has its journal asked, as far as it lies where the run was published from or beside the archive.
"""

import shlex
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from sqlalchemy import make_url

from ams.archive.refusals import without_password
from ams.archive.taken_back import (
    SetOfRun,
    later_set_of_run,
    latest_sets_before,
    set_of_run,
    sets_of_run,
    withdraw_for_run,
)
from ams.errors import ArchiveUnknown
from ams.sets.stated_verdict import Withdrawal
from procedures.errors import JournalError, RequestError, StorageFailed
from procedures.journal.audit.taken_back import TakenBack, taken_back_since
from procedures.journal.storage import JOURNAL_FILE


def withdraw_taken_back(archive_url: str, run: Path) -> tuple[SetOfRun, ...]:
    """Withdraw the archived sets of a run whose dwells were taken back after they were made; return these.

    An archive that is not there has none. ``run``: its folder. Raises: ams.errors.ArchiveError, JournalError.
    """
    taken_back = taken_back_since(run)
    if not taken_back:
        return ()
    run_id = next(iter(taken_back.values())).run_id
    try:
        found = sets_of_run(archive_url, run_id)
    except ArchiveUnknown:
        return ()
    gone = [(entry, word) for entry in found if (word := taken_back.get(str(entry.journal_sha256))) is not None]
    for word in dict.fromkeys(word for _, word in gone):
        _withdraw(archive_url, [entry for entry, of in gone if of == word], word)
    return tuple(entry for entry, _ in gone)


def withdraw_previous(archive_url: str, sensors: Iterable[str], run_id: str, *, is_simulated: bool) -> None:
    """Withdraw the latest sets of the sensors, of other runs, whose dwells were taken back since.

    Nothing is found by such a set. Raises: ams.errors.ArchiveError.
    """
    left = tuple(sensors)
    with suppress(ArchiveUnknown):  # no archive is there yet
        while left:
            before = latest_sets_before(archive_url, left, run_id, is_simulated=is_simulated)
            gone = [(entry, word) for entry in before if (word := _word_of(archive_url, entry)) is not None]
            for entry, word in gone:
                _withdraw(archive_url, [entry], word)
            left = tuple(entry.sensor for entry, _ in gone)


def taken_back_of(archive_url: str, key: str) -> str:
    """Return that dwells of a set's run were taken back after it was made: the set, how many, who, when and why.

    Empty where nothing was, where the set is withdrawn already, and where no journal of its run is in reach.
    ``key``: a sensor (its latest set) or the beginning of a checksum. Raises: ams.errors.ArchiveError.
    """
    found = _taken_back(archive_url, key)
    return "" if found is None else _in_words(*found)


def require_standing_dwells(archive_url: str, key: str, spared: str) -> None:
    """Refuse a set whose dwells were taken back after it was made; ``spared``: what was not done.

    Raises: RequestError, ams.errors.ArchiveError.
    """
    found = _taken_back(archive_url, key)
    if found is None:
        return
    entry, _ = found
    run = shlex.quote(str(next(_folders(archive_url, entry), entry.run_id)))
    raise RequestError(
        f"{_in_words(*found)}; it is not for use and {spared}; calrig solve {run} "
        f"--archive {shlex.quote(without_password(archive_url))} withdraws it in the archive, and calrig resume {run} "
        "measures again where the run is not closed"
    )


def require_last_of_run(archive_url: str, key: str) -> None:
    """Refuse to sign a set whose run was published again since. Raises: RequestError, ams.errors.ArchiveError."""
    if (found := later_set_of_run(archive_url, key)) is not None:
        before, after = found
        raise RequestError(
            f"set {before[:12]}: its run was published again since, as set {after[:12]}, which counts; nothing was "
            f"signed; look at both (calrig archive compare {before[:12]} {after[:12]}), sign that one or withdraw it"
        )


def _taken_back(archive_url: str, key: str) -> tuple[SetOfRun, TakenBack] | None:
    """Return a set and what was taken back after it was made; None where nothing was, as far as is in reach."""
    entry = set_of_run(archive_url, key)
    word = None if entry is None else _word_of(archive_url, entry)
    return None if entry is None or word is None else (entry, word)


def _in_words(entry: SetOfRun, word: TakenBack) -> str:
    return f"set {entry.sha256[:12]} of {entry.sensor}: {word}"


def _withdraw(archive_url: str, sets: Iterable[SetOfRun], word: TakenBack) -> None:
    withdraw_for_run(archive_url, [entry.sha256 for entry in sets], Withdrawal(word.by, word.utc, word.because))


def _word_of(archive_url: str, entry: SetOfRun) -> TakenBack | None:
    """Return what the journals in reach say was taken back after a set was made; None where none says it."""
    for folder in _folders(archive_url, entry):
        with suppress(JournalError, StorageFailed, OSError):  # one that cannot be read is told where it is looked at
            found = taken_back_since(folder).get(str(entry.journal_sha256))
            if found is not None:
                return found
    return None


def _folders(archive_url: str, entry: SetOfRun) -> Iterator[Path]:
    """Yield where a journal of the run lies: where it was published from, and beside the file of the archive."""
    database = make_url(archive_url).database if archive_url.startswith("sqlite") else None
    beside = [Path(database).parent / entry.run_id] if database else []
    for folder in dict.fromkeys((*map(Path, entry.folders), *beside)):
        with suppress(OSError):  # another account's, or of another system
            if (folder / JOURNAL_FILE).is_file():
                yield folder
