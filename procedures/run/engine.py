"""The engine: what is left of a plan, epoch by epoch, each step journalled before and after.

Whatever happens, the rig is brought to its safe state and the journal gets its last line:
* Between two epochs trust was lost: a link broke, an axis lost its home, the machine was suspended. The run is held,
  the lines are opened anew until they answer, and the next epoch homes and measures the check set, as a resume does.
* A fault that a device reports, and whatever a person must look at, trips the run: only a resume with a name and a
  reason takes it up again. In virtual time nobody is there: what needs the outside world fails it with the sentence.
* A disk that refuses the journal stops the run: it can be resumed when there is space.
"""

import os
import platform
import traceback
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from functools import partial

from procedures.errors import JournalError, StorageFailed
from procedures.journal.audit.known_devices import KnownDevices
from procedures.journal.emergency import EmergencyCopy
from procedures.journal.header import calrig_version
from procedures.journal.journal import Journal
from procedures.journal.journal_reader import JournalReader
from procedures.journal.location import location_of
from procedures.journal.requests.spool import Spool, Taken
from procedures.journal.sidecar.alert_record import EVENT as ALERTED
from procedures.journal.sidecar.alert_record import forget_outcomes, keep_outcomes, read_outcomes
from procedures.journal.sidecar.guard_record import EVENT as GUARDED
from procedures.journal.sidecar.guard_record import forget_guard_record, read_guard_record
from procedures.journal.sidecar.last_words import TAKES_NOTHING, forget_last_words, read_last_words, refusal
from procedures.journal.sidecar.live import LiveFile
from procedures.journal.sidecar.owner import owned_since
from procedures.plan.plan import Plan
from procedures.records.progress import OPENED_ANEW, RunObserver, SilentObserver
from procedures.records.states import ACTIVE, RESUMABLE, State, state_sentence
from procedures.run.context import RunContext
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import BROKEN_LINE, DEVICE, Ending, Outcome, RunEnds
from procedures.run.epoch import Epoch
from procedures.run.judgement.alarm import LINK, LOST, RECONNECT, TrustLost, lost_link
from procedures.run.judgement.history import History, read_history
from procedures.run.last_page import leave_last_page
from procedures.run.progress_log import ProgressLog
from procedures.run.pulse import RunPulse
from procedures.run.services import RunServices
from procedures.run.start_checks import open_lines, require_no_fault
from procedures.run.steering import Steering, signals_steer
from procedures.run.stop_page import explain
from procedures.run.watch.clock_watch import GapWatch
from procedures.run.watch.device_watch import DeviceWatch, TakesOver
from procedures.run.watch.safe_state import known_rest_deg, make_safe
from procedures.run.watch.silent_devices import silence_words
from procedures.run.watch.watch import Watch
from procedures.run.watch.watchdogs import Watchdogs
from rig.clock import Clock, SystemClock, VirtualClock
from rig.crash_points import CrashPoint, crash_point
from rig.errors import RequestRefused, RigError, WaitEnded
from rig.motion.last_resort import BY_GUARD, stop_by_guard

FIRST_PAUSE_S, LONGEST_PAUSE_S = 1.0, 60.0
"""Between two attempts to reach a rig that was lost."""
STOPPING, TO_STAND = "stopping", "every axis to stand"
"""A phase, and what it waits for."""
MOST_RESTARTS = 5
"""Without a new dwell between them; after that a person must look."""


@dataclass(frozen=True, slots=True)
class Start:
    """Who starts this process of a run, from where."""

    operator: str
    state: State = State.PLANNED
    reason: str = ""
    devices: KnownDevices = field(default_factory=KnownDevices)
    """As the journal tells; none in the first process."""
    takes_over: TakesOver | None = None


def run(
    plan: Plan,
    rig: OpenRig,
    journal: Journal,
    spool: Spool,
    start: Start,
    history: History | None = None,
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    services: RunServices | None = None,
) -> Outcome:
    """Work through what is left of ``plan``; the journal is closed when this returns.

    ``idle_clock`` is a person's; in virtual time, without one, nobody is there.
    Raises: nothing that a device, a disk or an operator can cause; a defect of ours passes on after the safe stop.
    """
    history, services = history or History((), 1, None, None), services or RunServices()
    progress_log = ProgressLog(
        journal, rig.clock, observer or SilentObserver(), start.state, _counts_so_far(plan, history)
    )
    watchdogs, person_clock = Watchdogs(rig, progress_log.event), idle_clock or SystemClock()
    takes_time = not isinstance(rig.clock, VirtualClock)
    live = LiveFile(progress_log.folder, person_clock, writes_phases=takes_time)
    gaps = GapWatch(rig.clock, lambda: {name: counts.silent for name, counts in rig.link_counts().items()})
    pulse = RunPulse(progress_log, services, gaps, live, watchdogs, rig.sign_of_life)
    steering = Steering(
        spool,
        rig.clock,
        person_clock,
        partial(_take_request, progress_log, live),
        pulse,
        progress_log.terminal_closed,
        lambda: progress_log.state_sequence,
    )
    watch = Watch(rig, services.run_limits, steering, progress_log.event, progress_log.tell)
    is_attended = idle_clock is not None or takes_time

    def tell_why() -> None:
        explain(progress_log.folder, positions_deg=known_rest_deg(rig), second_folder=services.second_folder)

    context = RunContext(plan, rig, progress_log, steering, watch, services, tell_why, watchdogs, live, is_attended)
    with signals_steer(steering):
        try:
            outcome = _closed(journal, _Engine(context, start, history))
        except BaseException:
            # A defect of ours: the rig is safe, the page tells of it, and it goes on its way.
            explain(progress_log.folder, second_folder=services.second_folder)
            if progress_log.state not in ACTIVE:
                services.ended()
            raise
        finally:
            live.remove()
            keep_outcomes(progress_log.folder, services.second_folder, pulse.unwritten_alerts)
        return leave_last_page(outcome, progress_log.folder, services, rig.clock)


def _take_request(progress_log: ProgressLog, live: LiveFile, taken: Taken) -> None:
    """Record it, and show what was asked until it is done."""
    progress_log.request(taken)
    if (request := taken.request) is not None and not taken.complaint and request.kind in ("pause", "continue", "stop"):
        live.tell(pending_request="" if request.kind == "continue" else f"{request.kind}, by {request.by}")


def _counts_so_far(plan: Plan, history: History) -> tuple[int, int, int, int]:
    """Return dwells of the design done, dwells rejected, dwells of the design planned, replications planned."""
    done = sum(dwell.accepted and dwell.purpose == "design" for dwell in history.dwells)
    rejected = sum(not dwell.accepted for dwell in history.dwells)
    return done, rejected, len(plan.design_dwells), plan.replications


def _closed(journal: Journal, engine: "_Engine") -> Outcome:
    """Work, then close the journal; where the disk refuses even that, everything is committed, and it is told."""
    outcome = None
    try:
        with closing(journal):
            outcome = engine.run()
    except JournalError as error:
        if outcome is None:
            raise
        if outcome.copy is not None:  # these files are nobody's any more
            return outcome
        sentence, cause = refusal(journal.path.parent, error)
        reasons = [outcome.reason] if outcome.reason else []
        return replace(outcome, reason="; ".join(_with(reasons, sentence)), cause=cause)
    return outcome


class _Engine:
    """One process of one run."""

    def __init__(self, context: RunContext, start: Start, history: History) -> None:
        self._context = context
        self._rig, self._progress_log, self._wait = context.rig, context.progress_log, context.wait
        self._start = start
        self._history = history
        self._is_open = True
        """Whether the lines are open, so that a device that is there can be reached."""

    def run(self) -> Outcome:
        defect: BaseException | None = None
        try:
            self._work()
            ending = Ending(State.FINISHED)
        except BaseException as error:  # noqa: BLE001  the rim: to the safe state and the journal; a defect goes on its way
            defect = self._context.defect_of(error)
            # First: out of memory, our own stops may not be sent.
            guard_heard = defect is not None and stop_by_guard(self._rig.axes)
            ending = self._context.ending_of(defect or error)
            ending = replace(ending, reason=ending.reason + (BY_GUARD if guard_heard else ""))
        outcome = self._end(ending, defect)
        if defect is not None:
            raise defect
        return outcome

    def _end(self, ending: Ending, defect: BaseException | None) -> Outcome:
        """Make the rig safe, then write the journal's last line; a failure of either is told, neither is skipped.

        A resume that failed before it began leaves the run as resumable as it was.
        """
        crash_point(CrashPoint.ENDING)
        decided_utc = self._rig.clock.now_utc()
        self._context.live.tell(STOPPING, waiting_for=TO_STAND)
        safe = make_safe(self._rig, self._context.plan, is_open=self._is_open)
        crash_point(CrashPoint.MADE_SAFE)
        state, reasons, cause = ending.state, [ending.reason] if ending.reason else [], ending.cause
        if needs_a_look := ending.fault_met or safe.cause:
            is_worse = cause in (DEVICE, BROKEN_LINE) and safe.cause
            state, cause = _without_safety(state), safe.cause if is_worse else cause or needs_a_look
            reasons = ending.requested(decided_utc)
        reasons += ending.met_in_words(last_stop_failed=bool(safe.failures))
        reasons += safe.reasons
        is_left_as_it_was = self._progress_log.state in RESUMABLE
        if not is_left_as_it_was or cause in TAKES_NOTHING:
            self._announce(state, "; ".join(reasons), ending.by, cause, safe.in_words)
        copy = EmergencyCopy()
        if cause in TAKES_NOTHING:  # the axes rest and people know: copying takes what time a bad disk takes
            copy = self._copied(cause)
            reasons[0] += copy.words
        in_words = state_sentence("; ".join(reasons), ending.by)
        try:
            if defect is not None:
                self._progress_log.event("defect", {"traceback": "".join(traceback.format_exception(defect))})
            if not is_left_as_it_was:
                self._context.watchdogs.disarm()
                self._context.record_lines()
                self._progress_log.event("safe", safe.detail())
                self._progress_log.enter(state, "; ".join(reasons), ending.by, cause, is_said=True)
        except StorageFailed as error:
            sentence, found = refusal(self._progress_log.folder, error)
            reasons = _with(reasons, sentence)
            if cause not in TAKES_NOTHING:
                self._announce(State.INTERRUPTED, "; ".join(reasons), "", found, safe.in_words)
                copy = self._copied(found)
                reasons[-1] += copy.words
            in_words = "; ".join(reasons)
            state, cause = State.INTERRUPTED, found
        done, planned = self._progress_log.dwells_done, self._progress_log.dwells_planned
        return Outcome(
            state,
            in_words,
            done,
            planned,
            cause,
            safe.positions_deg,
            copy.folder if state is State.INTERRUPTED else None,
        )

    def _copied(self, cause: str) -> EmergencyCopy:
        folder = self._context.services.second_folder
        return EmergencyCopy() if folder is None else self._progress_log.emergency_copy(folder, cause)

    def _announce(self, state: State, reason: str, by: str, cause: str, motion: str) -> None:
        with suppress(Exception):  # the rim: a screen that fails keeps no run from its last line
            self._progress_log.announce(state, reason, by, cause, motion)

    def _work(self) -> None:
        """Epochs, until nothing is left."""
        self._open_epoch()
        devices = DeviceWatch(self._start.devices, self._start.takes_over, self._progress_log.event)
        restarts = 0
        while True:
            known = self._progress_log.dwells_done
            try:
                try:
                    Epoch(self._context, self._history, devices).run()
                except (*LOST, RequestRefused) as error:
                    if self._context.is_decided(error):
                        raise
                    if isinstance(error, LOST):
                        alarm = lost_link(error)
                        raise TrustLost(alarm.cause, alarm.reason) from error
                    # A device that lost its home refuses every move, and to home it mends that; the answer of one that
                    # has its home, or says why it does not move, is changed by no repetition.
                    if self._has_home():
                        raise
                    raise TrustLost("home", str(error)) from error
                return
            except TrustLost as lost:
                restarts = 1 if self._progress_log.dwells_done > known else restarts + 1
                self._regain(lost, restarts)
                self._reread()
                self._open_epoch(lost.reason)

    def _has_home(self) -> bool:
        try:
            require_no_fault(self._rig.axes)
            return all(self._rig.axes[name].state().is_homed for name in self._context.plan.axes)
        except LOST as error:
            alarm = lost_link(error)
            raise TrustLost(alarm.cause, alarm.reason) from error

    def _open_epoch(self, regained: str = "") -> None:
        start = self._start
        opened = {"operator": start.operator, "reason": regained or start.reason, "epoch": self._history.epoch}
        process = {"pid": os.getpid(), "host": platform.node(), "calrig": calrig_version()}
        archive = {"archive": named} if (named := self._context.services.archive) else {}
        location = {"place": location_of(self._progress_log.folder)}
        self._progress_log.event("opened", opened | process | location | archive)
        if (guarded := read_guard_record(self._progress_log.folder)) is not None:
            self._progress_log.event(GUARDED, guarded)
            forget_guard_record(self._progress_log.folder)
        if not regained:
            second_folder = self._context.services.second_folder
            for outcome in read_outcomes(self._progress_log.folder, second_folder):
                self._progress_log.event(ALERTED, outcome)
            forget_outcomes(self._progress_log.folder, second_folder)
            # A stop that was meant for the process that died must not end the one that takes its run up.
            self._wait.discard_pending(owned_since(self._progress_log.folder))
            if start.state in ACTIVE and self._history.epoch > 1:
                self._enter_interrupted()
        self._progress_log.enter(State.CHECKING, "" if regained else start.reason, "" if regained else start.operator)
        crash_point(CrashPoint.EPOCH_OPENED)

    def _enter_interrupted(self) -> None:
        """Enter what became of the process before, in its own words where it left some: then people were told."""
        folder, second_folder = self._progress_log.folder, self._context.services.second_folder
        words = read_last_words(folder, second_folder)
        if words is not None and any(dwell.ended_utc > words.stopped_utc for dwell in self._history.dwells[-1:]):
            words = None  # of a time before somebody else took the run up
        reason, cause = ("the process ended without a last line", "") if words is None else (str(words), words.cause)
        self._progress_log.enter(State.INTERRUPTED, reason, cause=cause, is_said=words is not None)
        forget_last_words(folder, second_folder)

    def _regain(self, lost: TrustLost, restarts: int) -> None:
        """Held, the axes told to stop, until every line answers again. Raises: RunEnds, WaitEnded."""
        self._context.watchdogs.forget()
        self._context.live.tell(STOPPING, waiting_for=TO_STAND)
        safe = make_safe(self._rig, self._context.plan, is_over=False)
        self._progress_log.event("safe", safe.detail())
        self._context.record_lines()
        if self._progress_log.state is State.HELD:  # by what may be over by itself: this takes its place
            self._progress_log.enter(State.CHECKING)
        if restarts > MOST_RESTARTS:
            reason = f"{lost.reason}; lost {restarts} times without a dwell between"
            raise RunEnds(Ending(State.TRIPPED, reason, cause=lost.cause))
        if lost.cause not in RECONNECT:
            require_no_fault(self._rig.axes)
            self._progress_log.enter(State.HELD, lost.reason, cause=lost.cause)
            return
        self._context.live.tell("asking every device whether it answers")
        others = silence_words(self._rig, self._wait) if lost.cause == LINK else ""
        self._context.enter_held(lost.cause, f"{lost.reason}{others}")
        pause_s, last_error = FIRST_PAUSE_S, ""
        while True:
            self._context.live.tell("reconnecting", waiting_for="the lines to answer")
            self._context.rest(pause_s)
            try:
                self._is_open = False
                open_lines(self._rig, self._progress_log)
                self._is_open = True
                self._rig.identities()
            except RigError as error:
                if isinstance(error, WaitEnded):  # the stop guard heard it
                    raise
                if str(error) != last_error:
                    self._progress_log.event(OPENED_ANEW, {"failed": str(error)})
                    self._progress_log.tell(OPENED_ANEW, str(error))
                    # Nothing is read back for the page: where axes were left is what they are held against later.
                    explain(self._progress_log.folder, second_folder=self._context.services.second_folder)
                last_error, pause_s = str(error), min(2.0 * pause_s, LONGEST_PAUSE_S)
                continue
            self._progress_log.event(OPENED_ANEW, {"failed": ""})
            return

    def _reread(self) -> None:
        """Read again what was done: the journal is the truth."""
        with JournalReader.open(self._progress_log.folder) as reader:
            self._history = read_history(reader, self._context.plan)


def _with(reasons: list[str], sentence: str) -> list[str]:
    """Return reasons with one more, unless it stands there."""
    return reasons if any(sentence in reason for reason in reasons) else [*reasons, sentence]


def _without_safety(state: State) -> State:
    """Return the state of a run whose axes are not known to rest, or whose chamber refused: a person looks first."""
    return State.FAILED if state is State.FAILED else State.TRIPPED
