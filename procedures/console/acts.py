"""What a page does to a run: by the same requests as the commands, with the name of who asks.

A run that a process runs is asked through its folder of requests and looks for itself whether the asker saw its state;
of one that nobody runs the audit trail is written as ``calrig void``, ``redo``, ``note`` and ``ack`` write it. An abort
goes to the stop guard first, as ``calrig abort`` does: the axes stop before anything else is looked at.
"""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import get_args

from procedures.console.rights import STOPS, Act
from procedures.console.withheld import withheld_sentence
from procedures.delivery.ended_results import archive_kept_by, end_results
from procedures.errors import ProcedureError, RequestError, StorageFailed
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import Authorisation, acknowledge, add_note, redo, void_from
from procedures.journal.requests.spool import Kind, Request, Spool, ask, words_complaint
from procedures.journal.sidecar.owner import is_owned
from rig.clock import Clock
from rig.guard.ask import of_run
from rig.guard.ask import stop as stop_by_guard
from rig.plain_text import LONGEST_TEXT, PARAGRAPHS, one_line

VIA = "console"
ACCEPTED, REFUSED, WRONG = 202, 409, 400
ON_RUNS: tuple[Act, ...] = ("pause", "continue", "stop", "abort", "note", "ack", "void", "redo")


@dataclass(frozen=True, slots=True)
class Action:
    """One act, as the browser sent it."""

    act: Act
    by: str
    address: str
    """The address of the browser."""
    key: str
    expects: int | None
    text: str
    number: int | None
    """The step to void from, or the replication to redo."""
    is_remounted: bool
    fields: Mapping[str, str]
    """All that was sent, for what only some acts have."""
    may_arm: bool = False
    """Whether who asks may arm the queue of that rig, from where the browser is."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of it."""

    status: int
    message: str


def read_act(act: Act, fields: Mapping[str, str], by: str, address: str) -> Action:
    """Return what a form or a program sent. Raises: RequestError naming the field that is wrong."""
    key = fields.get("key", "")
    if not key or len(key) > 80 or not key.isascii() or not key.isprintable():
        raise RequestError(
            f"{act}: its key, by which an act that comes twice is done once: needed are 1 to 80 plain characters; "
            "nothing was done"
        )
    text = fields.get("text", "").strip().replace("\r\n", "\n")  # so a form sends a line break
    if act in STOPS:  # whatever it holds, it stops
        text = one_line(text)[:LONGEST_TEXT]
    elif complaint := words_complaint(by, text, address, PARAGRAPHS if act in ("note", "ack") else ""):
        raise RequestError(f"{act}: {complaint}; nothing was done")
    if act == "note" and not text:
        raise RequestError("note: the text is missing: what to write down; nothing was noted")
    return Action(
        act,
        by,
        address,
        key,
        whole_number(act, "expects", fields),
        text,
        whole_number(act, "number", fields),
        fields.get("remounted", "") in ("1", "true", "on"),
        fields,
    )


def whole_number(act: Act, name: str, fields: Mapping[str, str]) -> int | None:
    """Return a number that was sent; None where none was. Raises: RequestError."""
    given = fields.get(name, "")
    if not given:
        return None
    if not given.isascii() or not given.isdigit() or len(given) > 12:
        what = "the state that was seen" if name == "expects" else _counted(act, name)
        raise RequestError(
            f"{act}: {what}: got {given[:20]!r}, needed is a whole number of at most 12 digits; nothing was done"
        )
    return int(given)


def _counted(act: Act, name: str = "number") -> str:
    """Return what an act counts, in words."""
    if name == "to":
        return "the item to put it before"
    return {"redo": "the replication to measure again", "void": "the step to take back from"}.get(act, "its number")


def perform(folder: Path, action: Action, clock: Clock, archive_url: str) -> Answer:
    """Do it, or say why not. ``archive_url``: of the console, where the run keeps no other."""
    try:
        if action.act == "abort":
            return _abort(folder, action, clock.now_utc())
        if action.act in ("void", "redo"):
            return _take_back(folder, action, clock, archive_url)
        if is_owned(folder):
            return _ask(folder, action, clock.now_utc())
        return _write(folder, action, clock)
    except ProcedureError as error:
        return Answer(REFUSED, str(error))
    except OSError as error:
        return Answer(REFUSED, withheld_sentence(error))


def _abort(folder: Path, action: Action, now: datetime) -> Answer:
    """Have the guard stop the axes, then tell the engine why; without a guard the engine stops them itself.

    A folder that takes nothing, as that of another account, is no failure where the guard stopped the axes.
    """
    outcomes: dict[str, str] = {}
    for guard in of_run(str(folder), str(folder.parent)):
        outcomes |= stop_by_guard(guard, None, action.by) or {}
    if not outcomes and not is_owned(folder):
        raise RequestError(f"{folder}: no process runs this run, so nothing moves by it; nothing was asked")
    outcome_text = "; ".join(f"{axis}: {outcome}" for axis, outcome in sorted(outcomes.items()))
    request = Request("abort", action.by, now.isoformat(), action.text, None, VIA, action.address, action.key)
    try:
        Spool(folder).submit(request)
    except StorageFailed as error:
        if not outcomes:
            raise
        outcome_text += f"; the reason was not written down: {error}"
    return Answer(ACCEPTED, f"abort was asked for{f' ({outcome_text})' if outcome_text else ''}")


def _ask(folder: Path, action: Action, now: datetime) -> Answer:
    kind: Kind = next(kind for kind in get_args(Kind) if kind == action.act)
    if action.expects is None and action.act not in ("stop", "note"):
        return Answer(REFUSED, f"{kind} does not say in view of which state of the run it was asked; nothing was done")
    ask(
        folder,
        kind,
        action.by,
        now,
        action.text,
        expects=action.expects,
        via=VIA,
        address=action.address,
        key=action.key,
    )
    return Answer(ACCEPTED, f"{kind} was asked for; the run says when it took it")


def _write(folder: Path, action: Action, clock: Clock) -> Answer:
    if action.act == "note":
        add_note(folder, action.by, action.text, clock, via=VIA, address=action.address)
        return Answer(ACCEPTED, "noted")
    if action.act == "ack":
        _require_seen(folder, action)
        acknowledge(folder, action.by, action.text, clock, via=VIA, address=action.address)
        return Answer(ACCEPTED, "acknowledged")
    return Answer(REFUSED, f"cannot {action.act}: no process runs this run; nothing was asked")


def _take_back(folder: Path, action: Action, clock: Clock, archive_url: str) -> Answer:
    """Void dwells from a step on, or a replication: they are kept, and measured again."""
    if action.number is None:
        return Answer(WRONG, f"{action.act}: {_counted(action.act)} is missing; nothing was changed")
    _require_seen(folder, action)
    word = Authorisation(action.by, action.text, action.is_remounted, VIA, action.address)
    count = (void_from if action.act == "void" else redo)(folder, action.number, word, clock)
    ended = end_results(folder, archive_kept_by(folder, archive_url))
    again = f"calrig resume {shlex.quote(str(folder.absolute()))} measures them again"
    return Answer(ACCEPTED, "; ".join((f"{count} dwells taken back", again, *ended.done, *ended.remains)))


def _require_seen(folder: Path, action: Action) -> None:
    """Refuse what was asked in view of another state. Raises: RequestError."""
    with JournalReader.open(folder) as reader:
        entered = reader.last_event("state")
    if entered is None or action.expects != entered.sequence:
        raise RequestError(
            f"{action.act} was asked in view of another state of the run; nothing was done; look again, then ask again"
        )
