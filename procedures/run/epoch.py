"""One epoch: from homed axes and a measured check set to the last dwell, or to where trust is lost.

intent → move → arrival by read-back → settle → look, read, look → judge → commit.

* A rejected dwell is measured again, at most ``retries`` times; then the run is held until a person says continue
  (which grants the retries anew), stop or abort.
* A reading that a device garbled, refused or did not answer voids the attempt (the line may have damaged the question
  on its way): nothing is judged, the readouts are prepared again and the same attempt is repeated, at most ``retries``
  times. Voids do not count as judged attempts, so a run that met them draws the same chance as one that did not. After
  that the link counts as lost, and a refusal trips the run.
* Between dwells everything is looked at. Dwells taken since a band was left are taken back and measured again.
"""

from collections import defaultdict, deque
from functools import partial
from itertools import chain, count
from math import inf

from procedures.common_mode.visit_watch import Judged, VisitWatch, way_out
from procedures.journal.voids import DROPPED, key_of, void_detail
from procedures.plan.adaptive import Readings
from procedures.plan.steps import Dwell, Soak, Step
from procedures.records.dwells import DwellRecord, Measurement, without_readings
from procedures.records.progress import COMMON_MODE, MADE_AGAIN
from procedures.records.states import State
from procedures.run.adaptive_dwells import AdaptiveDwells
from procedures.run.context import LOOK_S, RunContext
from procedures.run.dwell.measure import Announcement, move
from procedures.run.dwell.perform import perform
from procedures.run.dwell.warm_up import warm_up
from procedures.run.ending import Ending, RunEnds
from procedures.run.enough import is_enough_measured
from procedures.run.judgement.alarm import Alarm, TrustLost
from procedures.run.judgement.history import TABLE, History, agenda, replications_before
from procedures.run.judgement.judge import Limits, judge_dwell
from procedures.run.judgement.running_fit import Doubt
from procedures.run.judgement.suspect_dwells import Suspects
from procedures.run.live_dwells import LiveDwells
from procedures.run.plateaus import INTERLOCK, Plateaus
from procedures.run.start_checks import require_declared_mounts, require_no_fault, require_no_step, require_standstill
from procedures.run.vigil import Vigil, end_where_nothing_holds
from procedures.run.watch.device_watch import DeviceWatch
from procedures.run.watch.meter_checks import PHASE, MeterWatch
from procedures.run.watch.watch import suspended
from rig.crash_points import CrashPoint, crash_point
from rig.errors import DeviceNonsense, DeviceRefused, DeviceSilent
from rig.motion.move import home_and_arrive


class Epoch:
    """Takes the run as far as trust in positions and lines lasts."""

    def __init__(self, context: RunContext, history: History, devices: DeviceWatch) -> None:
        self._context = context
        self._plan, self._rig, self._progress_log = context.plan, context.rig, context.progress_log
        self._wait, self._watch, self._live = context.wait, context.watch, LiveDwells.of(context)
        self._history = history
        self._devices = devices
        self._noise = history.noise()
        self._adaptive = AdaptiveDwells(context, self._noise, history.integrations)
        self._replications = replications_before(self._plan)
        self._checks: dict[int, DwellRecord] = {}
        self._judged: defaultdict[int, int] = defaultdict(int)
        self._accepted: list[DwellRecord] = []
        self._left: deque[Step] = deque()
        increments_deg = {name: axis.increment_deg for name, axis in self._rig.axes.items()}
        self._chains = context.services.run_limits.chains
        self._suspects = Suspects(self._plan, history, increments_deg, self._chains)
        self._plateaus = Plateaus(context, self._live, self._suspects, history.epoch)
        self._visits = VisitWatch(self._plan, self._chains, history.steps_in_mid_run)
        for known in history.dwells:
            self._visits.take(known)
        self._meters = MeterWatch(self._rig, self._progress_log.event, self._wait)
        self._taken_back: list[Step] | None = None
        """Steps to be measured again since something was left that they need; None where nothing was."""
        context.vigil = Vigil(context, lambda: self._announce(self._next_dwell, INTERLOCK), self._take_back)

    def run(self) -> None:
        """Everything that is left. Raises: RunEnds, TrustLost, RigError, StorageFailed."""
        self._left.extend(agenda(self._plan.steps, self._history.accepted_steps))
        self._end_where_enough()
        if self._left:
            self._check_rig()
        # After the last step too: a band that is left may yet make dwells void, and a meter may owe its last proof.
        while self._left or self._watch.is_in_doubt or self._meters.owes(self._last_dwell_s):
            step = self._left.popleft() if self._left else None
            if step is None:
                self._context.wait_unless_stopped(LOOK_S)
                self._boundary()
            elif isinstance(step, Soak):
                self._soak(step)
            else:
                self._dwell(step)
                if step.purpose == "design":
                    self._end_where_enough()
        if self._progress_log.state is State.CHECKING:
            self._progress_log.enter(State.RUNNING)

    def _end_where_enough(self) -> None:
        """Leave out what is left where ``[stop]`` says that whole replications are enough."""
        if is_enough_measured(self._context, self._suspects.plan, chain(self._history.dwells, self._accepted)):
            self._left.clear()

    def _check_rig(self) -> None:
        known = require_standstill(self._rig, self._progress_log)
        self._live.phase("asking every device who it is")
        if why := self._devices.refusal(self._rig.identities(), self._plan):
            raise RunEnds(Ending(State.TRIPPED, why, cause="identity"))
        self._live.phase("proving the readouts")
        self._prepare_readouts()
        for name, readout in self._rig.readouts.items():
            self._progress_log.event("meter", {"readout": name, **readout.checks()})
        self._watch.forget_positions()  # a search for home takes every axis away from where it was left
        require_no_fault(self._rig.axes, known)  # before watchdogs are proved: of some that leaves an alarm to be homed
        self._context.watchdogs.arm(self._wait)
        for name in self._plan.axes:
            self._live.homes(name)
            position_deg = home_and_arrive(self._rig.axes[name], self._rig.clock, self._wait, self._again)
            self._watch.rests_at({name: position_deg})
        self._warm_up()

    def _prepare_readouts(self) -> None:
        for readout in self._rig.readouts.values():
            readout.prepare()

    def _warm_up(self) -> None:
        gates = self._context.services.run_limits.warm_ups
        dwells = [step for step in self._left if isinstance(step, Dwell)]
        if not dwells or not (gates or self._adaptive.is_untried):
            return
        self._watch.rests_at(move(self._rig, dwells[0], self._wait, self._again, self._plan.moving_together))
        self._announce(dwells[0], "warm-up")
        for gate in gates:
            self._live.warms_up(gate.channel)
            self._progress_log.tell("check", f"{gate.channel}: warming up")
            found = warm_up(self._rig, gate, self._context.wait_unless_stopped, self._context.stand)
            self._progress_log.event("warm_up", found)
        self._adaptive.try_integrations(dwells[0], self._replications[dwells[0].step])

    def _soak(self, step: Soak) -> None:
        self._boundary()
        self._plateaus.bring_to(step)

    def _dwell(self, dwell: Dwell) -> None:
        """Until the dwell is accepted or the run ends."""
        if dwell.purpose != "check":
            # Soak anew for a step that is gone back to, or after a band was left.
            plateau = self._plateaus.of(dwell.step)
            if plateau is not None and self._plateaus.has_lost(dwell):
                self._soak(plateau)
            if self._progress_log.state is State.CHECKING:
                self._leave_checking()
        retries = self._plan.dwell.retries
        judged = self._judged[dwell.step]
        # Every epoch measures the check set anew; of other dwells earlier attempts count, and their chance goes on.
        if dwell.purpose != "check":
            judged = max(judged, self._history.attempts(dwell.step))
        # More attempts than retries before a restart: a person had granted them.
        granted = retries + 1 if judged <= retries else judged + retries + 1
        while True:
            if self._boundary(dwell):
                return
            judged += 1
            self._judged[dwell.step] = judged
            record = self._attempt(dwell, judged)
            if record.accepted:
                self._act_on_visit(self._visits.take(record))
                return
            # What was measured while the temperature was away says nothing about the dwell.
            if self._plateaus.regained():
                granted = judged + retries + 1
            elif judged >= granted:
                reason = f"step {dwell.step}: rejected {judged} times: {'; '.join(record.reasons)}"
                if not self._went_on_without(record, reason):
                    self._context.hold(Alarm("suspect dwell", reason, "ask"))
                granted = judged + retries + 1

    def _went_on_without(self, record: DwellRecord, reason: str) -> bool:
        """Drop a sensor that alone spoils the dwell, where others remain, and tell; return whether there was one."""
        sensor = self._suspects.alone_to_blame(record.reasons)
        if sensor is None:
            return False
        self._suspects.drop(sensor)
        self._progress_log.event(DROPPED, {"sensor": sensor, "step": record.step, "reason": reason})
        self._progress_log.tell(DROPPED, f"{sensor}: dropped, the other sensors go on: {reason}")
        return True

    def _attempt(self, dwell: Dwell, attempt: int) -> DwellRecord:
        """Move, measure, judge, commit."""
        intent = {"step": dwell.step, "purpose": dwell.purpose, "attempt": attempt, "epoch": self._history.epoch}
        readings = self._adaptive.readings()
        chosen = {"samples": {channel: reading.samples for channel, reading in readings.items()}} if readings else {}
        self._progress_log.event("intent", {**intent, **chosen, "targets_deg": dict(dwell.targets_deg)})
        crash_point(CrashPoint.INTENT_COMMITTED)
        self._live.moves(dwell, self._left)
        rest_deg = move(self._rig, dwell, self._wait, self._again, self._plan.moving_together)
        self._watch.rests_at(rest_deg)
        self._live.rests_at(rest_deg)
        crash_point(CrashPoint.IN_POSITION)
        clock = self._rig.clock
        started_utc, started_s = clock.now_utc(), clock.monotonic_s()
        measured = self._measured(dwell, self._announcement(dwell, attempt), readings)
        # While the computer slept, samples were lost and nobody saw the axes.
        if (change := self._watch.clock_change()).is_suspension:
            raise TrustLost("suspend", f"{suspended(change).reason} during the dwell of step {dwell.step}")
        reasons = judge_dwell(dwell, measured, self._limits(dwell), self._noise, self._plan.attitude_reference)
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
            measured_deg=measured.mean_position_deg(),
            temperature_degc=measured.mean_temperature_degc(),
            readings=measured.readings,
            started_utc=started_utc,
            ended_utc=clock.now_utc(),
            started_s=started_s,
            ended_s=clock.monotonic_s(),
            settle_s=measured.settle_s,
            sha256="",
            mounting=self._history.mounting,
            motion=measured.motion,
        )
        record, doubt = self._suspects.examine(record)
        if doubt is not None and doubt.dubious:  # before the dwell is kept: a kill in between leaves nothing in doubt
            detail = void_detail(map(key_of, doubt.dubious), "", "; ".join(doubt.reasons), doubt.kind)
            self._progress_log.void_dwells(doubt.dubious, detail)
        self._watch.saw(measured, is_accepted=record.accepted)
        self._live.saw(measured)
        stored = self._keep(self._progress_log.commit(record))
        if doubt is not None and doubt.kind != "unexplained":
            self._act_on(doubt)
        return stored

    def _again(self, reason: str) -> None:
        """Record that a move is made again."""
        self._progress_log.event(MADE_AGAIN, {"reason": reason})
        self._progress_log.tell("void", reason)

    def _act_on(self, doubt: Doubt) -> None:
        """Raise what a doubt asks for: RunEnds where channels changed places, TrustLost where an axis slipped."""
        reason = "; ".join(doubt.reasons)
        if doubt.kind == "slip":
            raise TrustLost("slip", reason)
        raise RunEnds(Ending(State.TRIPPED, f"{reason}; look at scanner and wiring", cause="channels"))

    def _act_on_visit(self, judged: Judged | None) -> None:
        """Tell what a visit shows; hold where all sensors turned, until a person says continue."""
        if judged is None or not judged.findings:
            return
        sentence, folder = judged.sentence, self._progress_log.folder
        detail = {"step": judged.step, "text": sentence, "held": judged.holds, "doubtful": list(judged.doubtful)}
        self._progress_log.event(COMMON_MODE, {**detail, "kinds": [finding.kind for finding in judged.findings]})
        self._progress_log.tell(COMMON_MODE, sentence)
        if judged.holds:
            out = way_out(judged, [*self._history.dwells, *self._accepted], folder)
            self._context.hold(Alarm(TABLE, f"{sentence}; {out}", "ask"))

    def _keep(self, record: DwellRecord) -> DwellRecord:
        """Learn from a dwell: accepted ones judge later ones, in the order in which an uninterrupted run takes them."""
        if record.accepted:
            self._accepted.append(record if self._plan.sequential is not None else without_readings(record))
            self._suspects.learn(record)
            if record.purpose == "check":
                self._checks[record.step] = record
            if record.purpose != "check" or self._is_first_check_set:
                self._noise.learn(record.readings)
        self._context.count_dwell()
        return record

    def _measured(self, dwell: Dwell, announcement: Announcement, readings: Readings) -> Measurement:
        for void in count(1):
            try:
                return perform(
                    self._rig, self._suspects.plan, dwell, announcement, self._wait, self._context.stand, readings
                )
            except (DeviceNonsense, DeviceSilent, DeviceRefused) as error:
                if self._context.is_decided(error):
                    raise
                detail = {"step": dwell.step, "attempt": announcement.attempt, "void": void, "reason": str(error)}
                self._progress_log.event("void", detail)
                self._progress_log.tell("void", str(error))
                if void > self._plan.dwell.retries:
                    raise
                self._prepare_readouts()
        raise AssertionError("unreachable: count never ends")

    @property
    def _is_first_check_set(self) -> bool:
        return self._history.first_check_epoch is None

    def _announcement(self, dwell: Dwell, attempt: int) -> Announcement:
        """Return what the twins are told of a dwell.

        A check set that is measured again has chance of its own, and the drift of the moment.
        """
        announce = partial(self._live.phase, dwell=dwell)
        if dwell.purpose != "check":
            return Announcement(dwell.step, attempt, self._replications[dwell.step], "settle", "read", announce)
        if self._is_first_check_set:
            return Announcement(dwell.step, attempt, self._replications[dwell.step], "settle", "check", announce)
        epoch = self._history.epoch
        return Announcement(
            dwell.step, attempt, self._replications_so_far(), f"settle-{epoch}", f"check-{epoch}", announce
        )

    def _replications_so_far(self) -> float:
        steps = agenda(self._plan.steps, self._history.accepted_steps)
        return next(
            self._replications[step.step] for step in steps if isinstance(step, Dwell) and step.purpose != "check"
        )

    def _announce(self, dwell: Dwell, phase: str) -> None:
        self._rig.chance.announce(dwell.step, phase, self._history.epoch, self._replications[dwell.step])

    def _limits(self, dwell: Dwell) -> Limits:
        return Limits(
            targets_deg=dwell.targets_deg,
            tolerance_deg={name: self._rig.axes[name].arrival_tolerance_deg for name in dwell.targets_deg},
            max_noise_factor=self._plan.dwell.max_noise_factor,
            bands=self._plateaus.bands(),
        )

    def _leave_checking(self) -> None:
        """Judge the measured check set: the package mounted as declared, and no step since the start."""
        sensors = {name: sensor for name, sensor in self._plan.sensors.items() if name in self._suspects.remaining}
        require_declared_mounts(sensors, self._checks, self._progress_log)
        before = self._history.earlier_checks
        if before:
            is_alike = self._plateaus.is_at_that_of(min(before))
            require_no_step(
                self._history,
                self._checks,
                self._progress_log,
                self._chains,
                self._visits,
                is_alike=is_alike,
                is_at_plateau_of=self._plateaus.is_at_that_of,
            )
        elif self._history.epoch > 1 and self._history.mounting > 1:
            self._progress_log.event("seam", {"tested": False, "reason": "the package was mounted anew"})
        self._progress_log.enter(State.RUNNING)
        expected = self._plan.expected
        each_s = expected.p50_s / max(len(self._plan.design_dwells), 1)
        self._progress_log.begin_pace(each_s, expected.p90_s - expected.p50_s)

    def _boundary(self, dwell: Dwell | None = None) -> bool:
        """Between dwells; True where earlier steps come first now and ``dwell`` was put behind them."""
        # An answer may take hours, so everything is looked at anew before the next dwell.
        while True:
            self._context.requests()
            if self._taken_back is None:
                if (alarm := self._look(dwell)) is None:
                    return False
                self._take_back(alarm)
                end_where_nothing_holds(alarm)
                self._context.hold(alarm, partial(self._context.has_passed, alarm, len(self._left) + 1))
            voided, self._taken_back = self._taken_back or [], None
            if voided or (dwell is not None and self._plateaus.has_lost(dwell)):
                self._left.extendleft(reversed([*voided, *([] if dwell is None else [dwell])]))
                return True

    def _look(self, dwell: Dwell | None) -> Alarm | None:
        announced = dwell or self._next_dwell
        room_bytes = self._context.room_bytes(len(self._left) + 1)
        found = self._watch.look(*room_bytes, lambda: self._announce(announced, INTERLOCK))
        is_last = dwell is None and not self._left
        return found or self._meters.look(
            lambda: self._announce(announced, PHASE), self._last_dwell_s if is_last else None
        )

    @property
    def _next_dwell(self) -> Dwell:
        return next((step for step in self._left if isinstance(step, Dwell)), self._plan.dwells[0])

    @property
    def _last_dwell_s(self) -> float | None:
        return self._accepted[-1].ended_s if self._accepted else None

    def _take_back(self, alarm: Alarm) -> None:
        """Void what was measured since a band was left, and leave the plateau."""
        if alarm.cause == INTERLOCK:
            self._plateaus.leave()
        self._taken_back = self._taken_back or []
        from_s = inf if alarm.void_from_s is None else alarm.void_from_s
        voided = [record for record in self._accepted if record.ended_s > from_s]
        if not voided:
            return
        self._accepted = [record for record in self._accepted if record.ended_s <= from_s]
        for record in voided:
            self._checks.pop(record.step, None)
        self._visits.take_back(record.step for record in voided)
        self._progress_log.void_dwells(voided, void_detail(map(key_of, voided), "", alarm.reason, alarm.cause))
        steps = {record.step for record in voided}
        self._taken_back += [step for step in self._plan.steps if step.step in steps]
