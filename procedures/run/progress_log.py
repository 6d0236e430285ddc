"""What the engine says of itself: the run's state, its audit trail, and what observers are told, always in step."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from procedures.journal.emergency import EmergencyCopy, emergency_copy
from procedures.journal.journal import Journal
from procedures.journal.requests.spool import Taken
from procedures.journal.voids import KIND as VOIDED
from procedures.lease.keeper import LeaseNews
from procedures.records.dwells import DwellRecord
from procedures.records.progress import LEASE, LEASE_LOST, Progress, RunObserver
from procedures.records.states import State, is_unasked, require_transition, state_sentence
from procedures.run.progress import Pace
from rig.clock import Clock

TERMINAL = "terminal"
"""Kind of an event, and what observers are told."""
TERMINAL_CLOSED = "the terminal was closed; the run goes on"


class ProgressLog:
    """Writes to the journal first and tells the observer afterwards."""

    def __init__(
        self, journal: Journal, clock: Clock, observer: RunObserver, state: State, counts: tuple[int, int, int, int]
    ) -> None:
        self._journal = journal
        self._clock = clock
        self._observer = observer
        self.state = state
        self.dwells_done, self._rejected, self.dwells_planned, self._replications = counts
        self._replication = 0
        self._pace: Pace | None = None
        self.unsaved: DwellRecord | None = None
        """Measured, but refused by the disk."""

    def enter(self, state: State, reason: str = "", by: str = "", cause: str = "", *, is_said: bool = False) -> None:
        """Go to another state. ``is_said``: :meth:`announce` has told of it.

        Raises: RequestError where the table does not allow it, StorageFailed.
        """
        require_transition(self.state, state)
        if is_unasked(state, by) and not is_said:
            self.announce(state, reason, by, cause)
            is_said = True
        detail = {"from": self.state, "to": state, "by": by, "reason": reason}
        self.event("state", detail | ({"cause": cause} if cause else {}))
        self.state = state
        if not is_said:
            self.announce(state, reason, by, cause)

    def announce(self, state: State, reason: str, by: str, cause: str = "", motion: str = "") -> None:
        """Tell of a state that is being entered, before the disk is asked: a full one must not keep it from people."""
        self.tell("state", state_sentence(reason, by), state, by, cause, motion)

    def event(self, kind: str, detail: Mapping[str, object]) -> None:
        """Write one line of the audit trail."""
        self._journal.append_event(kind, detail, self._clock)

    def require_journal(self) -> None:
        """Require that the files of the journal are those of the run. Raises: StorageFailed."""
        self._journal.require_as_written()

    def terminal_closed(self) -> None:
        """Nobody looks at the screen any more; that ends nothing."""
        self.event(TERMINAL, {"text": TERMINAL_CLOSED})
        self.tell(TERMINAL, TERMINAL_CLOSED)

    def tell_lease(self, news: LeaseNews) -> Mapping[str, object]:
        """Tell people what became of the lease of a device; return what is to be written of it."""
        self.tell(LEASE_LOST if news.is_lost else LEASE, news.text)
        return {"text": news.text, "lost": news.is_lost}

    def request(self, taken: Taken) -> None:
        """Record a request that was taken; a note and an acknowledgement are events of their own."""
        request = taken.request
        if request is None or taken.complaint:
            self.event("request", taken.detail())
            self.tell("refused", taken.complaint)
            return
        if request.kind in ("note", "ack"):
            self.event(request.kind, {name: value for name, value in request.to_document().items() if name != "kind"})
        else:
            self.event("request", taken.detail())
        if request.kind in ("ack", "continue"):
            self.tell("ack", f"acknowledged by {request.by}")

    def commit(self, record: DwellRecord) -> DwellRecord:
        """Store a judged dwell and tell of it."""
        self.unsaved = record
        stored = self._journal.commit_dwell(record, self._clock)
        self.unsaved = None
        counts = stored.accepted and stored.purpose == "design"
        self.dwells_done += counts
        self._rejected += not stored.accepted
        self._replication = stored.replication or self._replication
        if self._pace is not None:
            self._pace.done += counts
        self.tell("dwell" if stored.accepted else "rejected", "; ".join(stored.reasons))
        return stored

    def emergency_copy(self, second_folder: Path, cause: str) -> EmergencyCopy:
        """Copy what the open journal still gives; never raises for a disk."""
        return emergency_copy(self._journal, second_folder, cause, self.unsaved, self._clock)

    @property
    def state_sequence(self) -> int:
        """Of the event with which the run entered its state."""
        return self._journal.state_sequence

    @property
    def folder(self) -> Path:
        """Of the run."""
        return self._journal.path.parent

    def void_dwells(self, dwells: Sequence[DwellRecord], detail: Mapping[str, object]) -> None:
        """Void accepted dwells: they count no more."""
        self.event(VOIDED, detail)
        taken_back = sum(dwell.accepted and dwell.purpose == "design" for dwell in dwells)
        self.dwells_done -= taken_back
        if self._pace is not None:
            self._pace.done = max(self._pace.done - taken_back, 0)
        self.tell("void", str(detail["reason"]))

    def begin_pace(self, planned_s: float, spread_s: float = 0.0) -> None:
        """Count the rate from now on.

        ``planned_s``: rig seconds a design dwell by the plan. ``spread_s``: from p50 to p90. A person looks at another
        clock than the rig's where twins live faster: rate and end are told by that one.
        """
        factor = self._clock.factor
        self._pace = Pace(planned_s / factor, self._now_s(), spread_s=spread_s / factor)

    def _now_s(self) -> float:
        """Return the seconds as a person's clock counts them."""
        return self._clock.monotonic_s() / self._clock.factor

    def tell(
        self, event: str, message: str, state: State | None = None, by: str = "", cause: str = "", motion: str = ""
    ) -> None:
        """``state``: the one that is being entered; otherwise the present one."""
        now_s, pace = self._now_s(), self._pace
        left = self.dwells_planned - self.dwells_done
        ends = None if pace is None else self._clock.now_utc() + pace.remaining(left, now_s)
        self._observer.on_event(
            Progress(
                event=event,
                state=state or self.state,
                dwells_done=self.dwells_done,
                dwells_planned=self.dwells_planned,
                replication=self._replication,
                replications=self._replications,
                rate_per_min=None if pace is None else pace.rate_per_min(now_s),
                eta_utc=ends,
                message=message,
                requested_by=by,
                cause=cause,
                motion=motion,
                rejected=self._rejected,
                late_utc=None if pace is None or ends is None else ends + pace.spread(left, self.dwells_planned),
            )
        )
