"""The course of a run so far: what a state, a count or an end needs, kept from one event of its journal to the next."""

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

from procedures.journal.audit.audit_trail import step_s
from procedures.journal.audit.line_figures import LineTally
from procedures.journal.header import RunHeader
from procedures.journal.status.standing import RunStatus, derived_state, end_at_the_latest, end_at_this_pace, reason_now
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import QUARANTINED, Key, keys_in
from procedures.plan.plan import Expectation
from procedures.records.dwells import Event
from procedures.records.progress import OPENED_ANEW
from procedures.records.states import GOING, STANDING_STILL, State


class Course:
    """Takes the events of a journal in their order; an event and a status cost the same however long the run is."""

    def __init__(self, run_dir: Path, header: RunHeader) -> None:
        """Before the first event. Raises: PlanError where the plan of ``header`` is of another version."""
        plan, factor = header.plan, header.time_factor
        self.sequence = 0
        """Of the newest event that was taken."""
        self._run_dir = run_dir
        self._design: Mapping[int, int] = {dwell.step: dwell.replication for dwell in plan.design_dwells}
        """Step to its replication."""
        self._replications = plan.replications
        self._expected = Expectation(plan.expected.p50_s / factor, plan.expected.p90_s / factor)
        self._each_s = self._expected.p50_s / max(len(self._design), 1)
        self._state = State.PLANNED
        self._since: Event | None = None
        """The newest event of a state, with the date that counts."""
        self._accepted: dict[Key, int] = {}
        """Dwells that count, to their step."""
        self._counted: dict[int, int] = {}
        """Design steps to the number of their dwells that count."""
        self._seen = 0
        """Dwells, whether they count or not."""
        self._last_dwell: Event | None = None
        self._paced = 0
        """Accepted since the state was entered."""
        self._last_try = ""
        """What the last attempt to open lost lines found, since the state was entered."""
        self._lines = LineTally()
        self._ahead_s = 0.0
        """Of the dates that count is the computer's clock, since it was set."""

    def take(self, stamped: Event) -> None:
        self.sequence = stamped.sequence
        self._ahead_s += step_s(stamped)
        event = replace(stamped, utc=stamped.utc - timedelta(seconds=self._ahead_s)) if self._ahead_s else stamped
        match event.kind:
            case "state":
                self._state, self._since, self._paced = State(str(event.detail["to"])), event, 0
                self._last_try = ""
            case _ if event.kind == OPENED_ANEW:
                self._last_try = str(event.detail["failed"])
            case "dwell":
                self._last_dwell = event
                self._seen += 1
                if event.detail["accepted"]:
                    step, attempt, epoch = (int(str(event.detail[part])) for part in ("step", "attempt", "epoch"))
                    self._count((step, attempt, epoch))
                    self._paced += 1
            case _ if event.kind in (VOIDED, QUARANTINED):
                for key in keys_in(event):
                    self._discount(key)
        self._lines.take(event)

    def status(self, *, is_alive: bool) -> RunStatus:
        """Return where the run stands; ``is_alive``: whether a living process runs it."""
        since = self._since
        state = derived_state(self._state, is_alive=is_alive)
        done = len(self._counted)
        last = next((step for step in reversed(self._accepted.values()) if step in self._design), None)
        reason, by = ("", "") if since is None else (str(since.detail.get(key, "")) for key in ("reason", "by"))
        reason = reason_now(reason, self._last_try)
        is_stop = state in STANDING_STILL
        left = len(self._design) - done
        ends = self._eta_utc(left) if state in GOING else None
        return RunStatus(
            run=str(self._run_dir),
            state=state,
            dwells_done=done,
            dwells_planned=len(self._design),
            eta_utc=ends,
            held_by=(reason or str(state)) if state in (State.HELD, State.TRIPPED) else None,
            lines=self._lines.figures(),
            reason=reason if is_stop else "",
            requested_by=by if is_stop else "",
            replication=0 if last is None else self._design[last],
            replications=self._replications,
            rejected=self._seen - len(self._accepted),
            state_sequence=0 if since is None else since.sequence,
            since_utc=None if since is None else since.utc,
            clock_set_by_s=self._ahead_s,
            late_utc=None if ends is None else end_at_the_latest(ends, self._expected, left, len(self._design)),
        )

    def _count(self, key: Key) -> None:
        step = key[0]
        if key not in self._accepted and step in self._design:
            self._counted[step] = self._counted.get(step, 0) + 1
        self._accepted[key] = step

    def _discount(self, key: Key) -> None:
        step = self._accepted.pop(key, None)
        if step is not None and step in self._counted:
            self._counted[step] -= 1
            if not self._counted[step]:
                del self._counted[step]

    def _eta_utc(self, left: int) -> datetime | None:
        """Return when it ends by the clock as it stands now: whoever reads it looks at that one."""
        if self._since is None:
            return None
        ahead = timedelta(seconds=self._ahead_s)
        if self._last_dwell is None or self._last_dwell.sequence < self._since.sequence:
            return self._since.utc + ahead + timedelta(seconds=left * self._each_s)
        return ahead + end_at_this_pace(self._since.utc, self._last_dwell.utc, self._paced, left, self._each_s)
