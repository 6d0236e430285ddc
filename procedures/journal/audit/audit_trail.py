"""The audit trail as a reader of the report needs it: interruptions, notes and who the devices said they are."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from procedures.journal.sidecar.guard_record import EVENT as GUARDED
from procedures.records.axes_at_rest import axes_in_words
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import MADE_AGAIN

GOING = "running"
SAFE = "safe"
"""Kind of the event that says where the axes rest, before the state that they were stopped for."""
OF_OTHERS = ("note", "ack", "voided", "override")
"""Events that the process which ran the run did not write last, or need not have: they say nothing of its life."""
OPENED = "opened"
"""What a process writes first: from here to the next state it tells what became of the one before."""
FROM_LAST_SIGN = "counted from its last sign of life"
NOT_GOING = ("paused", "held", "stopped", "tripped", "aborted", "failed", "interrupted", "closed")


@dataclass(frozen=True)
class Standstill:
    """A state in which the run stood still."""

    what: str
    """``paused``, ``held``, ``stopped``, ``tripped``, ``interrupted`` …"""
    began_utc: datetime
    by: str
    reason: str
    axes: str = ""
    """What was seen of the axes when it was entered, a sentence; empty where they were not told to stop for it."""


@dataclass(frozen=True)
class Interruption:
    """A stretch in which the run did not go on."""

    what: str
    """``paused``, ``held``, ``stopped``, ``tripped``, ``interrupted`` …"""
    began_utc: datetime
    ended_utc: datetime | None
    """None where it never went on."""
    by: str
    reason: str
    resumed_by: str = ""
    """Who took the run up again; empty where it went on by itself."""
    resumed_because: str = ""
    axes: str = ""
    """As of :class:`Standstill`."""
    later: tuple[Standstill, ...] = ()
    """The states that it went on to without running in between, in this order."""

    @property
    def newest_first(self) -> tuple[Standstill, ...]:
        """Every state of it, that in which the run stood last first."""
        return (*reversed(self.later), Standstill(self.what, self.began_utc, self.by, self.reason, self.axes))


@dataclass(frozen=True)
class Note:
    """A line of the audit trail that a reader of the report should see."""

    utc: datetime
    by: str
    text: str


@dataclass(frozen=True)
class MadeAgain:
    """A move, or a search for home, that did not end at the first attempt and was made again."""

    utc: datetime
    axis: str
    """On which it was seen."""
    found: str
    """What was found of it, and what was done then."""


def interruptions_in(events: Sequence[Event]) -> tuple[Interruption, ...]:
    """Return every stretch between leaving ``running`` and coming back to it, under the name it began with.

    A process that died wrote nothing: the resume that took the run over wrote ``interrupted``, and the stretch began
    with the last sign of life of that process: its last event, or what its stop guard saw later. What people wrote
    afterwards is none, nor is what the resume wrote before it came to say ``interrupted``.
    """
    found: list[Interruption] = []
    unended: Interruption | None = None
    last_sign: Event | None = None
    is_taken_up = False
    axes = ""
    for event in events:
        state = str(event.detail.get("to", "")) if event.kind == "state" else ""
        axes = _axes(event) if event.kind == SAFE else axes
        if state in NOT_GOING:
            is_found = state == "interrupted" and last_sign is not None
            began = last_sign if is_found and last_sign is not None else event
            why = f"{_why(event)}; {FROM_LAST_SIGN}".removeprefix("; ") if is_found else _why(event)
            stands = Standstill(state, began.utc, _who(event), why, axes)
            unended = _begun(stands) if unended is None else replace(unended, later=(*unended.later, stands))
        elif unended is not None and state == GOING:
            found.append(replace(unended, ended_utc=event.utc))
            unended = None
        elif unended is not None and state == "checking" and _who(event):
            unended = replace(unended, resumed_by=_who(event), resumed_because=_why(event))
        axes = "" if state else axes
        is_taken_up = event.kind == OPENED or (is_taken_up and not state)
        if event.kind == GUARDED:
            last_sign = _ended(event, last_sign)
        elif event.kind not in OF_OTHERS and not is_taken_up:
            last_sign = event
    return tuple(found if unended is None else [*found, unended])


def _ended(guarded: Event, last_sign: Event | None) -> Event | None:
    """Return the end of a process as its stop guard saw it, where that is later than what the process wrote last."""
    seen = guarded.detail.get("stopped_utc")
    if last_sign is None or not isinstance(seen, str):
        return last_sign
    seen_utc = datetime.fromisoformat(seen)
    return replace(guarded, utc=seen_utc) if last_sign.utc < seen_utc <= guarded.utc else last_sign


def _begun(stands: Standstill) -> Interruption:
    return Interruption(stands.what, stands.began_utc, None, stands.by, stands.reason, axes=stands.axes)


def _axes(safe: Event) -> str:
    positions = safe.detail.get("positions_deg")
    known_deg = {name: float(degrees) for name, degrees in positions.items()} if isinstance(positions, dict) else {}
    failures, in_doubt = (
        list(map(str, found)) if isinstance(found := safe.detail.get(key), list) else []
        for key in ("failures", "in_doubt")
    )
    unknown = found if isinstance(found := safe.detail.get("unknown"), dict) else {}
    return axes_in_words(known_deg, failures, in_doubt, {str(name): str(why) for name, why in unknown.items()})


def notes_in(events: Iterable[Event]) -> tuple[Note, ...]:
    """Return what people wrote down and what a reader should know of: changes answered for, dwells taken back."""
    return tuple(Note(event.utc, _who(event), text) for event in events if (text := _word(event)))


def made_again_in(events: Iterable[Event]) -> tuple[MadeAgain, ...]:
    """Return every move that was made again. Its reason begins with the axis, as every sentence of motion does."""
    reasons = ((event.utc, *_why(event).partition(": ")) for event in events if event.kind == MADE_AGAIN)
    return tuple(MadeAgain(utc, axis, found) for utc, axis, _, found in reasons)


def missing_in(events: Iterable[Event]) -> tuple[str, ...]:
    """Return what the laboratory lacked for a calibration when the run began."""
    return tuple(
        str(sentence) for event in events if event.kind == "readiness" for sentence in _listed(event, "engineering")
    )


def step_s(event: Event) -> float:
    """By how much the clock was set, where the event tells of that: it and all behind it are stamped so much ahead."""
    return float(str(event.detail.get("step_s", 0.0))) if event.kind == "clock_step" else 0.0


def on_one_clock(events: Iterable[Event]) -> Iterator[Event]:
    """Yield the events with the dates that count, which every page and every result tells.

    The clock with which a run began counts, and the time that passed by a clock that nobody sets: what was done to the
    clock in the night moves no date.
    """
    ahead_s = 0.0
    for event in events:
        ahead_s += step_s(event)
        yield replace(event, utc=event.utc - timedelta(seconds=ahead_s)) if ahead_s else event


def dwells_on_one_clock(dwells: Iterable[DwellRecord], events: Sequence[Event]) -> Iterator[DwellRecord]:
    """Yield the dwells with the end that counts, as :func:`on_one_clock`."""
    if not any(step_s(event) for event in events):
        yield from dwells
        return
    raw_and_counting = zip(events, on_one_clock(events), strict=True)
    ahead = {_key(raw): raw.utc - counting.utc for raw, counting in raw_and_counting if raw.kind == "dwell"}
    for dwell in dwells:
        behind = ahead.get((dwell.step, dwell.attempt, dwell.epoch), timedelta())
        yield replace(dwell, ended_utc=dwell.ended_utc - behind)


def _key(event: Event) -> tuple[object, object, object]:
    return event.detail["step"], event.detail["attempt"], event.detail["epoch"]


def clock_sentence(set_by_s: float) -> str:
    """Return what is told of a clock that was set during the run."""
    return (
        f"the computer's clock was set by {set_by_s:+.1f} s during the run; its dates are those of the clock "
        "with which it began and of the time that passed since"
    )


def clock_words(events: Iterable[Event]) -> tuple[str, ...]:
    """Return a sentence for every time that the computer's clock was set during the run."""
    return tuple(_word(event) for event in events if event.kind == "clock_step")


def _word(event: Event) -> str:
    match event.kind:
        case "clock_step":
            return clock_sentence(step_s(event))
        case "common_mode" | "seam" | "stray_motion":
            return str(event.detail.get("text", ""))
        case "held_up":
            return str(event.detail.get("text", ""))
        case "note":
            return str(event.detail.get("text", ""))
        case "terminal" | "lease" | "at_rest":
            return str(event.detail.get("text", ""))
        case "ack":
            return f"acknowledged. {event.detail.get('text', '')}".strip()
        case "override":
            return f"went on over changes: {'; '.join(map(str, _listed(event, 'differences')))}: {_why(event)}"
        case "dropped":
            return f"{event.detail.get('sensor')} was dropped: {_why(event)}"
        case "quarantined":
            return _why(event)
        case "voided":
            moved = "; the package was moved" if event.detail.get("remounted") else ""
            return f"{len(_listed(event, 'dwells'))} dwells taken back: {_why(event)}{moved}"
    return ""


def _listed(event: Event, key: str) -> list[object]:
    found = event.detail.get(key, [])
    return list(found) if isinstance(found, list) else []


def _who(event: Event) -> str:
    return str(event.detail.get("by") or event.detail.get("operator") or "")


def _why(event: Event) -> str:
    return str(event.detail.get("reason") or "")
