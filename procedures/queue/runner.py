"""What starts what is due: one step looks at the queue and at the world, and does at most one thing.

The runner holds no device. Whatever it is about to do stands in the queue's record first, and what a killed runner
left is found again from the record, from the lock that the started process inherited, and from the run's journal. So
it may be killed between any two lines: no item is started twice, and none is lost.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Protocol

from procedures.errors import RequestError
from procedures.queue.hands import heed, require_uses_to_be_seen, unknown_uses
from procedures.queue.state import AT_WORK, Arming, Attestation, Item, ItemState, Queue
from procedures.queue.store import Change, QueueStore
from procedures.queue.words import awaited_sentence
from procedures.records.states import ACTIVE, State
from rig.clock import Clock
from rig.local_time import at_both

WAITING_NOTICE_S = 600.0
"""What is due waits for somebody, for the rig or for what is mounted: people are told after so long."""
SHUTDOWN = "signal SIGTERM"
"""Who asked for a stop where the machine was shut down in order."""


@dataclass(frozen=True, slots=True)
class Look:
    """What is seen of a started item."""

    is_alive: bool
    """A process of it lives, or somebody runs its run."""
    run: Path | None
    state: State | None = None
    """As the journal tells it; INTERRUPTED where nobody runs it and it has not ended."""
    reason: str = ""
    by: str = ""
    has_ended: bool = False
    """Its run has ended unfinished and the rig is given back; what still lives of it delivers and tells people."""
    was_busy: bool = False
    """Nothing began because somebody else has the rig."""
    said: str = ""
    """The last words of the process."""
    last_utc: datetime | None = None
    """The time of the last line of its journal."""


class World(Protocol):
    """Everything outside the queue's record."""

    def boot(self) -> str:
        """Return what is another after every start of the machine."""

    def check(self, item: Item) -> Sequence[str]:
        """Return what speaks against starting the item now."""

    def busy(self, item: Item) -> str:
        """Return who has its rig; empty where nobody has."""

    def start(self, item: Item, by: str) -> None:
        """Start its run in a process that outlives this one."""

    def resume(self, item: Item, by: str, reason: str) -> None:
        """Resume its run in a process that outlives this one."""

    def look(self, item: Item) -> Look:
        """Return what is seen of it."""

    def is_stopped_by_something(self, item: Item) -> bool:
        """Return whether every axis of its rig has a guard or a watchdog."""

    def note(self, run: Path, attestation: Attestation) -> None:
        """Write into the run who said what is mounted."""


@dataclass
class Runner:
    """Of one queue; only one process has it."""

    store: QueueStore
    world: World
    clock: Clock
    tell: Callable[[str], None]
    """For whoever looks at its words."""
    ring: Callable[[str, str, str], None] = lambda _title, _word, _text: None
    """For people who are not there: what does not happen tonight; title, word and sentences."""
    _waits_since: tuple[str, float] | None = None
    """What is waited for, and since when."""
    _announced: set[str] = field(default_factory=set)
    _rung: set[str] = field(default_factory=set)
    _unseen: str = ""
    """Why somebody may have had the rig and left no mark, until the queue's record has it."""

    def step(self) -> Queue:
        """Do what is next; returns the queue as it was found. Raises: ProcedureError."""
        self._disarm_for_what_is_unseen()
        # Also while another runs: people hear that a window is over when it is, not when that run has ended.
        queue, now_utc = heed(self.store), self.clock.now_utc()
        self._tell_of_use(queue)
        for item in queue.in_state(ItemState.WAITING):
            if item.is_late(now_utc):
                if self._add(queue, "expired", {"item": item.number}) and queue.is_armed(self.world.boot(), now_utc):
                    self._ring(item, "expired", "its window was over before it could start")
                return queue
        at_work = queue.in_state(*AT_WORK)
        if at_work:
            self._follow(queue, at_work[0])
        elif queue.is_armed(self.world.boot(), now_utc) and not queue.in_state(ItemState.UNDECIDED):
            self._begin_next(queue, now_utc)
        else:
            self._waits_since = None
        return queue

    def _disarm_for_what_is_unseen(self) -> None:
        """Disarm where a use would leave no mark now, or would have left none at an earlier look.

        A stop by another account is seen by its mark alone. Raises: ProcedureError; then nothing is started.
        """
        if not self._unseen and not (why := self._why_unseen()):
            return
        self._unseen = self._unseen or why

        def recorded(queue: Queue) -> Change | None:
            return ("unseen", {"why": self._unseen}) if queue.arming is not None else None

        self.store.change(recorded)
        self._unseen = ""

    def _why_unseen(self) -> str:
        try:
            require_uses_to_be_seen()
        except RequestError as error:
            return str(error)
        return ""

    def _follow(self, queue: Queue, item: Item) -> None:
        look = self.world.look(item)
        if look.run is not None and item.state is ItemState.STARTING:
            if queue.attestation is not None and not item.run:
                self.world.note(look.run, queue.attestation)
            self._add(queue, "began", {"item": item.number, "run": str(look.run)})
            return
        if look.is_alive and not look.has_ended:
            return
        if look.run is None:
            reason = look.said or "its process ended before a run began"
            detail = {"item": item.number, "busy": look.was_busy, "reason": reason}
            if self._add(queue, "unbegun", detail) and not look.was_busy:
                self._ring(item, "not begun", reason)
            return
        is_to_go_on = self._is_of_a_cold_start(item, look) and self._is_armed_but_for_the_start(queue)
        behind = self._clock_behind(queue, look.last_utc) if is_to_go_on else ""
        if is_to_go_on and not behind:
            self._resume_itself(queue, item)
        else:
            state = look.state or State.INTERRUPTED
            ended = State.INTERRUPTED if state in ACTIVE else state
            behind = f"not resumed: {behind}" if behind else ""
            reason = "; ".join(filter(None, (look.reason, behind)))
            detail = {"item": item.number, "state": str(ended), "reason": reason}
            if self._add(queue, "ended", detail) and ended is State.INTERRUPTED and item.boot != self.world.boot():
                anew = "the machine was started anew, and nobody else could tell"
                self._ring(item, str(ended), "; ".join(filter(None, (anew, behind))))

    def _is_of_a_cold_start(self, item: Item, look: Look) -> bool:
        """Whether the run is resumed by itself: once, where the rig file allows it and something stops every axis."""
        if item.boot == self.world.boot() or item.resumed_itself or not item.resumes_after_power_cut:
            return False
        is_cut = look.state is State.INTERRUPTED or look.state in ACTIVE
        is_shut_down = look.state is State.STOPPED and look.by == SHUTDOWN
        return (is_cut or is_shut_down) and self.world.is_stopped_by_something(item)

    def _begin_next(self, queue: Queue, now_utc: datetime) -> None:
        due = queue.in_state(ItemState.RESUMING) or queue.in_state(ItemState.WAITING)
        if not due or (item := due[0]).is_early(now_utc):
            return
        if item.state is ItemState.WAITING and (awaited := awaited_sentence(queue, item)):
            self._tell_once(f"item {item.number} {awaited}")
            self._wait(item, awaited)
            return
        owner = self.world.busy(item)
        behind = self._clock_behind(queue, None)
        if words := f"waits for the rig, which is in use by {owner}" if owner else behind and f"waits: {behind}":
            self._tell_once(f"item {item.number} {words}")
            self._wait(item, words)
            return
        self._waits_since = None
        if item.state is ItemState.RESUMING:
            self._begin(queue, item, "resume", lambda _arming: self.world.resume(item, item.decided_by, item.reason))
            return
        if refused := list(self.world.check(item)):
            if self._add(queue, "checked", {"item": item.number, "refused": refused}):
                self._ring(item, "refused", "\n".join(refused))
            return
        now_utc = self.clock.now_utc()
        if not item.is_late(now_utc) and queue.is_armed(self.world.boot(), now_utc):  # the check took its time
            self._begin(queue, item, "start", lambda arming: self.world.start(item, arming.by))

    def _begin(self, seen: Queue, item: Item, kind: str, begin: Callable[[Arming], None]) -> None:
        """Record a beginning, then begin while nobody can change the queue: a disarm is before it, or after it.

        What was recorded and is not begun, as somebody disarmed or a sleep of the machine lies between, is found at
        the next look as a start of which there is nothing: it needs a decision.
        """
        if not self._add(seen, kind, {"item": item.number, "boot": self.world.boot()}):
            return

        def unless_disarmed(queue: Queue) -> None:
            now_utc = self.clock.now_utc()
            is_late = kind == "start" and item.is_late(now_utc)
            is_armed = queue.is_armed(self.world.boot(), now_utc) and not self._is_used(queue)
            if queue.arming is not None and is_armed and not is_late:
                begin(queue.arming)

        self.store.hold(unless_disarmed)

    def _resume_itself(self, seen: Queue, item: Item) -> None:
        """Resume after a cold start, as :meth:`_begin` begins: the word that was given before it still stands."""
        detail = {"item": item.number, "boot": self.world.boot(), "by_itself": True}
        if not self._add(seen, "resume", detail):
            return

        def unless_disarmed(queue: Queue) -> None:
            is_armed = self._is_armed_but_for_the_start(queue) and not self._is_used(queue)
            if queue.arming is not None and is_armed:
                self.world.resume(item, queue.arming.by, "cold start")

        self.store.hold(unless_disarmed)

    def _is_armed_but_for_the_start(self, queue: Queue) -> bool:
        """Whether nobody has taken back what was armed before the machine was started anew, and it is not over."""
        return queue.arming is not None and self.clock.now_utc() <= queue.arming.until_utc

    def _is_used(self, queue: Queue) -> bool:
        """Whether somebody had the rig outside the queue since this look began, or may have had it unseen."""
        self._unseen = self._unseen or self._why_unseen()
        return bool(self._unseen or unknown_uses(self.store.folder, queue))

    def _clock_behind(self, queue: Queue, last_utc: datetime | None) -> str:
        """Say that this machine's clock is before what has happened: no hour that was armed can be told by it."""
        now_utc = self.clock.now_utc()
        happened = max(filter(None, (queue.last_line_utc(), last_utc)), default=now_utc)
        if now_utc >= happened:
            return ""
        return (
            f"the clock of this machine shows {at_both(now_utc, to_the_second=True)}, which is before what it has "
            f"recorded already ({at_both(happened, to_the_second=True)}); set the clock"
        )

    def _tell_of_use(self, queue: Queue) -> None:
        """Tell and ring, once, that a use from outside, or that none could be seen, has disarmed the queue and what
        waits does not begin.
        """
        waiting = queue.in_state(ItemState.RESUMING, ItemState.WAITING)
        by_act = ("arm", "disarm", "unseen")
        kinds = [event.kind for event in queue.events if event.kind in by_act or event.detail.get("disarms")]
        if not waiting or not kinds or kinds[-1] not in ("used", "unseen"):
            return
        text = f"is not begun: the queue is disarmed: {queue.disarmed_because}"
        if text not in self._rung:
            self._rung.add(text)
            self._tell_once(f"item {waiting[0].number} {text}")
            self._ring(waiting[0], "disarmed", text)

    def _wait(self, item: Item, words: str) -> bool:
        """Ring once where the item has waited long for the same; returns whether it has."""
        text, now_s = f"item {item.number} {words}", self.clock.monotonic_s()
        if self._waits_since is None or self._waits_since[0] != text:
            self._waits_since = (text, now_s)
        is_long = now_s - self._waits_since[1] >= WAITING_NOTICE_S
        if is_long and text not in self._rung:
            self._rung.add(text)
            self._ring(item, "waits", text)
        return is_long

    def _ring(self, item: Item, word: str, text: str) -> None:
        """Tell of an item that has no run which could tell it itself."""
        self.ring(item.title, word, f"Item {item.number} of the queue {self.store.folder.name}: {text}")

    def _add(self, seen: Queue, kind: str, detail: dict[str, object]) -> bool:
        """Record what was decided in view of a queue; False where somebody has changed it since."""
        is_added = False

        def unless_changed(queue: Queue) -> Change | None:
            nonlocal is_added
            is_added = queue.sequence == seen.sequence
            return (kind, detail) if is_added else None

        self.store.change(unless_changed)
        return is_added

    def _tell_once(self, text: str) -> None:
        if text not in self._announced:
            self._announced.add(text)
            self.tell(text)
