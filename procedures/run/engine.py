"""The engine: what is left of a plan, step by step, each one journalled before and after.

intent → move → arrival by read-back → settle → look, read, look → judge → commit. Whatever happens, the axes are
stopped and seen to stand still, and the journal gets its last line.

* A rejected dwell is measured again, at most ``retries`` times; then the run is held until a person says continue
  (which grants the retries anew), stop or abort. In virtual time nobody is there: the run fails with the sentence.
* A reading that a device garbled or did not answer voids the attempt: nothing is judged, the readouts are prepared
  again and the same attempt is repeated, at most ``retries`` times. Voids do not count as judged attempts, so a run
  that met them draws the same chance as one that did not.
* Any other failure of a device ends the run as ``failed``. A disk that refuses the journal stops it instead: it can
  be resumed when there is space again.
"""

import os
import platform
import traceback
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from itertools import count
from math import isfinite

from procedures.errors import ProcedureError, StorageFailed
from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Soak
from procedures.run.ending import STORAGE, Ending, Outcome, RunEnds
from procedures.run.header import calrig_version
from procedures.run.history import History, agenda, plateau_of, replications_before
from procedures.run.journal import Journal
from procedures.run.judge import Band, Limits, Measurement, judge
from procedures.run.measure import Announcement, OpenRig, measure, move
from procedures.run.progress import RunObserver, SilentObserver
from procedures.run.records import DwellRecord
from procedures.run.seam import compare
from procedures.run.soak import soak
from procedures.run.spool import Request, Spool
from procedures.run.states import ACTIVE, RESUMABLE, State
from procedures.run.steering import Steering, signals_steer
from procedures.run.trail import Trail
from rig.clock import Clock, SystemClock, VirtualClock
from rig.errors import DeviceNonsense, DeviceSilent, RigError, WaitEnded
from rig.motion import home_and_arrive, stop_all


@dataclass(frozen=True, slots=True)
class Start:
    """Who starts this epoch of a run, from where."""

    operator: str
    state: State = State.PLANNED
    reason: str = ""
    identities: dict[str, str] | None = None
    """As journalled by the epoch before; None in the first."""


def run(
    plan: Plan,
    rig: OpenRig,
    journal: Journal,
    spool: Spool,
    start: Start,
    history: History | None = None,
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
) -> Outcome:
    """Work through what is left of ``plan``; the journal is closed when this returns.

    Raises: nothing that a device, a disk or an operator can cause; a defect of ours passes on after the safe stop.
    """
    history = history or History((), 1, None, None)
    done = sum(dwell.accepted and dwell.purpose == "design" for dwell in history.dwells)
    counts = (done, len(plan.design_dwells), plan.replications)
    trail = Trail(journal, rig.clock, observer or SilentObserver(), start.state, counts)
    steering = Steering(spool, rig.clock, idle_clock or SystemClock(), trail.request)
    with signals_steer(steering), closing(journal):
        return _Engine(plan, rig, trail, steering, start, history).run()


class _Engine:
    """One epoch of one run."""

    def __init__(
        self, plan: Plan, rig: OpenRig, trail: Trail, steering: Steering, start: Start, history: History
    ) -> None:
        self._plan = plan
        self._rig = rig
        self._trail = trail
        self._wait = steering
        self._start = start
        self._history = history
        self._noise = history.noise()
        self._replications = replications_before(plan)
        self._plateau: Soak | None = None
        self._checks: dict[int, DwellRecord] = {}
        self._began_s = rig.clock.monotonic_s()

    def run(self) -> Outcome:
        defect: BaseException | None = None
        try:
            self._work()
            ending = Ending(State.FINISHED)
        except RunEnds as asked:
            ending = asked.ending
        except WaitEnded as asked_too:
            ending = Ending(State.ABORTED, str(asked_too), self._wait.abort.by if self._wait.abort else "")
        except StorageFailed as error:
            ending = Ending(State.STOPPED, str(error), cause=STORAGE)
        except (RigError, ProcedureError) as error:
            ending = Ending(State.FAILED, str(error))
        except KeyboardInterrupt:
            ending = Ending(State.ABORTED, "interrupted from the keyboard")
        except BaseException as error:  # noqa: BLE001  the rim: to the safe state and the journal, then on its way
            defect, ending = error, Ending(State.FAILED, f"a defect of calrig: {type(error).__name__}: {error}")
        outcome = self._end(ending, defect)
        if defect is not None:
            raise defect
        return outcome

    def _end(self, ending: Ending, defect: BaseException | None) -> Outcome:
        """Axes at rest first, then the journal's last line; a failure of either is told, neither is skipped.

        A resume that failed before it began leaves the run as resumable as it was.
        """
        state, reasons, cause = ending.state, [ending.reason] if ending.reason else [], ending.cause
        if state is State.STOPPED and self._trail.state is State.PLANNED:
            state = State.FAILED
        try:
            stop_all(self._rig.axes, self._rig.clock)
        except RigError as error:
            state, reasons = State.FAILED, [*reasons, str(error)]
        try:
            if defect is not None:
                self._trail.event("defect", {"traceback": "".join(traceback.format_exception(defect))})
            if self._trail.state not in RESUMABLE:
                self._trail.enter(state, "; ".join(reasons), ending.by, cause)
        except StorageFailed as error:
            state, reasons, cause = State.INTERRUPTED, list(dict.fromkeys([*reasons, str(error)])), STORAGE
        return Outcome(state, "; ".join(reasons), self._trail.dwells_done, self._trail.dwells_planned, cause)

    def _work(self) -> None:
        self._open_epoch()
        steps = agenda(self._plan.steps, self._history.accepted_steps)
        if steps:
            self._check_rig()
        for step in steps:
            if isinstance(step, Soak):
                self._soak(step)
            else:
                self._dwell(step)
        if self._trail.state is State.CHECKING:
            self._trail.enter(State.RUNNING)

    def _open_epoch(self) -> None:
        start = self._start
        opened = {"operator": start.operator, "reason": start.reason, "epoch": self._history.epoch}
        process = {"pid": os.getpid(), "host": platform.node(), "calrig": calrig_version()}
        self._trail.event("opened", opened | process)
        self._wait.discard_pending()
        if start.state in ACTIVE and self._history.epoch > 1:
            self._trail.enter(State.INTERRUPTED, "the process ended without a last line")
        self._trail.enter(State.CHECKING, start.reason, start.operator)

    def _check_rig(self) -> None:
        identities = dict(self._rig.identities())
        self._trail.event("identities", identities)
        known = self._start.identities
        if known is not None and known != identities:
            changed = [name for name in {**known, **identities} if known.get(name) != identities.get(name)]
            told = "; ".join(f"{name}: was {known.get(name)!r}, is {identities.get(name)!r}" for name in changed)
            raise RunEnds(Ending(State.TRIPPED, f"not the devices this run began with: {told}", cause="identity"))
        self._prepare_readouts()
        for name, readout in self._rig.readouts.items():
            self._trail.event("meter", {"readout": name, **readout.checks()})
        for name in self._plan.axes:
            home_and_arrive(self._rig.axes[name], self._rig.clock, self._wait)

    def _prepare_readouts(self) -> None:
        for readout in self._rig.readouts.values():
            readout.prepare()

    def _soak(self, step: Soak) -> None:
        self._boundary()
        self._trail.event("intent", {"step": step.step, "soak": step.environment, "setpoint_degc": step.setpoint_degc})
        self._rig.chance.announce(step.step, "soak", self._history.epoch, self._replications[step.step])
        self._trail.tell("soak", f"{step.environment} to {step.setpoint_degc:g} degC for {step.soak_s:g} s")
        degc = soak(self._rig.environments[step.environment], step, self._rig.clock, self._wait_unless_stopped)
        self._trail.event("soaked", {"step": step.step, "temperature_degc": degc})
        self._plateau = step

    def _wait_unless_stopped(self, duration_s: float) -> None:
        """During a soak there is no dwell to finish first."""
        self._wait(duration_s)
        self._stop_if_asked()

    def _dwell(self, dwell: Dwell) -> None:
        """Until the dwell is accepted or the run ends."""
        if dwell.purpose != "check" and self._trail.state is State.CHECKING:
            self._leave_checking()
        retries = self._plan.dwell.retries
        judged = 0 if dwell.purpose == "check" else self._history.attempts(dwell.step)
        granted = retries + 1 if judged <= retries else judged + retries + 1
        while True:
            self._boundary()
            judged += 1
            record = self._attempt(dwell, judged)
            if record.accepted:
                return
            if judged >= granted:
                self._hold(f"step {dwell.step}: rejected {judged} times: {'; '.join(record.reasons)}")
                granted = judged + retries + 1

    def _attempt(self, dwell: Dwell, attempt: int) -> DwellRecord:
        """Move, measure, judge, commit."""
        intent = {"step": dwell.step, "purpose": dwell.purpose, "attempt": attempt, "epoch": self._history.epoch}
        self._trail.event("intent", intent | {"targets_deg": dict(dwell.targets_deg)})
        move(self._rig, dwell, self._wait)
        clock = self._rig.clock
        started_utc, started_s = clock.now_utc(), clock.monotonic_s()
        measured = self._measured(dwell, self._announcement(dwell, attempt))
        reasons = judge(measured, self._limits(dwell), self._noise)
        record = DwellRecord(
            step=dwell.step,
            purpose=dwell.purpose,
            replication=dwell.replication,
            point=dwell.point,
            attempt=attempt,
            epoch=self._history.epoch,
            accepted=not reasons,
            reasons=reasons,
            targets_deg=dwell.targets_deg,
            measured_deg=_mean_position(measured),
            temperature_degc=_mean_temperature(measured),
            readings=measured.readings,
            started_utc=started_utc,
            ended_utc=clock.now_utc(),
            started_s=started_s,
            ended_s=clock.monotonic_s(),
            settle_s=measured.settle_s,
            sha256="",
        )
        self._learn(record)
        return self._trail.commit(record)

    def _measured(self, dwell: Dwell, announcement: Announcement) -> Measurement:
        for void in count(1):
            try:
                return measure(self._rig, self._plan, dwell, announcement, self._wait)
            except (DeviceNonsense, DeviceSilent) as error:
                detail = {"step": dwell.step, "attempt": announcement.attempt, "void": void, "reason": str(error)}
                self._trail.event("void", detail)
                self._trail.tell("void", str(error))
                if void > self._plan.dwell.retries:
                    raise
                self._prepare_readouts()
        raise AssertionError("unreachable: count never ends")

    def _learn(self, record: DwellRecord) -> None:
        """Later dwells are judged by accepted ones, in the order in which an uninterrupted run takes them."""
        if record.accepted and record.purpose == "check":
            self._checks[record.step] = record
        if record.accepted and (record.purpose != "check" or self._is_first_check_set):
            self._noise.learn(record.readings)

    @property
    def _is_first_check_set(self) -> bool:
        return self._history.first_check_epoch is None

    def _announcement(self, dwell: Dwell, attempt: int) -> Announcement:
        """A check set that is measured again has chance of its own, and the drift of the moment."""
        if dwell.purpose != "check":
            return Announcement(dwell.step, attempt, self._replications[dwell.step], "settle", "read")
        if self._is_first_check_set:
            return Announcement(dwell.step, attempt, self._replications[dwell.step], "settle", "check")
        epoch = self._history.epoch
        return Announcement(dwell.step, attempt, self._replications_so_far(), f"settle-{epoch}", f"check-{epoch}")

    def _replications_so_far(self) -> float:
        steps = agenda(self._plan.steps, self._history.accepted_steps)
        return next(
            self._replications[step.step] for step in steps if isinstance(step, Dwell) and step.purpose != "check"
        )

    def _limits(self, dwell: Dwell) -> Limits:
        plateau = self._plateau
        return Limits(
            targets_deg=dwell.targets_deg,
            tolerance_deg={name: self._rig.axes[name].arrival_tolerance_deg for name in dwell.targets_deg},
            max_noise_factor=self._plan.dwell.max_noise_factor,
            bands={} if plateau is None else {plateau.environment: Band(plateau.setpoint_degc, plateau.band_degc)},
        )

    def _leave_checking(self) -> None:
        """The check set is measured: was there a step since the one from the start?"""
        before = self._history.baseline
        if before:
            self._require_no_step(before)
        self._trail.enter(State.RUNNING)
        self._trail.begin_pace(self._plan.expected.p50_s / max(len(self._plan.design_dwells), 1))

    def _require_no_step(self, before: dict[int, DwellRecord]) -> None:
        plateau = plateau_of(self._plan.steps, min(before))
        if plateau != self._plateau:
            self._trail.event("seam", {"tested": False, "reason": "the check set was measured at another plateau"})
            return
        found = compare(before, self._checks, self._history.measured_once)
        steps = [one for one in found if one.is_step]
        worst = max(found, key=lambda one: abs(one.t) / one.t_limit)
        told = f"{worst.channel} at step {worst.step} changed by {worst.change_v:.3g} V, t = {worst.t:.3g}"
        detail = {"tested": True, "comparisons": len(found), "steps": len(steps), "worst": told}
        self._trail.event("seam", {**detail, "against_epoch": self._history.baseline_epoch})
        if steps:
            raise RunEnds(
                Ending(
                    State.TRIPPED,
                    f"the restart made a step: {told}, allowed {worst.t_limit:.3g}; look at mount, sensor and meter; "
                    "a resume with a name and a reason accepts it",
                    cause="seam",
                )
            )

    def _boundary(self) -> None:
        """Between dwells: stop, pause and the longest duration take effect here."""
        self._wait.look()
        self._stop_if_asked()
        limit_s, spent_s = self._plan.max_duration_s, self._rig.clock.monotonic_s() - self._began_s
        if limit_s is not None and spent_s > limit_s:
            raise RunEnds(Ending(State.STOPPED, f"[stop] max_duration_s = {limit_s:g} s has passed", "procedure"))
        if self._wait.pause is not None and self._trail.state is State.RUNNING:
            self._pause(self._wait.pause)

    def _stop_if_asked(self) -> None:
        if self._wait.stop is not None:
            raise RunEnds(Ending(State.STOPPED, self._wait.stop.text, self._wait.stop.by))

    def _pause(self, request: Request) -> None:
        self._trail.enter(State.PAUSED, request.text, request.by)
        continued = self._continue_asked(lambda: self._wait.pause is None)
        self._trail.enter(State.RUNNING, by=continued)

    def _hold(self, reason: str) -> None:
        before = self._trail.state
        self._trail.enter(State.HELD, reason, cause="suspect dwell")
        if isinstance(self._rig.clock, VirtualClock):
            raise RunEnds(Ending(State.FAILED, reason))
        self._wait.continued = None
        continued = self._continue_asked(lambda: self._wait.continued is not None)
        self._trail.enter(before, by=continued)

    def _continue_asked(self, is_so: Callable[[], bool]) -> str:
        """Rest until a person continues; returns who. A stop or an abort ends the run."""
        while not is_so():
            self._wait.rest()
            self._stop_if_asked()
        return self._wait.continued.by if self._wait.continued is not None else ""


def _mean_position(measured: Measurement) -> dict[str, float]:
    before, after = measured.before.axes, measured.after.axes
    return {name: 0.5 * (state.position_deg + after[name].position_deg) for name, state in before.items()}


def _mean_temperature(measured: Measurement) -> dict[str, float]:
    before, after = measured.before.temperature_degc, measured.after.temperature_degc
    means = {name: 0.5 * (degc + after[name]) for name, degc in before.items()}
    return {name: degc for name, degc in means.items() if isfinite(degc)}
