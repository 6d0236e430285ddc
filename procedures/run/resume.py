"""Take a run up again after a stop, a trip or the death of its process.

Nothing is re-used across a break in trust: every axis is homed anew, the six-attitude check set is measured again and
compared with the one from the start, and only then the first missing dwell is measured. Changed files or software
refuse the resume with the difference shown.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path

from procedures.errors import RequestError
from procedures.plan.plan import Plan
from procedures.run.care import Care, with_precautions
from procedures.run.ending import Outcome
from procedures.run.engine import Start, run
from procedures.run.header import RunHeader, calrig_version
from procedures.run.history import History, read_history
from procedures.run.journal import Journal
from procedures.run.journal_reader import JournalReader
from procedures.run.measure import OpenRig
from procedures.run.owner import owning
from procedures.run.progress import RunObserver
from procedures.run.spool import Spool
from procedures.run.states import ACTIVE, RESUMABLE, State
from procedures.run.storage import JOURNAL_FILE
from rig.clock import Clock
from rig.description import rig_from_json

_DIFF_LINES = 40


@dataclass(frozen=True)
class Interrupted:
    """A run as its journal left it."""

    header: RunHeader
    plan: Plan
    state: State
    identities: dict[str, str] | None
    history: History


def resume(
    run_dir: Path,
    operator: str,
    reason: str = "",
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    care: Care | None = None,
) -> Outcome:
    """Continue a run on its own rig, as the journal describes it, with its own plan.

    Raises: RequestError (owner alive, not resumable, files or software changed, a trip without name and reason),
    JournalError (damaged), RigBusy and other rig errors before the first move.
    """
    from rig.assembly import open_rig

    with _taken_over(run_dir, operator, reason, idle_clock) as found:
        rig_file = None if found.header.is_rehearsal else Path(found.header.rig_path)
        with open_rig(rig_from_json(found.header.rig_json), rig_file=rig_file, purpose="calrig resume") as rig:
            return _go_on(run_dir, found, rig, operator, reason, observer, idle_clock, care)


def resume_on(
    run_dir: Path,
    rig: OpenRig,
    operator: str,
    reason: str = "",
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    care: Care | None = None,
) -> Outcome:
    """As :func:`resume`, on a rig that the caller has opened."""
    with _taken_over(run_dir, operator, reason, idle_clock) as found:
        return _go_on(run_dir, found, rig, operator, reason, observer, idle_clock, care)


def _go_on(
    run_dir: Path,
    found: Interrupted,
    rig: OpenRig,
    operator: str,
    reason: str,
    observer: RunObserver | None,
    idle_clock: Clock | None,
    care: Care | None,
) -> Outcome:
    journal = Journal.open_for_append(run_dir / JOURNAL_FILE)
    care = with_precautions(care, found.header)
    start = Start(operator, found.state, reason, found.identities)
    return run(found.plan, rig, journal, Spool(run_dir), start, found.history, observer, idle_clock, care)


@contextmanager
def _taken_over(run_dir: Path, operator: str, reason: str, clock: Clock | None) -> Iterator[Interrupted]:
    """Own the run and know where it stands. Raises: RequestError, JournalError."""
    with JournalReader.open(run_dir):
        pass  # a folder without a journal is told before anything is written there
    with owning(run_dir, clock):
        found = _read(run_dir)
        _require_resumable(run_dir, found, operator, reason)
        require_unchanged(run_dir, found.header)
        yield found


def _read(run_dir: Path) -> Interrupted:
    with JournalReader.open(run_dir) as reader:
        plan, identities = reader.header.plan, reader.last_event("identities")
        return Interrupted(
            header=reader.header,
            plan=plan,
            state=reader.state(),
            identities={key: str(value) for key, value in identities.detail.items()} if identities else None,
            history=read_history(reader, plan),
        )


def _require_resumable(run_dir: Path, found: Interrupted, operator: str, reason: str) -> None:
    if found.state not in (*ACTIVE, *RESUMABLE):
        raise RequestError(
            f"{run_dir}: the run is {found.state}, and resume takes {', '.join(RESUMABLE)}; nothing was changed; "
            "begin a new run"
        )
    if found.state is State.TRIPPED and not (operator and reason.strip()):
        raise RequestError(
            f"{run_dir}: the run is tripped, so a person has to look first: operator got {operator!r}, reason got "
            f"{reason!r}, both are needed; nothing was changed; give --operator and --reason"
        )


def require_unchanged(run_dir: Path, header: RunHeader) -> None:
    """Raise RequestError with the difference where a file or the software is not what the run began with.

    A file that is gone contradicts nothing: the journal holds its text.
    """
    for path, text in ((header.rig_path, header.rig_text), (header.procedure_path, header.procedure_text)):
        found = _text_of(Path(path))
        if found is not None and found != text:
            lines = list(
                unified_diff(text.splitlines(), found.splitlines(), "when the run began", path, lineterm="", n=0)
            )
            raise RequestError(
                f"{run_dir}: {path} is not what the run began with; nothing was changed; put it back, or begin a new "
                "run:\n" + "\n".join(lines[:_DIFF_LINES])
            )
    began, now = header.software.get("calrig"), calrig_version()
    if began != now:
        raise RequestError(
            f"{run_dir}: the run began with calrig {began}, this is {now}; nothing was changed; resume it with the "
            "version that began it, or begin a new run"
        )


def _text_of(path: Path) -> str | None:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(
            f"{path}: cannot be read: {error}; nothing was changed; resume needs to compare it"
        ) from None
