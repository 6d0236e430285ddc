"""Where a run stands, as a value."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from math import sqrt
from typing import Any

from procedures.journal.audit.line_figures import LineFigures
from procedures.plan.plan import Expectation
from procedures.records.progress import Progress
from procedures.records.states import ACTIVE, STANDING_STILL, State, state_sentence

_PLAN_WEIGHT = 5.0
"""So many dwells of the plan's pace count beside those measured."""


@dataclass(frozen=True, slots=True)
class RunStatus:
    """``calrig status``."""

    run: str
    state: State
    dwells_done: int
    """Accepted design dwells."""
    dwells_planned: int
    eta_utc: datetime | None
    """None where nothing goes on."""
    held_by: str | None
    """What holds or tripped the run."""
    lines: Mapping[str, LineFigures]
    """What happened on every line, as last recorded; no part of the JSON form."""
    reason: str = ""
    """Why it stands still; empty where it goes on."""
    requested_by: str = ""
    """Who or what asked for that; empty where the run itself decided."""
    replication: int = 0
    """Of the newest design dwell that counts; 0 before the first."""
    replications: int = 0
    rejected: int = 0
    """Dwells that do not count."""
    state_sequence: int = 0
    """Of the event with which it entered the state as written: what a request refers to."""
    since_utc: datetime | None = None
    """When it entered the state as written, by the clock with which the run began."""
    clock_set_by_s: float = 0.0
    """By how much the computer's clock was set during the run, all told."""
    late_utc: datetime | None = None
    """Later than this it ends in one case of ten; None where nothing goes on."""

    @property
    def why(self) -> str:
        """Why it stands still and who or what asked for it, in one phrase."""
        return state_sentence(self.reason, self.requested_by)

    def to_document(self) -> dict[str, Any]:
        """Return the JSON of ``calrig status --json``.

        A run that stands still also says why and who asked for it; one that a process runs how far it is within its
        replications, and what a request to it refers to.
        """
        is_explained = self.state in STANDING_STILL or (self.state is State.INTERRUPTED and self.reason)
        still = {"reason": self.reason, "asked_by": self.requested_by} if is_explained else {}
        return {
            "run": self.run,
            "state": str(self.state),
            "dwells_done": self.dwells_done,
            "dwells_planned": self.dwells_planned,
            "eta_utc": None if self.eta_utc is None else self.eta_utc.isoformat(timespec="seconds"),
            "held_by": self.held_by,
            **still,
            **({"clock_set_by_s": round(self.clock_set_by_s, 3)} if self.clock_set_by_s else {}),
            **(self._going() if self.state in ACTIVE else {}),
        }

    def _going(self) -> dict[str, Any]:
        return {
            "replication": self.replication,
            "replications": self.replications,
            "rejected": self.rejected,
            "eta_p90_utc": None if self.late_utc is None else self.late_utc.isoformat(timespec="seconds"),
            "state_sequence": self.state_sequence,
        }


def derived_state(written: State, *, is_alive: bool) -> State:
    """Return the state that the journal tells, or interrupted where it says active and no process owns the run."""
    return State.INTERRUPTED if written in ACTIVE and not is_alive else written


def reason_now(reason: str, last_try: str) -> str:
    """Return why a run stands still, and what keeps its lines shut by now where that is another thing.

    ``last_try``: what the last attempt to open them found; empty before the first.
    """
    return f"{reason}; at the last try to open the lines: {last_try}" if last_try not in reason else reason


def end_at_this_pace(since: datetime, last: datetime, done: int, left: int, planned_s: float) -> datetime:
    """Return when it ends by the wall-clock pace since the check set of this epoch, blended with the plan's."""
    each_s = (_PLAN_WEIGHT * planned_s + (last - since).total_seconds()) / (_PLAN_WEIGHT + done)
    return last + timedelta(seconds=left * each_s)


def end_at_the_latest(ends: datetime, expected: Expectation, left: int, planned: int) -> datetime:
    """Return when a run ends that is as late as one in ten: the spread that is left of the plan's."""
    spread_s = (expected.p90_s - expected.p50_s) * sqrt(left / max(planned, 1))
    return ends + timedelta(seconds=spread_s)


def progress_of(event: str, status: RunStatus, message: str = "") -> Progress:
    """Return what an observer is told of a run that another process runs."""
    return Progress(
        event=event,
        state=status.state,
        dwells_done=status.dwells_done,
        dwells_planned=status.dwells_planned,
        replication=status.replication,
        replications=status.replications,
        rate_per_min=None,
        eta_utc=status.eta_utc,
        message=message,
        requested_by=status.requested_by,
        rejected=status.rejected,
        late_utc=status.late_utc,
    )
