"""The audit trail as a reader of the report needs it: interruptions, notes and who the devices said they are."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from procedures.report.view import Interruption, Note
from procedures.run.records import Event

GOING = "running"
AT_WORK = ("running", "checking")
NOT_GOING = ("paused", "held", "stopped", "tripped", "aborted", "failed", "interrupted")


def interruptions_in(events: Sequence[Event]) -> tuple[Interruption, ...]:
    """Every stretch between leaving ``running`` and coming back to it.

    A process that died wrote no state: its journal was opened again while it still said that the run was going.
    """
    found: list[Interruption] = []
    open_one: Interruption | None = None
    for before, event in _with_previous(events):
        state = _state(event)
        if open_one is None and state in NOT_GOING:
            open_one = Interruption(state, event.utc, None, _who(event), _why(event))
        elif open_one is None and before is not None and _died(event, before[1]):
            open_one = Interruption("interrupted", before[0].utc, None, _who(event), _why(event) or "the process ended")
        elif open_one is not None and state == GOING:
            found.append(Interruption(open_one.what, open_one.began_utc, event.utc, open_one.by, open_one.reason))
            open_one = None
    return tuple(found if open_one is None else [*found, open_one])


def notes_in(events: Iterable[Event]) -> tuple[Note, ...]:
    """What the operator wrote down."""
    return tuple(
        Note(event.utc, _who(event), str(event.detail.get("text", ""))) for event in events if event.kind == "note"
    )


def identities_in(events: Iterable[Event]) -> Mapping[str, str]:
    """Device name to its latest answer to the question who it is."""
    return {
        str(name): str(identity)
        for event in events
        if event.kind == "identities"
        for name, identity in event.detail.items()
    }


def _with_previous(events: Sequence[Event]) -> Iterator[tuple[tuple[Event, str] | None, Event]]:
    """Every event with the one before it and the state that was reached by then."""
    state, before = "", None
    for event in events:
        yield (None if before is None else (before, state)), event
        state, before = _state(event) or state, event


def _died(event: Event, state: str) -> bool:
    return event.kind == "opened" and state in AT_WORK


def _state(event: Event) -> str:
    return str(event.detail.get("to", "")) if event.kind == "state" else ""


def _who(event: Event) -> str:
    return str(event.detail.get("by") or event.detail.get("operator") or "")


def _why(event: Event) -> str:
    return str(event.detail.get("reason") or "")
