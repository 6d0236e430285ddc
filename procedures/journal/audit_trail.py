"""The audit trail as a reader of the report needs it: interruptions, notes and who the devices said they are."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from procedures.records.dwells import Event

GOING = "running"
OF_OTHERS = ("opened", "note", "ack", "voided", "override", "stop_guard")
"""Events that the process which ran the run did not write last, or need not have: they say nothing of its life."""
NOT_GOING = ("paused", "held", "stopped", "tripped", "aborted", "failed", "interrupted", "closed")


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


@dataclass(frozen=True)
class Note:
    """A line of the audit trail that a reader of the report should see."""

    utc: datetime
    by: str
    text: str


def interruptions_in(events: Sequence[Event]) -> tuple[Interruption, ...]:
    """Return every stretch between leaving ``running`` and coming back to it, under the name it began with.

    A process that died wrote nothing: the resume that took the run over wrote ``interrupted``, and the stretch began
    with the last event of that process: what people wrote afterwards is none.
    """
    found: list[Interruption] = []
    open_one: Interruption | None = None
    last_sign: Event | None = None
    for event in events:
        state = _state(event)
        if open_one is None and state in NOT_GOING:
            began = last_sign if last_sign is not None and state == "interrupted" else event
            open_one = Interruption(state, began.utc, None, _who(event), _why(event))
        elif open_one is not None and state == GOING:
            found.append(replace(open_one, ended_utc=event.utc))
            open_one = None
        elif open_one is not None and state == "checking" and _who(event):
            open_one = replace(open_one, resumed_by=_who(event), resumed_because=_why(event))
        last_sign = last_sign if event.kind in OF_OTHERS else event
    return tuple(found if open_one is None else [*found, open_one])


def notes_in(events: Iterable[Event]) -> tuple[Note, ...]:
    """Return what people wrote down and what a reader should know of: changes answered for, dwells taken back."""
    return tuple(Note(event.utc, _who(event), text) for event in events if (text := _word(event)))


def missing_in(events: Iterable[Event]) -> tuple[str, ...]:
    """Return what the laboratory lacked for a calibration when the run began."""
    return tuple(
        str(sentence) for event in events if event.kind == "readiness" for sentence in _listed(event, "engineering")
    )


def clock_steps_s(events: Iterable[Event], before: int) -> float:
    """How far the computer's clock was set, all told, before an event: stamps from then on are that much ahead.

    The clock with which a run began counts, and the time that passed by a clock that nobody sets: what was done to the
    clock in the night moves no date of a result.
    """
    steps = (event for event in events if event.kind == "clock_step" and event.sequence < before)
    return sum(float(str(event.detail.get("step_s", 0.0))) for event in steps)


def clock_words(events: Iterable[Event]) -> tuple[str, ...]:
    """Return a sentence for every time that the computer's clock was set during the run."""
    return tuple(_word(event) for event in events if event.kind == "clock_step")


def _word(event: Event) -> str:
    match event.kind:
        case "clock_step":
            step_s = float(str(event.detail.get("step_s", 0.0)))
            return (
                f"the computer's clock was set by {step_s:+.1f} s during the run; its dates are those of the clock "
                "with which it began and of the time that passed since"
            )
        case "common_mode":
            return str(event.detail.get("text", ""))
        case "held_up":
            return str(event.detail.get("text", ""))
        case "note":
            return str(event.detail.get("text", ""))
        case "terminal" | "lease":
            return str(event.detail.get("text", ""))
        case "ack":
            return f"acknowledged. {event.detail.get('text', '')}".strip()
        case "override":
            return f"went on over changes: {'; '.join(map(str, _listed(event, 'differences')))}: {_why(event)}"
        case "dropped":
            return f"{event.detail.get('sensor')} was dropped: {_why(event)}"
        case "voided":
            moved = "; the package was moved" if event.detail.get("remounted") else ""
            return f"{len(_listed(event, 'dwells'))} dwells taken back: {_why(event)}{moved}"
    return ""


def _listed(event: Event, key: str) -> list[object]:
    found = event.detail.get(key, [])
    return list(found) if isinstance(found, list) else []


def identities_in(events: Iterable[Event]) -> Mapping[str, str]:
    """Device name to its latest answer to the question who it is."""
    return {
        str(name): str(identity)
        for event in events
        if event.kind == "identities"
        for name, identity in event.detail.items()
    }


def _state(event: Event) -> str:
    return str(event.detail.get("to", "")) if event.kind == "state" else ""


def _who(event: Event) -> str:
    return str(event.detail.get("by") or event.detail.get("operator") or "")


def _why(event: Event) -> str:
    return str(event.detail.get("reason") or "")
