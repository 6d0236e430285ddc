"""The runs of a folder by state: one list for a command that is given no RUN, for ``calrig status --all`` and screens.

Journals are only read, each in short transactions, and read again only when they have changed. What cannot be read is
an entry that says so: one damaged journal hides no other run. A list that shows counts to people verifies what they are
counted by; one that only chooses a run does not, since the command then verifies that run itself.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import Any

from procedures.errors import ExitStatus, JournalTakenAway, ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.status.standing import RunStatus, derived_state
from procedures.journal.status.verified_so_far import VerifiedSoFar
from procedures.journal.storage import JOURNAL_FILE, CommittedCount
from procedures.journal.taken_away import is_taken_away, require_not_taken_away
from procedures.journal.time_stamps import SETTLED_NS
from procedures.records.states import State
from rig.clock import Clock, SystemClock

Fingerprint = tuple[tuple[int, int, int] | None, ...]
"""Inode, time of change in ns and size of each file that a commit writes to; None for one that is not there."""


@dataclass(frozen=True, slots=True)
class ListedRun:
    """One run of a folder, as its journal and its lock tell it."""

    path: Path
    """Its folder."""
    title: str
    """Empty where the journal cannot be read."""
    state: State | None
    """None where the journal cannot be read."""
    started_utc: datetime | None
    dwells_done: int
    """Accepted design dwells."""
    dwells_planned: int
    is_alive: bool
    """A living process runs it."""
    modified_utc: datetime
    """When its journal was last written to."""
    trouble: str = ""
    """Why the journal cannot be read."""
    damaged: tuple[str, ...] = ()
    """Events and dwells that are not as they were written, by name; empty where the list does not verify."""
    exit_status: ExitStatus = ExitStatus.DONE
    """What ``calrig status`` of it ends with: of a journal that cannot be read, that of the refusal."""
    status: RunStatus | None = None
    """Where it stands; None where the list does not verify, or nobody can tell."""

    def to_document(self) -> dict[str, Any]:
        """Return the entry as it stands in ``calrig status --all --json``."""
        return {
            "run": str(self.path),
            "title": self.title,
            "state": None if self.state is None else str(self.state),
            "started_utc": None if self.started_utc is None else self.started_utc.isoformat(timespec="seconds"),
            "dwells_done": self.dwells_done,
            "dwells_planned": self.dwells_planned,
            "alive": self.is_alive,
            "modified_utc": self.modified_utc.isoformat(timespec="seconds"),
            "trouble": self.trouble or None,
            **({"damaged": list(self.damaged)} if self.damaged else {}),
        }


@dataclass(frozen=True, slots=True)
class _Seen:
    """What a journal said, and how its files looked then."""

    fingerprint: Fingerprint
    written: State | None
    listed: ListedRun
    so_far: VerifiedSoFar | None = None
    """Of a run that lives, in a list that verifies."""


class RunList:
    """The runs directly under one folder; keep it, and what has not changed is not read again."""

    def __init__(self, folder: Path, clock: Clock | None = None, *, verifies: bool = False) -> None:
        """Look at a folder; ``verifies``: every journal that is read, event by event and dwell by dwell.

        Of a run that a living process runs, and which sees itself to what others write, only what was committed since
        the look before is verified at once (:class:`VerifiedSoFar`), and the whole when that process has ended. Bytes
        that change on the disk later, under the same time of modification, are seen by the next list.
        """
        self.folder = folder
        self._verifies = verifies
        self._clock = clock or SystemClock()
        self._seen: Mapping[Path, _Seen] = {}
        self._growing: Mapping[Path, VerifiedSoFar] = {}

    def read(self) -> tuple[ListedRun, ...]:
        """Return every run as it stands now, the latest start first; those that cannot be read come last."""
        found: dict[Path, _Seen] = {}
        listed = [run for path in self.paths() if (run := self._listed(path, found)) is not None]
        self._seen = {path: seen for path, seen in found.items() if seen.written is not None and self._is_settled(seen)}
        self._growing = {path: seen.so_far for path, seen in found.items() if seen.so_far is not None}
        return tuple(sorted(listed, key=_latest_first))

    def latest(self) -> tuple[ListedRun | None, tuple[ListedRun, ...]]:
        """Return the run of the latest start, and those that cannot be read before it is found.

        Of the others the start alone is read: their plans and dwells take six times as long.
        """
        begun = {path: _begun_s(path) for path in self.paths()}
        found: list[ListedRun] = []
        for path in sorted(begun, key=lambda path: (-begun[path], path.name)):
            if (run := self._listed(path, {})) is None:
                continue
            found.append(run)
            if begun[path] < inf and not run.trouble:
                break
        sound = sorted((run for run in found if not run.trouble), key=_latest_first)
        return next(iter(sound), None), tuple(run for run in found if run.trouble)

    def _listed(self, path: Path, found: dict[Path, _Seen]) -> ListedRun | None:
        """Return a run as it stands now, and keep in ``found`` what its journal says; None where it is gone."""
        try:
            require_not_taken_away(path)
            is_alive = is_owned(path)  # asked first: what a dying owner wrote last is then read below
            fingerprint = _fingerprint(path)
            known = self._seen.get(path)
            if known is None or known.fingerprint != fingerprint or self._tells_otherwise(known, is_alive=is_alive):
                known = self._read(path, fingerprint, is_alive=is_alive)
            found[path] = known
        except FileNotFoundError:
            return None  # removed meanwhile
        except JournalTakenAway as error:
            taken_away = _unreadable(path, None, str(error), error.exit_status)
            return replace(taken_away, modified_utc=error.stopped_utc)
        except OSError as error:
            whose = ": it belongs to another account of this machine" if isinstance(error, PermissionError) else ""
            trouble = f"{error.filename}: {error.strerror}{whose}"
            return _unreadable(path, None, trouble, ExitStatus.FAILED)
        return _as_it_stands(known, is_alive=is_alive)

    def _tells_otherwise(self, known: _Seen, *, is_alive: bool) -> bool:
        """Return whether what a verifying list told of a run was of one that lived, and it does not, or vice versa."""
        return self._verifies and known.listed.is_alive != is_alive

    def _read(self, path: Path, fingerprint: Fingerprint, *, is_alive: bool) -> _Seen:
        so_far, status, damaged = None, None, tuple[str, ...]()
        try:
            with JournalReader.open(path) as reader:
                header, written = reader.header, reader.state()
                if self._verifies:
                    so_far = self._verified(path, reader, is_alive=is_alive)
                    damaged, design = so_far.look(reader).names, so_far.design_steps
                    status = so_far.status(is_alive=is_alive)
                else:
                    design = frozenset(dwell.step for dwell in header.plan.design_dwells)
                done = len(reader.accepted_steps() & design)
        except (ProcedureError, LookupError, TypeError, ValueError) as error:
            answer = error.exit_status if isinstance(error, ProcedureError) else ExitStatus.WRONG_REQUEST
            return _Seen(fingerprint, None, _unreadable(path, fingerprint, str(error), answer))
        listed = ListedRun(
            path, header.title, written, header.created_utc, done, len(design), is_alive, _modified_utc(fingerprint),
            damaged=damaged,
            exit_status=ExitStatus.WRONG_REQUEST if damaged else ExitStatus.DONE,
            status=status,
        )  # fmt: skip
        return _Seen(fingerprint, written, listed, so_far if is_alive else None)

    def _verified(self, path: Path, reader: JournalReader, *, is_alive: bool) -> VerifiedSoFar:
        """Return what was verified of a journal while its run lived, or that nothing was."""
        before = self._growing.get(path) if is_alive else None
        return before if before is not None and before.is_continued_by(reader) else VerifiedSoFar(reader)

    def alive(self) -> tuple[Path, ...]:
        """Return the runs that a living process runs; no journal is opened for this."""
        return tuple(path for path in self.paths() if _is_owned_for_all_we_know(path))

    def paths(self) -> tuple[Path, ...]:
        """Return the folders that hold a journal, held one, or may for all that this account is shown, by name."""
        try:
            found = list(self.folder.iterdir())
        except OSError:
            return ()
        return tuple(sorted(path for path in found if _may_hold_a_run(path)))

    def _is_settled(self, seen: _Seen) -> bool:
        now_ns = self._clock.now_utc().timestamp() * 1e9
        return all(stamp is None or now_ns - stamp[1] > SETTLED_NS for stamp in seen.fingerprint)


def _may_hold_a_run(path: Path) -> bool:
    try:
        return (path / JOURNAL_FILE).exists() or is_taken_away(path)
    except PermissionError:
        return True  # another account's: hidden it would look as if there were no run


def _begun_s(path: Path) -> float:
    """Return when a run began, by the header of its journal, as a time stamp; infinity where that cannot be told."""
    try:
        with JournalReader.open(path) as reader:
            return reader.header.created_utc.timestamp()
    except (ProcedureError, OSError, LookupError, TypeError, ValueError):
        return inf


def _as_it_stands(seen: _Seen, *, is_alive: bool) -> ListedRun:
    state = None if seen.written is None else derived_state(seen.written, is_alive=is_alive)
    return replace(seen.listed, state=state, is_alive=is_alive)


def _unreadable(path: Path, fingerprint: Fingerprint | None, trouble: str, answer: ExitStatus) -> ListedRun:
    modified = _modified_utc(fingerprint or ())
    return ListedRun(path, "", None, None, 0, 0, False, modified, trouble, exit_status=answer)


def _is_owned_for_all_we_know(path: Path) -> bool:
    """Return True while a process runs the run; False where its lock may not be looked at: it is another user's."""
    try:
        return is_owned(path)
    except OSError:
        return False


def _fingerprint(path: Path) -> Fingerprint:
    """Return what changes with a run's files. Raises: OSError where the journal itself cannot be looked at."""
    journal = path / JOURNAL_FILE
    beside = (journal.with_name(journal.name + "-wal"), CommittedCount(journal).path)
    return (_stamp(journal.stat()), *map(_stamp_if_there, beside))


def _stamp_if_there(path: Path) -> tuple[int, int, int] | None:
    """None also for an empty file: a reader may leave an empty write-ahead log, and that is no commit."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return _stamp(found) if found.st_size else None


def _stamp(found: os.stat_result) -> tuple[int, int, int]:
    return found.st_ino, found.st_mtime_ns, found.st_size


def _modified_utc(fingerprint: Fingerprint) -> datetime:
    return datetime.fromtimestamp(max((stamp[1] for stamp in fingerprint if stamp is not None), default=0) / 1e9, UTC)


def _latest_first(run: ListedRun) -> tuple[bool, float, str]:
    started = 0.0 if run.started_utc is None else -run.started_utc.timestamp()
    return run.started_utc is None, started, run.path.name
