"""What every part of a running engine works with: plan, rig, log, waits, watch; and how a run is held."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import Protocol

from procedures.journal.audit.line_figures import KIND as LINKS
from procedures.journal.audit.line_figures import link_detail
from procedures.journal.sidecar.live import LiveFile
from procedures.plan.plan import Plan
from procedures.records.states import State
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import PROCESS, Ending, RunEnds, decision, defect_of, ending_of
from procedures.run.judgement.alarm import Alarm
from procedures.run.progress_log import ProgressLog
from procedures.run.services import RunServices
from procedures.run.steering import Steering
from procedures.run.watch.disk_space import needed_bytes
from procedures.run.watch.process_health import PROCESS_EVERY, growth, process_figures
from procedures.run.watch.watch import Watch
from procedures.run.watch.watchdogs import Watchdogs
from rig.clock import VirtualClock
from rig.crash_points import CrashPoint, crash_point

LOOK_S = 1.0
"""Rig seconds between two looks around where a run stands still."""


class LooksAround(Protocol):
    """Who looks around where a run stands still (:mod:`procedures.run.vigil`)."""

    def look(self, *, waits_for_person: bool = False, held_by: str = "") -> None: ...
    def require_trust(self) -> None: ...


@dataclass
class RunContext:
    """One process working through one plan."""

    plan: Plan
    rig: OpenRig
    progress_log: ProgressLog
    wait: Steering
    watch: Watch
    services: RunServices
    explain: Callable[[], None]
    """Write the page that says why the run stands still."""
    watchdogs: Watchdogs
    live: LiveFile
    is_attended: bool
    """False in virtual time without a person's clock: whatever needs the outside world fails the run instead."""
    vigil: LooksAround = field(init=False)
    """Of the epoch."""
    looked_s: float = -inf
    """When the vigil looked last, rig seconds."""
    began_s: float = field(init=False)
    dwells: int = 0
    """Judged by this process."""
    first_figures: dict[str, float] = field(default_factory=dict)
    """Of the process, at its first look at itself."""
    before: BaseException | None = field(default_factory=sys.exception)
    """What whoever began the run was handling: no error of the run."""

    def __post_init__(self) -> None:
        self.began_s = self.rig.clock.monotonic_s()

    def ending_of(self, error: BaseException) -> Ending:
        """Return how the run ends by an error, and what people asked for since it was met."""
        self.wait.hear()
        return ending_of(error, self.before, self.wait, self.progress_log.folder)

    def defect_of(self, error: BaseException) -> BaseException | None:
        """Return the error that calrig did not foresee, or None."""
        return defect_of(error, self.before)

    def is_decided(self, error: BaseException) -> bool:
        """Return whether the run was ending when this failed: then nothing is tried again."""
        return decision(error, self.before) is not None

    def count_dwell(self) -> None:
        """Count a dwell; after every hundred the process looks at itself.

        Raises: RunEnds where it has grown too far.
        """
        self.dwells += 1
        if self.dwells % PROCESS_EVERY:
            return
        now = process_figures()
        self.progress_log.event("process", now)
        self.record_lines()
        self.first_figures = self.first_figures or now
        grown = growth(self.first_figures, now)
        if grown:
            raise RunEnds(
                Ending(
                    State.STOPPED,
                    f"this process has grown: {grown}; calrig resume goes on in a fresh one",
                    cause=PROCESS,
                )
            )

    def record_lines(self) -> None:
        """Record what happened on every line since it was opened."""
        self.progress_log.event(LINKS, link_detail(self.rig.link_counts()))

    def stop_if_requested(self) -> None:
        if (ending := self.wait.behind_the_dwell) is not None:
            raise RunEnds(ending)

    def wait_unless_stopped(self, duration_s: float) -> None:
        """Where there is no dwell to finish first."""
        self.wait(duration_s)
        self.stop_if_requested()

    def stand(self, duration_s: float) -> None:
        """Let rig time pass while nothing moves and nothing is read: a stop takes effect, and everything is looked at.

        Every second; in virtual time once at its end. Raises: RunEnds, TrustLost, RigError, WaitEnded.
        """
        clock = self.rig.clock
        ends_s = clock.monotonic_s() + duration_s
        slice_s = inf if isinstance(clock, VirtualClock) else LOOK_S
        while True:
            self.wait_unless_stopped(min(ends_s - clock.monotonic_s(), slice_s))
            if clock.monotonic_s() - self.looked_s >= LOOK_S:
                self.vigil.look()
                self.looked_s = clock.monotonic_s()
            if clock.monotonic_s() >= ends_s:
                return

    def requests(self) -> None:
        """Between dwells: stop, pause and the longest duration take effect here."""
        self.wait.look()
        self.stop_if_requested()
        limit_s, spent_s = self.plan.max_duration_s, self.rig.clock.monotonic_s() - self.began_s
        if limit_s is not None and spent_s > limit_s:
            raise RunEnds(Ending(State.STOPPED, f"[stop] max_duration_s = {limit_s:g} s has passed", "procedure"))
        if self.wait.pause is not None and self.progress_log.state is State.RUNNING:
            request = self.wait.pause
            self.progress_log.enter(State.PAUSED, request.text, request.by)
            crash_point(CrashPoint.PAUSED)
            self.live.tell("waiting", waiting_for="a person to say continue", pending_request="")
            by = self._stand_until(lambda: self.wait.pause is None, lambda: self.vigil.look(waits_for_person=True))
            self.progress_log.enter(State.RUNNING, by=by)
            self.vigil.require_trust()

    def hold(self, alarm: Alarm, is_over: Callable[[], bool] = lambda: False) -> None:
        """Stand still until ``is_over``, or until a person says continue where the alarm asks for one."""
        before, is_asking = self.progress_log.state, alarm.response == "ask"
        self.enter_held(alarm.cause, alarm.reason)
        self.live.tell("waiting", waiting_for="a person to say continue" if is_asking else "its cause to be over")
        self.wait.continued = None
        by = self._stand_until(
            lambda: self.wait.continued is not None if is_asking else is_over(),
            lambda: self.vigil.look(waits_for_person=is_asking, held_by=alarm.cause),
        )
        self.progress_log.enter(before, by=by)
        self.vigil.require_trust()

    def enter_held(self, cause: str, reason: str) -> None:
        """Enter ``held``. Raises: RunEnds where nobody could ever clear it."""
        self.progress_log.enter(State.HELD, reason, cause=cause)
        crash_point(CrashPoint.HELD)
        self.explain()
        if not self.is_attended:
            raise RunEnds(Ending(State.FAILED, reason, cause=cause))

    def room_bytes(self, dwells: int) -> tuple[float, float]:
        """Return what is free on the disk of the run, and what so many more dwells need. Raises: StorageFailed."""
        return self.services.free_bytes(self.progress_log.folder), needed_bytes(self.plan, dwells)

    def has_passed(self, alarm: Alarm, dwells: int) -> bool:
        """Return whether what holds a run until it is over is over."""
        return not self.watch.goes_on(alarm, *self.room_bytes(dwells))

    def rest(self, duration_s: float) -> None:
        """Rest, with an eye on requests alone: the lines are lost."""
        self._stand_until(lambda: False, lambda: None, duration_s)

    def _stand_until(self, is_over: Callable[[], bool], look: Callable[[], None], limit_s: float = inf) -> str:
        """Rest and look around until ``is_over`` or for ``limit_s``; returns who said continue."""
        rested_s = looked_s = 0.0
        while rested_s < limit_s:
            self.stop_if_requested()
            if rested_s >= looked_s:
                look()
                if is_over():
                    break
                looked_s = rested_s + LOOK_S
            rested_s += self.wait.rest()
            if isinstance(self.rig.clock, VirtualClock):
                self.rig.clock.sleep(LOOK_S)
        self.stop_if_requested()
        return self.wait.continued.by if self.wait.continued is not None else ""
