"""Where a run stands, read from its journal by any process at any time."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from procedures.journal.guard_record import guard_told, read_guard_record
from procedures.journal.journal_reader import JournalReader
from procedures.journal.line_figures import LineFigures, lines_in
from procedures.journal.owner import is_owned
from procedures.records.states import ACTIVE, State

_GOING = (State.CHECKING, State.RUNNING)
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
    guard: str = ""
    """What the stop guard did since the run was last taken up; no part of the JSON form."""

    def to_document(self) -> dict[str, Any]:
        """The JSON form of ``calrig status --json``."""
        return {
            "run": self.run,
            "state": str(self.state),
            "dwells_done": self.dwells_done,
            "dwells_planned": self.dwells_planned,
            "eta_utc": None if self.eta_utc is None else self.eta_utc.isoformat(timespec="seconds"),
            "held_by": self.held_by,
        }


def status(run_dir: Path) -> RunStatus:
    """Raises: JournalError."""
    owned = is_owned(run_dir)
    with JournalReader.open(run_dir) as reader:
        plan = reader.header.plan
        state = derived_state(reader.state(), is_alive=owned)
        done = len(reader.accepted_steps() & {dwell.step for dwell in plan.design_dwells})
        last = reader.last_event("state")
        reason = str(last.detail.get("reason", "")) if last is not None else ""
        left = len(plan.design_dwells) - done
        each_s = plan.expected.p50_s / max(len(plan.design_dwells), 1)
        return RunStatus(
            run=str(run_dir),
            state=state,
            dwells_done=done,
            dwells_planned=len(plan.design_dwells),
            eta_utc=_eta_utc(reader, left, each_s) if state in _GOING else None,
            held_by=(reason or str(state)) if state in (State.HELD, State.TRIPPED) else None,
            lines=lines_in(reader.events()),
            guard="" if (guarded := read_guard_record(run_dir)) is None else guard_told(guarded),
        )


def derived_state(written: State, *, is_alive: bool) -> State:
    """Return the state that the journal tells, or interrupted where it says active and no process owns the run."""
    return State.INTERRUPTED if written in ACTIVE and not is_alive else written


def _eta_utc(reader: JournalReader, left: int, planned_s: float) -> datetime | None:
    """From the wall-clock pace since the check set of this epoch, blended with the plan's."""
    running, dwell = reader.last_event("state"), reader.last_event("dwell")
    if running is None:
        return None
    if dwell is None or dwell.sequence < running.sequence:
        return running.utc + timedelta(seconds=left * planned_s)
    done = sum(1 for event in reader.events("dwell") if event.sequence > running.sequence and event.detail["accepted"])
    elapsed_s = (dwell.utc - running.utc).total_seconds()
    each_s = (_PLAN_WEIGHT * planned_s + elapsed_s) / (_PLAN_WEIGHT + done)
    return dwell.utc + timedelta(seconds=left * each_s)
