"""What a person writes into the journal of a run that no process runs: notes, dwells taken back, replications redone.

Nothing is edited: each is one more line of the audit trail (:mod:`procedures.journal.voids`).
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from ams.errors import WriteFailed
from procedures.errors import RequestError
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import words_complaint
from procedures.journal.sidecar.alert_record import keep_acknowledgement
from procedures.journal.sidecar.owner import is_owned, owning
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.taken_away import require_not_taken_away
from procedures.journal.voids import KIND, key_of, void_detail
from procedures.records.dwells import DwellRecord
from procedures.records.states import ACTIVE, RESUMABLE, State, is_unasked, require_transition
from rig.clock import Clock, SystemClock
from rig.plain_text import LONGEST_NAME, LONGEST_TEXT, text_complaint

TAKES_BACK = (*ACTIVE, *RESUMABLE, State.FINISHED)
"""States of a run that no process runs in which dwells can be taken back."""


@dataclass(frozen=True, slots=True)
class Authorisation:
    """Who says it, and why."""

    operator: str
    reason: str
    is_remounted: bool = False
    """The package was moved: what is measured from now on belongs to a new mounting."""
    via: str = ""
    """By what it was said, where not by a command."""
    address: str = ""
    """From where."""

    def __post_init__(self) -> None:
        """Refuse texts that nobody can read, whoever asks. Raises: RequestError."""
        for name, text, longest in (("operator", self.operator, LONGEST_NAME), ("reason", self.reason, LONGEST_TEXT)):
            if complaint := text_complaint(text, longest=longest):
                raise RequestError(f"{name}: {complaint}; nothing was changed")


def measured_from(run_dir: Path, step: int) -> list[DwellRecord]:
    """Return the accepted dwell of ``step`` and all that were measured after it, in the order of time.

    Raises: RequestError where no dwell of it counts, JournalError.
    """
    accepted = _accepted(run_dir)
    index = next((index for index, dwell in enumerate(accepted) if dwell.step == step), None)
    if index is None:
        known = f"{accepted[0].step} to {accepted[-1].step}" if accepted else "none"
        raise RequestError(
            f"{run_dir}: no accepted dwell of step {step} (accepted steps: {known}); nothing was changed; the report "
            "and calrig handover name steps"
        )
    return accepted[index:]


def measured_of(run_dir: Path, replication: int) -> list[DwellRecord]:
    """Return the accepted dwells of one replication. Raises: as :func:`measured_from`."""
    dwells = [dwell for dwell in _accepted(run_dir) if dwell.replication == replication]
    if not dwells:
        raise RequestError(
            f"{run_dir}: replication {replication} has no accepted dwell, so it is measured anyway; nothing was changed"
        )
    return dwells


def void_from(run_dir: Path, step: int, authorisation: Authorisation, clock: Clock | None = None) -> int:
    """Take back the dwell of ``step`` and everything measured after it, in the order of time; returns how many.

    Raises: RequestError (a process runs the run, no such dwell, no reason), JournalError, StorageFailed.
    """
    return _void(run_dir, measured_from(run_dir, step), "void", authorisation, clock)


def redo(run_dir: Path, replication: int, authorisation: Authorisation, clock: Clock | None = None) -> int:
    """Take back every dwell of one replication, to be measured again. Returns and raises as :func:`void_from`."""
    return _void(run_dir, measured_of(run_dir, replication), "redo", authorisation, clock)


def add_note(
    run_dir: Path, operator: str, text: str, clock: Clock | None = None, *, via: str = "", address: str = ""
) -> None:
    """Add a note to a run that no process runs. Raises: RequestError, JournalError, StorageFailed."""
    _say(run_dir, "note", operator, text, clock or SystemClock(), _whence(via, address))


def acknowledge(
    run_dir: Path, operator: str, text: str, clock: Clock | None = None, *, via: str = "", address: str = ""
) -> None:
    """Somebody knows of the alarm of a run that no process runs. Raises as :func:`add_note`."""
    clock = clock or SystemClock()
    _say(run_dir, "ack", operator, text, clock, _whence(via, address))
    with JournalReader.open(run_dir) as reader:
        name = reader.header.run_id
    with suppress(WriteFailed):  # its journal has it; only who rings beside a run that was moved needs it there
        keep_acknowledgement(name, operator, text, clock.now_utc())


def _say(run_dir: Path, kind: str, by: str, text: str, clock: Clock, whence: Mapping[str, str]) -> None:
    if complaint := words_complaint(by, text, whence.get("place", "")):
        raise RequestError(f"{run_dir}: {kind}: {complaint}; nothing was noted")
    with _owned_journal(run_dir, clock) as journal:
        journal.append_event(kind, {"by": by, "text": text, "at_utc": clock.now_utc().isoformat(), **whence}, clock)


def _whence(via: str, address: str) -> dict[str, str]:
    """Return by what and from where it was said; nothing of a command."""
    return {name: value for name, value in (("via", via), ("place", address)) if value}


def is_acknowledged(run_dir: Path) -> bool:
    """Return True where somebody acknowledged the last state of a run, or took the run up again."""
    with JournalReader.open(run_dir) as reader:
        last, known = reader.last_event("state"), reader.last_event("ack")
    assert last is not None
    if known is not None and known.sequence > last.sequence:
        return True
    state = State(str(last.detail["to"]))
    if state in ACTIVE:  # its end could not be written; who owns it now has taken it up
        return is_owned(run_dir)
    return not is_unasked(state, str(last.detail.get("by", "")))


def close_run(run_dir: Path, word: Authorisation, clock: Clock | None = None) -> None:
    """Close a run, never to be resumed.

    Raises: RequestError (a process runs the run, it has ended, no reason), JournalError, StorageFailed.
    """
    if not word.reason.strip():
        raise RequestError(f"{run_dir}: close needs a reason, got {word.reason!r}; nothing was changed; give --reason")
    clock = clock or SystemClock()
    with _owned_journal(run_dir, clock) as journal:
        with JournalReader.open(run_dir) as reader:
            state = reader.state()
        if state in ACTIVE:  # nobody owns it: its process died
            _enter(journal, state, State.INTERRUPTED, "", "the process ended without a last line", clock)
            state = State.INTERRUPTED
        if state not in RESUMABLE:
            raise RequestError(
                f"{run_dir}: the run is {state}, and close takes {', '.join(RESUMABLE)}; nothing was changed"
            )
        _enter(journal, state, State.CLOSED, word.operator, word.reason, clock)


def _enter(journal: Journal, source: State, target: State, by: str, reason: str, clock: Clock) -> None:
    require_transition(source, target)
    journal.append_event("state", {"from": source, "to": target, "by": by, "reason": reason}, clock)


def _accepted(run_dir: Path) -> list[DwellRecord]:
    """Return the accepted dwells in the order of commitment, without check sets: each epoch measures its own."""
    with JournalReader.open(run_dir) as reader:
        return [dwell for dwell in reader.dwells(accepted_only=True) if dwell.purpose != "check"]


def _void(
    run_dir: Path, dwells: list[DwellRecord], cause: str, authorisation: Authorisation, clock: Clock | None
) -> int:
    if not authorisation.reason.strip():
        raise RequestError(
            f"{run_dir}: {cause} needs a reason, got {authorisation.reason!r}; nothing was changed; give --reason"
        )
    clock = clock or SystemClock()
    with _owned_journal(run_dir, clock) as journal:
        with JournalReader.open(run_dir) as reader:
            state = reader.state()
        if state not in TAKES_BACK:
            raise RequestError(
                f"{run_dir}: the run is {state}, nothing follows it; nothing was changed; begin a new run"
            )
        by, reason, is_remounted = authorisation.operator, authorisation.reason, authorisation.is_remounted
        detail = void_detail(map(key_of, dwells), by, reason, cause, is_remounted=is_remounted)
        journal.append_event(KIND, {**detail, **_whence(authorisation.via, authorisation.address)}, clock)
        if state is State.FINISHED:
            _enter(journal, state, State.STOPPED, authorisation.operator, f"{cause}: {authorisation.reason}", clock)
    return len(dwells)


@contextmanager
def _owned_journal(run_dir: Path, clock: Clock) -> Iterator[Journal]:
    require_not_taken_away(run_dir)  # told before anything is written there
    with owning(run_dir, clock, "correction"):
        journal = Journal.open_for_append(run_dir / JOURNAL_FILE)
        try:
            yield journal
        finally:
            journal.close()
