"""Take a run up again after a stop, an abort, a trip or the death of its process.

Nothing is re-used across a break in trust: every axis is homed anew, the six-attitude check set is measured again and
compared with the one from the start, and only then the first missing dwell is measured. Changed files or software
refuse the resume with the difference shown, unless somebody answers for it (:mod:`procedures.journal.audit.changes`).
"""

import shlex
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from ams.errors import WriteFailed
from ams.whole_file import replace_file
from procedures.errors import RequestError
from procedures.journal.audit.changes import KIND as OVERRIDE
from procedures.journal.audit.changes import Change, changes_since, require_unchanged, with_what_may_change
from procedures.journal.audit.known_devices import KnownDevices, known_devices
from procedures.journal.header import RunHeader
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.location import is_copy
from procedures.journal.requests.spool import Spool
from procedures.journal.sidecar.owner import owning
from procedures.journal.sidecar.unwritten import unwritten_sentence
from procedures.journal.sidecar.verdict_file import set_verdict_aside
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.voids import QUARANTINED
from procedures.plan.plan import Plan
from procedures.records.progress import RunObserver
from procedures.records.states import ACTIVE, ANSWERED_FOR, RESUMABLE, State
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import Outcome
from procedures.run.engine import Start, run
from procedures.run.judgement.history import History, read_history
from procedures.run.services import RunServices, with_run_limits
from procedures.run.unbegun import telling_where_nothing_is_stored
from procedures.run.watch.clock_watch import TOLERANCE_S
from procedures.run.watch.device_watch import TakesOver
from rig.assembly.open_rig import Rig, choose_clock, open_rig
from rig.clock import Clock, VirtualClock
from rig.description.read import rig_from_json
from rig.description.rig_file import RigDescription
from rig.errors import RigBusy, RigError


@dataclass(frozen=True)
class Interrupted:
    """A run as its journal left it."""

    header: RunHeader
    plan: Plan
    state: State
    devices: KnownDevices
    history: History
    changes: tuple[Change, ...]
    """That somebody has answered for, now or before."""
    answered: tuple[str, ...]
    """Of these, before."""
    last_utc: datetime
    """Of what happened in it so far: in virtual time it may be to come."""
    stopped_utc: datetime
    """What the clock showed when it stopped, however that was set before."""


@dataclass(frozen=True, slots=True)
class ResumeAuthorisation:
    """Who resumes, and why."""

    operator: str
    reason: str = ""
    accepts_changes: bool = False
    """Goes on though files, software or devices are not what the run began with; needs a name and a reason."""


def resume(
    run_dir: Path,
    operator: str,
    reason: str = "",
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    services: RunServices | None = None,
    *,
    accepts_changes: bool = False,
) -> Outcome:
    """Continue a run on its own rig, as the journal describes it, with its own plan.

    ``accepts_changes``: go on though ports, interlocks or software changed, and over another device that the run has
    stopped at; every other key that changed is refused.
    Raises: RequestError (owner alive, not resumable, files or software changed, a trip or an abort without
    name and reason),
    JournalError (damaged), RigBusy and other rig errors before the first move.
    """
    authorisation = ResumeAuthorisation(operator, reason, accepts_changes)
    services = services or RunServices()
    with taken_over(run_dir, authorisation, idle_clock) as found:
        rig_file = None if found.header.is_rehearsal else Path(found.header.rig_path)
        description = rig_from_json(found.header.rig_json)
        with open_rig(
            description,
            clock=_clock_behind(description, found.last_utc),
            rig_file=rig_file,
            purpose="calrig resume",
            write=replace_file,
            claim=services.claim,
        ) as rig:
            services = replace(services, ended=rig.belongs_to(run_dir, services.ring))
            _require_nobody_else(rig)
            return go_on(run_dir, found, rig, authorisation, observer, idle_clock, services)


def go_on(
    run_dir: Path,
    found: Interrupted,
    rig: OpenRig,
    authorisation: ResumeAuthorisation,
    observer: RunObserver | None,
    idle_clock: Clock | None,
    services: RunServices | None,
) -> Outcome:
    """Go on with a run that was taken over, on a rig that is open."""
    services = with_run_limits(services, found.header)
    done = sum(dwell.accepted and dwell.purpose == "design" for dwell in found.history.dwells)
    new = [sentence for change in found.changes if (sentence := str(change)) not in found.answered]
    with telling_where_nothing_is_stored(run_dir, found.plan, done, rig, observer, services):
        journal = Journal.open_for_append(run_dir / JOURNAL_FILE)
        if new:
            detail = {"by": authorisation.operator, "reason": authorisation.reason, "differences": new}
            journal.append_event(OVERRIDE, detail, rig.clock)
        if (behind_s := (found.stopped_utc - rig.clock.now_utc()).total_seconds()) > TOLERANCE_S:
            journal.append_event("clock_step", {"step_s": -round(behind_s, 3)}, rig.clock)
        with suppress(WriteFailed):  # a verdict that stands too long hinders no run
            set_verdict_aside(run_dir)
    services.begun()
    takes_over = TakesOver(authorisation.operator, authorisation.reason) if authorisation.accepts_changes else None
    start = Start(authorisation.operator, found.state, authorisation.reason, found.devices, takes_over)
    return run(found.plan, rig, journal, Spool(run_dir), start, found.history, observer, idle_clock, services)


def _clock_behind(description: RigDescription, last_utc: datetime) -> Clock:
    """Return the clock of the rig; virtual time goes on where the journal ends, though that is ahead of the wall's."""
    clock = choose_clock(description)
    if isinstance(clock, VirtualClock):
        clock.begin_no_earlier(last_utc)
    return clock


def _require_nobody_else(rig: Rig) -> None:
    """Refuse before the run is opened again where somebody has one of its devices by another port. Raises: RigBusy.

    A device that is silent or another one is the engine's to judge, which can hold the run until it answers.
    """
    try:
        rig.identities()
    except RigBusy:
        raise
    except RigError:
        return


@contextmanager
def taken_over(run_dir: Path, authorisation: ResumeAuthorisation, clock: Clock | None) -> Iterator[Interrupted]:
    """Own the run and know where it stands. Raises: RequestError, JournalError."""
    with JournalReader.open(run_dir):
        pass  # a folder without a journal is told before anything is written there
    with owning(run_dir, clock):
        found = _read(run_dir)
        _require_resumable(run_dir, found, authorisation.operator, authorisation.reason)
        require_unchanged(
            run_dir,
            found.changes,
            found.answered,
            is_accepted=authorisation.accepts_changes,
            operator=authorisation.operator,
            reason=authorisation.reason,
            is_rehearsal=found.header.is_rehearsal,
        )
        header = found.header
        if found.changes:
            rig_json = with_what_may_change(
                header.rig_json, Path(header.rig_path), found.changes, is_rehearsal=header.is_rehearsal
            )
            found = replace(found, header=replace(header, rig_json=rig_json))
        yield found


def _read(run_dir: Path) -> Interrupted:
    with JournalReader.open(run_dir) as reader:
        plan, events = reader.header.plan, list(reader.events())
        return Interrupted(
            header=reader.header,
            plan=plan,
            state=reader.state(),
            devices=known_devices(events),
            history=read_history(reader, plan),
            changes=(*changes_since(reader.header), *_copied(run_dir, reader)),
            answered=tuple(_answered(reader)),
            last_utc=max(event.utc for event in events),
            stopped_utc=events[-1].utc,
        )


def _copied(run_dir: Path, reader: JournalReader) -> Iterator[Change]:
    """Tell that this folder is a copy: a run that goes on in two places is two runs under one name."""
    opened, salvaged = reader.last_event("opened"), reader.last_event(QUARANTINED)
    if opened is None or (salvaged is not None and salvaged.sequence > opened.sequence):
        return  # a salvaged run lies elsewhere by its nature
    before = opened.detail.get("place")
    if isinstance(before, dict) and is_copy(run_dir, before):
        yield Change(
            "run folder (this is a copy, and both could go on)", str(before.get("path")), str(run_dir.resolve())
        )


def _answered(reader: JournalReader) -> Iterator[str]:
    for event in reader.events(OVERRIDE):
        differences = event.detail["differences"]
        assert isinstance(differences, list)
        yield from map(str, differences)


def _require_resumable(run_dir: Path, found: Interrupted, operator: str, reason: str) -> None:
    if found.state not in (*ACTIVE, *RESUMABLE):
        to_do = unwritten_sentence(run_dir, found.state)
        if not to_do and found.state is State.FINISHED:
            to_do = (
                f"calrig solve {shlex.quote(str(run_dir))} makes its results again; to measure again begin a new run"
            )
        raise RequestError(
            f"{run_dir}: the run is {found.state}, and resume takes {', '.join(RESUMABLE)}; nothing was changed; "
            f"{to_do or 'begin a new run'}"
        )
    if found.state in ANSWERED_FOR and not (operator and reason.strip()):
        raise RequestError(
            f"{run_dir}: the run is {found.state}, so a person has to look first: operator got {operator!r}, "
            f"reason got {reason!r}, both are needed; nothing was changed; give --operator and --reason"
        )
