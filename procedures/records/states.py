"""The states of a run, as one table; the diagram in ``docs/run-states.md`` is drawn from it.

``interrupted`` is derived: a run whose journal says it is active but whose owner is dead. It is written down only by
the resume that takes the run over.
"""

from dataclasses import dataclass
from enum import StrEnum

from procedures.errors import ExitStatus, RequestError


class State(StrEnum):
    """Where a run stands."""

    PLANNED = "planned"
    CHECKING = "checking"
    RUNNING = "running"
    PAUSED = "paused"
    HELD = "held"
    TRIPPED = "tripped"
    STOPPED = "stopped"
    ABORTED = "aborted"
    INTERRUPTED = "interrupted"
    FINISHED = "finished"
    FAILED = "failed"
    CLOSED = "closed"


@dataclass(frozen=True, slots=True)
class Transition:
    """One line of the table."""

    source: State
    target: State
    cause: str


def _from(sources: tuple[State, ...], target: State, cause: str) -> tuple[Transition, ...]:
    return tuple(Transition(source, target, cause) for source in sources)


ACTIVE = (State.PLANNED, State.CHECKING, State.RUNNING, State.PAUSED, State.HELD)
"""A living process owns a run in one of these."""
RESUMABLE = (State.STOPPED, State.INTERRUPTED, State.TRIPPED, State.ABORTED)
GOING = (State.CHECKING, State.RUNNING)
STANDING_STILL = (
    State.PAUSED,
    State.HELD,
    State.TRIPPED,
    State.STOPPED,
    State.ABORTED,
    State.FAILED,
    State.CLOSED,
)
"""There is a reason for each, or somebody who asked for it."""
ANSWERED_FOR = (State.TRIPPED, State.ABORTED)
"""Resumed only with a name and a reason: something happened that a person should have looked at."""

TRANSITIONS: tuple[Transition, ...] = (
    Transition(State.PLANNED, State.CHECKING, "the command"),
    Transition(State.CHECKING, State.RUNNING, "rig and check set are sound"),
    Transition(State.RUNNING, State.PAUSED, "pause, after the dwell"),
    Transition(State.PAUSED, State.RUNNING, "continue"),
    *_from(GOING, State.HELD, "suspect dwell, interlock, lost link or position"),
    Transition(State.HELD, State.CHECKING, "continue, or it cleared itself"),
    Transition(State.HELD, State.RUNNING, "continue, or it cleared itself"),
    *_from((*GOING, State.PAUSED, State.HELD), State.TRIPPED, "a person must look"),
    *_from(ACTIVE, State.STOPPED, "stop, after the dwell; SIGTERM, now"),
    *_from(ACTIVE, State.ABORTED, "abort, now"),
    *_from(ACTIVE, State.FAILED, "cannot go on"),
    *_from(ACTIVE, State.INTERRUPTED, "its owner died"),
    *_from(RESUMABLE, State.CHECKING, "resume"),
    *_from(RESUMABLE, State.CLOSED, "close, for good"),
    Transition(State.RUNNING, State.FINISHED, "last dwell"),
    Transition(State.FINISHED, State.STOPPED, "void or redo"),
)

EXIT_STATUS = {
    State.FINISHED: ExitStatus.DONE,
    State.FAILED: ExitStatus.FAILED,
    State.HELD: ExitStatus.HELD,
    State.TRIPPED: ExitStatus.HELD,
    State.STOPPED: ExitStatus.ABORTED,
    State.ABORTED: ExitStatus.ABORTED,
}
"""What the shell sees when the process that ran a run ends in this state."""

_ALLOWED = frozenset((line.source, line.target) for line in TRANSITIONS)


def require_transition(source: State, target: State) -> None:
    """Raise RequestError unless the table has this line."""
    if (source, target) not in _ALLOWED:
        allowed = ", ".join(line.target for line in TRANSITIONS if line.source is source) or "none, it is an end"
        raise RequestError(f"run: cannot go from {source} to {target} (allowed: {allowed}); nothing was changed")


def is_unasked(state: State, by: str) -> bool:
    """Return whether a run stands still though nobody asked for it: an alarm, until somebody knows of it."""
    return state in (State.HELD, State.TRIPPED, State.FAILED, State.INTERRUPTED) or (
        state in (State.STOPPED, State.ABORTED) and not by
    )


def state_sentence(reason: str, by: str) -> str:
    """Return why a run is in a state and who or what asked for it, in one phrase; empty where neither is known."""
    return f"{reason} (asked for by {by})" if reason and by else f"asked for by {by}" if by else reason


def diagram() -> str:
    """Return the text of ``docs/run-states.md``: a Mermaid diagram of the table and the same lines in words."""
    pairs = "\n".join(f"    {line.source} --> {line.target}: {line.cause}" for line in TRANSITIONS)
    rows = "\n".join(f"| {line.source} | {line.target} | {line.cause} |" for line in TRANSITIONS)
    return (
        "# The states of a run\n\n"
        "Drawn from `procedures/records/states.py`; write it anew with `python -m procedures.records.states`.\n\n"
        f"```mermaid\nstateDiagram-v2\n    [*] --> {State.PLANNED}\n{pairs}\n```\n\n"
        f"| from | to | by |\n|---|---|---|\n{rows}\n\n"
        f"`resume` takes {', '.join(RESUMABLE)}; {' and '.join(ANSWERED_FOR)} only with a name and a reason. "
        "`interrupted` is derived: the journal says the run is active, but no process runs it; one that corrects its "
        "journal does not.\n"
        "Neither stop nor abort skips the standstill check and the journal's last line; where not every axis is known "
        "to stand, or an order may still move one, the run is tripped instead. A terminal that closes ends nothing.\n"
    )


if __name__ == "__main__":
    from pathlib import Path

    Path("docs/run-states.md").write_text(diagram(), encoding="utf-8")
