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
RESUMABLE = (State.STOPPED, State.INTERRUPTED, State.TRIPPED)
_WORKING = (State.CHECKING, State.RUNNING)

TRANSITIONS: tuple[Transition, ...] = (
    Transition(State.PLANNED, State.CHECKING, "the command"),
    Transition(State.CHECKING, State.RUNNING, "rig and check set are sound"),
    Transition(State.RUNNING, State.PAUSED, "pause, after the dwell"),
    Transition(State.PAUSED, State.RUNNING, "continue"),
    *_from(_WORKING, State.HELD, "suspect dwell, interlock, lost link or position"),
    Transition(State.HELD, State.CHECKING, "continue, or it cleared itself"),
    Transition(State.HELD, State.RUNNING, "continue, or it cleared itself"),
    *_from((*_WORKING, State.PAUSED, State.HELD), State.TRIPPED, "a person must look"),
    *_from((*_WORKING, State.PAUSED, State.HELD), State.STOPPED, "stop, after the dwell"),
    *_from(ACTIVE, State.ABORTED, "abort, now"),
    *_from(ACTIVE, State.FAILED, "cannot go on"),
    *_from(ACTIVE, State.INTERRUPTED, "its owner died"),
    *_from(RESUMABLE, State.CHECKING, "resume"),
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


def diagram() -> str:
    """Return the text of ``docs/run-states.md``: a Mermaid diagram of the table and the same lines in words."""
    pairs = "\n".join(f"    {line.source} --> {line.target}: {line.cause}" for line in TRANSITIONS)
    rows = "\n".join(f"| {line.source} | {line.target} | {line.cause} |" for line in TRANSITIONS)
    return (
        "# The states of a run\n\n"
        "Drawn from `procedures/records/states.py`; write it anew with `python -m procedures.records.states`.\n\n"
        f"```mermaid\nstateDiagram-v2\n    [*] --> {State.PLANNED}\n{pairs}\n```\n\n"
        f"| from | to | by |\n|---|---|---|\n{rows}\n\n"
        f"`resume` takes {', '.join(RESUMABLE)}. `interrupted` is derived: the journal says the run is active, but no "
        "process owns it.\nNeither stop nor abort skips the standstill check and the journal's last line.\n"
    )


if __name__ == "__main__":
    from pathlib import Path

    Path("docs/run-states.md").write_text(diagram(), encoding="utf-8")
