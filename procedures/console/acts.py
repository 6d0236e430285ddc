"""What a page does to a run: by the same requests as the commands, with the name of who asks.

A run that a process runs is asked through its folder of requests and looks for itself whether the asker saw its state;
of one that nobody runs the audit trail is written as ``calrig void``, ``redo``, ``note`` and ``ack`` write it. An abort
goes to the stop guard first, as ``calrig abort`` does: the axes stop before anything else is looked at.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import get_args

from procedures.console.rights import Act
from procedures.errors import ProcedureError, RequestError, StorageFailed
from procedures.journal.corrections import Authorisation, acknowledge, add_note, redo, void_from
from procedures.journal.journal_reader import JournalReader
from procedures.journal.owner import is_owned
from procedures.journal.spool import Kind, Request, Spool, ask
from rig.clock import Clock
from rig.guard.ask import of_run
from rig.guard.ask import stop as stop_by_guard
from rig.plain_text import one_line

VIA = "console"
LONGEST_TEXT = 2000
ACCEPTED, REFUSED, WRONG = 202, 409, 400
ON_RUNS: tuple[Act, ...] = ("pause", "continue", "stop", "abort", "note", "ack", "void", "redo")


@dataclass(frozen=True, slots=True)
class Asked:
    """One act, as the browser sent it."""

    act: Act
    by: str
    place: str
    """The address of the browser."""
    key: str
    expects: int | None
    text: str
    number: int | None
    """The step to void from, or the replication to redo."""
    is_remounted: bool
    fields: Mapping[str, str]
    """All that was sent, for what only some acts have."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of it."""

    status: int
    told: str


def read_act(act: Act, fields: Mapping[str, str], by: str, place: str) -> Asked:
    """Return what a form or a program sent. Raises: RequestError naming the field that is wrong."""
    key = fields.get("key", "")
    if not key or len(key) > 80 or not key.isascii() or not key.isprintable():
        raise RequestError(f"{act}: key: needed are 1 to 80 plain characters of this act alone; nothing was done")
    text = one_line(fields.get("text", "").strip())
    if len(text) > LONGEST_TEXT:
        raise RequestError(f"{act}: text: got {len(text)} characters, allowed are {LONGEST_TEXT}; nothing was done")
    if act == "note" and not text:
        raise RequestError("note: text: needed is what to write down; nothing was noted")
    return Asked(
        act,
        by,
        place,
        key,
        _number(act, "expects", fields),
        text,
        _number(act, "number", fields),
        fields.get("remounted", "") in ("1", "true", "on"),
        fields,
    )


def _number(act: Act, name: str, fields: Mapping[str, str]) -> int | None:
    given = fields.get(name, "")
    if not given:
        return None
    if not given.isascii() or not given.isdigit() or len(given) > 12:
        raise RequestError(f"{act}: {name}: got {given[:20]!r}, needed is a whole number; nothing was done")
    return int(given)


def perform(folder: Path, asked: Asked, clock: Clock) -> Answer:
    """Do it, or say why not."""
    try:
        if asked.act == "abort":
            return _abort(folder, asked, clock.now_utc())
        if asked.act in ("void", "redo"):
            return _take_back(folder, asked, clock)
        if is_owned(folder):
            return _ask(folder, asked, clock.now_utc())
        return _write(folder, asked, clock)
    except ProcedureError as error:
        return Answer(REFUSED, str(error))


def _abort(folder: Path, asked: Asked, now: datetime) -> Answer:
    """Have the guard stop the axes, then tell the engine why; without a guard the engine stops them itself.

    A folder that takes nothing, as that of another account, is no failure where the guard stopped the axes.
    """
    outcomes: dict[str, str] = {}
    for guard in of_run(str(folder), str(folder.parent)):
        outcomes |= stop_by_guard(guard, None, asked.by) or {}
    if not outcomes and not is_owned(folder):
        raise RequestError(f"{folder}: no process runs this run, so nothing moves by it; nothing was asked")
    told = "; ".join(f"{axis}: {outcome}" for axis, outcome in sorted(outcomes.items()))
    request = Request("abort", asked.by, now.isoformat(), asked.text, None, VIA, asked.place, asked.key)
    try:
        Spool(folder).submit(request)
    except StorageFailed as error:
        if not outcomes:
            raise
        told += f"; the reason was not written down: {error}"
    return Answer(ACCEPTED, f"abort was asked for{f' ({told})' if told else ''}")


def _ask(folder: Path, asked: Asked, now: datetime) -> Answer:
    kind: Kind = next(one for one in get_args(Kind) if one == asked.act)
    if asked.expects is None and asked.act not in ("stop", "note"):
        return Answer(REFUSED, f"{kind} does not say in view of which state it was asked (expects); nothing was done")
    ask(folder, kind, asked.by, now, asked.text, expects=asked.expects, via=VIA, place=asked.place, key=asked.key)
    return Answer(ACCEPTED, f"{kind} was asked for; the run says when it took it")


def _write(folder: Path, asked: Asked, clock: Clock) -> Answer:
    if asked.act == "note":
        add_note(folder, asked.by, asked.text, clock, via=VIA, place=asked.place)
        return Answer(ACCEPTED, "noted")
    if asked.act == "ack":
        _require_seen(folder, asked)
        acknowledge(folder, asked.by, asked.text, clock, via=VIA, place=asked.place)
        return Answer(ACCEPTED, "acknowledged")
    return Answer(REFUSED, f"cannot {asked.act}: no process runs this run; nothing was asked")


def _take_back(folder: Path, asked: Asked, clock: Clock) -> Answer:
    if asked.number is None:
        return Answer(WRONG, f"{asked.act}: number: needed is a step, or a replication; nothing was changed")
    _require_seen(folder, asked)
    word = Authorisation(asked.by, asked.text, asked.is_remounted, VIA, asked.place)
    count = (void_from if asked.act == "void" else redo)(folder, asked.number, word, clock)
    return Answer(ACCEPTED, f"{count} dwells taken back; calrig resume {folder.name} measures them again")


def _require_seen(folder: Path, asked: Asked) -> None:
    """Refuse what was asked in view of another state. Raises: RequestError."""
    with JournalReader.open(folder) as reader:
        entered = reader.last_event("state")
    if entered is None or asked.expects != entered.sequence:
        raise RequestError(
            f"{asked.act} was asked in view of another state of the run (expects {asked.expects}); nothing was done; "
            "look again, then ask again"
        )
