"""What is new in the journal of a run, read as it grows: the one way in which screens and status look at a run.

Everything that a state, a count or an end needs is kept from one look to the next, so that a look costs what has
happened since, not what the run is long. The bell is ``journal.count``, which is written after every commit: where its
time of modification has not changed, nothing is read.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from procedures.errors import JournalError
from procedures.journal.audit.audit_trail import step_s
from procedures.journal.audit.line_figures import LineTally
from procedures.journal.encoding import FLOAT, channels_of, decode_dwell
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.status.standing import RunStatus, derived_state, end_at_the_latest, end_at_this_pace, reason_now
from procedures.journal.storage import JOURNAL_FILE, CommittedCount
from procedures.journal.taken_away import require_not_taken_away
from procedures.journal.time_stamps import SETTLED_NS
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import QUARANTINED, Key, keys_in
from procedures.plan.plan import Expectation
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import OPENED_ANEW
from procedures.records.states import GOING, STANDING_STILL, State
from rig.clock import Clock, SystemClock


@dataclass(frozen=True, slots=True)
class FollowedDwell:
    """A dwell with what its samples come to, and without them."""

    record: DwellRecord
    """Its readings are left out. Accepted as it was committed; a later event may take it back."""
    mean: Mapping[str, float]
    """Channel to the mean of its samples, in the channel's unit; not a number where one was overloaded."""
    standard_deviation: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class News:
    """What happened since the look before, and where the run stands now."""

    events: tuple[Event, ...]
    dwells: tuple[FollowedDwell, ...]
    status: RunStatus
    sequence: int
    """Of the newest event: what a request that was made after seeing it refers to."""
    is_alive: bool
    """A living process runs the run."""


@dataclass(slots=True)
class _Known:
    """Everything so far that a look needs."""

    state: State = State.PLANNED
    since: Event | None = None
    """The newest event of a state, with the date that counts."""
    accepted: dict[Key, int] = field(default_factory=dict)
    """Dwells that count, to their step."""
    seen: int = 0
    """Dwells, whether they count or not."""
    last_dwell: Event | None = None
    paced: int = 0
    """Accepted since the state was entered."""
    last_try: str = ""
    """What the last attempt to open lost lines found, since the state was entered."""
    lines: LineTally = field(default_factory=LineTally)
    ahead_s: float = 0.0
    """Of the dates that count is the computer's clock, since it was set."""

    def take(self, stamped: Event) -> None:
        self.ahead_s += step_s(stamped)
        event = replace(stamped, utc=stamped.utc - timedelta(seconds=self.ahead_s)) if self.ahead_s else stamped
        match event.kind:
            case "state":
                self.state, self.since, self.paced = State(str(event.detail["to"])), event, 0
                self.last_try = ""
            case _ if event.kind == OPENED_ANEW:
                self.last_try = str(event.detail["failed"])
            case "dwell":
                self.last_dwell = event
                self.seen += 1
                if event.detail["accepted"]:
                    step, attempt, epoch = (int(str(event.detail[part])) for part in ("step", "attempt", "epoch"))
                    self.accepted[step, attempt, epoch] = step
                    self.paced += 1
            case _ if event.kind in (VOIDED, QUARANTINED):
                for key in keys_in(event):
                    self.accepted.pop(key, None)
        self.lines.take(event)


class Follower:
    """Follows one run; :meth:`poll` is cheap where nothing happened."""

    def __init__(self, run_dir: Path, *, with_dwells: bool = True, clock: Clock | None = None) -> None:
        self._run_dir = run_dir
        self._with_dwells = with_dwells
        self._clock = clock or SystemClock()
        self._count = CommittedCount(run_dir / JOURNAL_FILE).path
        self._rung_ns = -1
        self._sequence = self._number = 0
        self._known = _Known()
        self._design: Mapping[int, int] = {}
        """Step to its replication."""
        self._replications = 0
        self._each_s = 0.0
        self._expected = Expectation(0.0, 0.0)
        self._reader: JournalReader | None = None

    def poll(self) -> News:
        """Return what is new. Raises: JournalError."""
        require_not_taken_away(self._run_dir)
        is_alive = is_owned(self._run_dir)  # asked first: what a dying owner wrote last is then read below
        events: tuple[Event, ...] = ()
        dwells: tuple[FollowedDwell, ...] = ()
        if self._has_rung():
            reader = self._reader or self._open()
            events = tuple(reader.events(after=self._sequence))
            if self._with_dwells:
                dwells = tuple(self._followed(reader))
            for event in events:
                self._known.take(event)
            if events:
                self._sequence = events[-1].sequence
        return News(events, dwells, self._status(is_alive), self._sequence, is_alive)

    def close(self) -> None:
        if self._reader is not None:
            self._reader.close()

    def _open(self) -> JournalReader:
        self._reader = JournalReader.open(self._run_dir)
        plan = self._reader.header.plan
        self._design = {dwell.step: dwell.replication for dwell in plan.design_dwells}
        self._replications = plan.replications
        factor = self._reader.header.time_factor
        self._expected = Expectation(plan.expected.p50_s / factor, plan.expected.p90_s / factor)
        self._each_s = self._expected.p50_s / max(len(self._design), 1)
        return self._reader

    def _has_rung(self) -> bool:
        try:
            now_ns = os.stat(self._count).st_mtime_ns
        except FileNotFoundError:
            return True  # a journal of which only the one file is left is read whole every time
        if now_ns == self._rung_ns:
            return False
        age_ns = self._clock.now_utc().timestamp() * 1e9 - now_ns
        self._rung_ns = now_ns if age_ns > SETTLED_NS else -1
        return True

    def _followed(self, reader: JournalReader) -> list[FollowedDwell]:
        found = []
        for number, text, samples, digest in reader.stored_dwells(after=self._number):
            try:
                record = decode_dwell(text, None, digest)
            except JournalError as error:
                raise JournalError(
                    f"{reader.path}: {error}; it was left as it is; calrig status names what is damaged"
                ) from None
            mean, deviation = _figures(channels_of(text), samples)
            found.append(FollowedDwell(record, mean, deviation))
            self._number = number
        return found

    def _status(self, is_alive: bool) -> RunStatus:
        known, since = self._known, self._known.since
        state = derived_state(known.state, is_alive=is_alive)
        counted = self._design.keys() & set(known.accepted.values())
        done, last = len(counted), next((step for step in reversed(known.accepted.values()) if step in counted), None)
        reason, by = ("", "") if since is None else (str(since.detail.get(key, "")) for key in ("reason", "by"))
        reason = reason_now(reason, known.last_try)
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
            lines=known.lines.figures(),
            reason=reason if is_stop else "",
            requested_by=by if is_stop else "",
            replication=0 if last is None else self._design[last],
            replications=self._replications,
            rejected=known.seen - len(known.accepted),
            state_sequence=0 if since is None else since.sequence,
            since_utc=None if since is None else since.utc,
            clock_set_by_s=known.ahead_s,
            late_utc=None if ends is None else end_at_the_latest(ends, self._expected, left, len(self._design)),
        )

    def _eta_utc(self, left: int) -> datetime | None:
        """Return when it ends by the clock as it stands now: whoever reads it looks at that one."""
        known = self._known
        if known.since is None:
            return None
        ahead = timedelta(seconds=known.ahead_s)
        if known.last_dwell is None or known.last_dwell.sequence < known.since.sequence:
            return known.since.utc + ahead + timedelta(seconds=left * self._each_s)
        return ahead + end_at_this_pace(known.since.utc, known.last_dwell.utc, known.paced, left, self._each_s)


def _figures(channels: list[tuple[str, int]], samples: bytes) -> tuple[dict[str, float], dict[str, float]]:
    values_v, first = np.frombuffer(samples, dtype=FLOAT), 0
    mean, deviation = {}, {}
    for channel, count in channels:
        part = values_v[first : first + count]
        first += count
        mean[channel] = float(part.sum() / count) if count else float("nan")
        spread = part - mean[channel]
        deviation[channel] = float(np.sqrt(spread.dot(spread) / (count - 1))) if count > 1 else float("nan")
    return mean, deviation
