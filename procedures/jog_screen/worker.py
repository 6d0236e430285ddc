"""The bench by hand: one thread owns the devices; a screen asks, looks at a view, and stops past everybody.

Requests wait in a queue of one motion at a time: a step asked for while an axis moves is refused, not saved up. A stop
does not queue: the guard sends it at once, this thread leaves what it does at its next look and sees every axis stand.
"""

from contextlib import suppress
from dataclasses import replace
from queue import Empty, SimpleQueue

from procedures.errors import ProcedureError
from procedures.jog_screen.guard import Guard
from procedures.jog_screen.inferred import InferredAttitude
from procedures.jog_screen.last_stop import NOT_SEEN, StopOutcome, stopped, stopped_in_reach
from procedures.jog_screen.log import ActionLog, Snapshots
from procedures.jog_screen.polling import Polling
from procedures.jog_screen.values import (
    AT_TERMINAL,
    MOTIONS,
    Asker,
    BenchView,
    ClearStatistics,
    GoTo,
    HoldTemperature,
    Home,
    Pulse,
    Request,
    ShownMessage,
    Snapshot,
    Tone,
    Turn,
    message_at,
)
from procedures.jog_screen.watchdogs import TurningWatchdogs
from rig.assembly.open_rig import Rig
from rig.clock import Clock
from rig.defects import defect_text
from rig.errors import LinkLost, RequestRefused, RigError, WaitEnded
from rig.motion import jog
from rig.motion.out_of_reach import BACK_S
from rig.threads import BegunThread, begun

SHOWN_LINES = 200
_IDLE_S, _RECONNECT_S = 0.05, 2.0
_LATE_S, _SILENT_S = 0.7, 3.0
"""A device that keeps the bench waiting is named after so long, and called silent after so long."""
_BEGIN_S = 3.0
"""A motion of a page that could not begin for so long is refused: who asked may have a hand in the rig by then."""


class Bench:
    """``clock`` is the machine's. :meth:`start` and :meth:`close` belong to whoever opened the rig."""

    def __init__(
        self,
        rig: Rig,
        log: ActionLog,
        snapshots: Snapshots,
        clock: Clock,
        inferred: InferredAttitude | None = None,
    ) -> None:
        self._rig = rig
        self._log = log
        self._snapshots = snapshots
        self._clock = clock
        self._queue: SimpleQueue[tuple[Request, Asker, float]] = SimpleQueue()
        """With when each was asked for."""
        self._unwritten: SimpleQueue[str] = SimpleQueue()
        """What the guard did: it waits for no disk."""
        self._waiting_motion = ""
        self._messages: tuple[ShownMessage, ...] = ()
        self._is_closing = False
        self._begun_with = rig.identities()
        self._strangers = ""
        self._doing = ""
        self._lost_line = ""
        self._tried_s = clock.monotonic_s()
        self.guard = Guard(lambda: rig.axes, clock, self._hear_guard)
        log.lose = self.guard.lose
        self._polling = Polling(rig, self.guard, clock, inferred, lambda text: self._tell("failed", text))
        self.guard.why_stop = lambda: self._polling.why_unseen() or rig.why_stop()
        self._watchdogs = TurningWatchdogs(rig, lambda text: self._tell("note", text))
        self._at_work: BegunThread | None = None
        self.last_stop: StopOutcome = NOT_SEEN
        """How the axes were left: to be read when it :meth:`has_ended`."""
        self._seen = BenchView((), (), ())
        """Replaced whole."""
        self._seen_s = clock.monotonic_s()
        self._publish()

    @property
    def view(self) -> BenchView:
        """What was last seen; a stop, and that a device is waited for, also while the thread that looks waits."""
        return replace(self._seen, is_stopping=self.guard.is_stopping, waits_for=self._waits_for())

    def start(self) -> None:
        self.guard.start()
        self._rig.prepare_to_move()
        self._log.write("begin", rig=self._rig.description.rig.name, identities=self._begun_with)
        self._at_work = begun(self._run, "the bench")

    def close(self) -> None:
        """Stop every axis, see it stand, end both threads. The rig stays open."""
        self.leave()
        if self._at_work is not None:
            self._at_work.join()
        self.guard.close()
        self._write_down()
        self._log.write("end", lost=self.guard.lost)

    def leave(self) -> None:
        """Have every axis stopped for the last time, and wait for nothing."""
        self._is_closing = True

    def has_ended(self, within_s: float) -> bool:
        """Wait for the last stop, since the operator leaves or is gone; return whether it is over."""
        return self._at_work is None or self._at_work.join(within_s)

    def ask(self, request: Request, asker: Asker = AT_TERMINAL, seen_s: float | None = None) -> None:
        """Have something done. What cannot be done now is refused in the view's lines.

        What moves by a page moves under its lease, from the moment at which it was last known to be there (``seen_s``).
        """
        if refusal := self._why_not(request, asker):
            self._log.write("refused", asked=str(request), why=refusal, **asker.to_log())
            self._tell("refused", f"{request}: {refusal}")
            return
        if isinstance(request, MOTIONS):
            self._waiting_motion = str(request)
            if asker.is_page:
                self.guard.grant(request.axis, asker, is_move=not isinstance(request, Turn), seen_s=seen_s)
        self._queue.put((request, asker, self._clock.boottime_s()))

    def stop(self, why: str, asker: Asker = AT_TERMINAL) -> None:
        """Stop every axis now, and forget what was asked for."""
        self.guard.stop(why)
        self._log.write("stop", why=why, **asker.to_log())

    def refuse(self, why: str, asker: Asker = AT_TERMINAL) -> None:
        """Tell the operator what cannot be."""
        if asker.is_page:
            self._log.write("refused", why=why, **asker.to_log())
        self._tell("refused", why)

    def note(self, kind: str, text: str, asker: Asker) -> None:
        """Write down and tell who comes and who goes."""
        self._log.write(kind, **asker.to_log())
        self._tell("note", text)

    def turn_while_pressed(self, axis: str, rate_dps: float) -> None:
        """Turn an axis as long as its key is pressed: called when the key comes, for the first time or again."""
        if not self.guard.press(axis):
            self.ask(Turn(axis, rate_dps, is_held=True))

    def _why_not(self, request: Request, asker: Asker) -> str:
        if self.guard.is_stopping:
            return "a stop is under way"
        if not isinstance(request, MOTIONS):
            return ""
        if request.axis not in self._rig.axes:
            return f"no axis {request.axis!r} (allowed: {', '.join(self._rig.axes)}); nothing moved"
        if self._strangers or self._lost_line:
            return self._strangers or f"{self._lost_line}; nothing moves until every line is open again"
        busy = self._doing or self._waiting_motion or self._polling.turning()
        how = "" if asker.is_page else " (space)"
        return f"{busy} is under way; wait, or stop it{how}" if busy else ""

    def _hear_guard(self, text: str) -> None:
        self._tell("stopped", text)
        self._unwritten.put(text)

    def _waits_for(self) -> str:
        late_s = self._clock.monotonic_s() - self._seen_s
        if late_s < _LATE_S or self._at_work is None or not self._at_work.is_alive:
            return ""
        if late_s < _SILENT_S:
            return f"waiting for {self._polling.awaited}, {late_s:.1f} s: values are older, stop works"
        return f"no answer from {self._polling.awaited} for {late_s:.0f} s: see its power and cable; stop works"

    # The thread that owns the devices.

    def _run(self) -> None:
        try:
            self._polling.begin_anew()
            self._polling.awaited = "the watchdogs to be proven"
            with suppress(WaitEnded):
                self._watchdogs.arm(self._silent_wait)
            while not (self._is_closing or self.guard.lost):  # nobody is there who would end it
                self._round()
        except Exception as error:  # noqa: BLE001  the rim of a thread: without it nobody looks where an axis turns to
            self.guard.lose(defect_text(error))
        self._stop_everything("the session ended", is_last=True)
        self._watchdogs.disarm()

    def _round(self) -> None:
        """Do one request or one poll; what fails is told and the work goes on."""
        self._write_down()
        try:
            if self.guard.is_stopping:
                self._stop_everything("")
            elif (taken := self._next()) is not None:
                self._do(*taken)
            elif self._lost_line:
                self._reconnect()
            else:
                self._polling.round(self._wait)
        except WaitEnded as ended:
            if not self._is_closing:
                self.guard.stop(str(ended))  # by somebody past this process; a stop of its own is told already
        except LinkLost as error:
            self._lost_line = str(error)
            self._tell("failed", str(error))
        except RigError as error:
            self._tell("failed", str(error))
        self._publish()

    def _write_down(self) -> None:
        with suppress(Empty):
            while True:
                self._log.write("guard", told=self._unwritten.get_nowait())

    def _next(self) -> tuple[Request, Asker, float] | None:
        try:
            return self._queue.get_nowait()
        except Empty:
            return None

    def _do(self, request: Request, asker: Asker, requested_s: float) -> None:
        is_motion = isinstance(request, MOTIONS)
        self._doing, self._waiting_motion = (str(request) if is_motion else ""), ""
        self._log.write("asked", what=type(request).__name__, asked=str(request), **asker.to_log())
        self._polling.awaited = str(request)
        self._publish()
        is_turning = False
        try:
            if is_motion and asker.is_page:
                self._require_in_time(request, requested_s)
            outcome = self._done(request, asker)
            is_turning = isinstance(request, Turn)
            self._log.write("done", asked=str(request), outcome=outcome)
            self._tell("done", outcome)
        except WaitEnded as ended:
            self._log.write("ended", asked=str(request), outcome=str(ended))
            raise
        except (RigError, ProcedureError) as error:
            tone: Tone = "refused" if isinstance(error, RequestRefused | ProcedureError) else "failed"
            self._log.write(tone, asked=str(request), why=str(error))
            self._tell(tone, str(error))
            if isinstance(error, LinkLost):
                self._lost_line = str(error)
        finally:
            if isinstance(request, MOTIONS) and not is_turning:
                self.guard.end_lease(request.axis, asker.client)
            self._doing = ""
            self._polling.aim(None, None)

    def _done(self, request: Request, asker: Asker) -> str:
        """Do it; returns what to say. Raises: RigError, ProcedureError."""
        if isinstance(request, MOTIONS) and asker.is_page:
            self._require_lease(request.axis, asker)
        match request:
            case GoTo(axis, degrees, is_step):
                return self._move(axis, self._polling.position_deg(axis) + degrees if is_step else degrees)
            case Pulse(axis, pulse_us):
                return self._move(axis, jog.attitude_of_pulse(self._rig, axis, pulse_us))
            case Home(axis):
                self._polling.clear_statistics()
                return f"{axis}: homed, at rest at {jog.home(self._rig, axis, self._wait, self._made_again):+.4f}°"
            case Turn(axis, rate_dps, is_held):
                return self._turn(axis, rate_dps, asker, is_held=is_held)
            case HoldTemperature(chamber, setpoint_degc):
                jog.hold(self._rig, chamber, setpoint_degc)
                self._polling.forget_chambers()
                return f"{chamber}: holds {setpoint_degc:g} °C"
            case Snapshot():
                return f"snapshot {self._snapshots.append(self.view)} in {self._snapshots.path}"
            case ClearStatistics():
                self._polling.clear_statistics()
                return "statistics begin here"

    def _move(self, axis: str, target_deg: float) -> str:
        target_deg = round(target_deg, 9)
        self._polling.aim(axis, target_deg)
        self._polling.clear_statistics()
        at_rest_deg = jog.jog_to(self._rig, axis, target_deg, self._wait, self._made_again)
        self._polling.clear_statistics()
        return f"{axis}: at rest at {at_rest_deg:+.4f}°"

    def _made_again(self, reason: str) -> None:
        self._log.write("again", why=reason)
        self._tell("note", reason)

    def _turn(self, axis: str, rate_dps: float, asker: Asker, *, is_held: bool) -> str:
        device = jog.rate_axis(self._rig, axis)
        device.check_rate(rate_dps)
        self._polling.require_room(axis, rate_dps)
        if not asker.is_page:
            self.guard.grant(axis, asker, is_held=is_held)
        try:
            device.start_rate(rate_dps)
        except RequestRefused:
            raise
        except RigError as error:
            self.guard.stop(str(error))  # it may have heard what it did not acknowledge
            raise
        self._polling.turns(axis, rate_dps)
        if not self.guard.has_lease(axis, asker.client):  # then its stop may have come before its start
            self.guard.stop(f"{axis}: nobody keeps its rate alive")
            raise WaitEnded("its lease had ended when the axis began to turn")
        how = "while the key is held" if is_held else "while this terminal answers"
        return f"{axis}: turns at {rate_dps:+g} °/s {'while the button is held' if asker.is_page else how}"

    def _require_in_time(self, request: Request, requested_s: float) -> None:
        """Refuse a motion that waited for a device that was being read. Raises: RequestRefused."""
        if (late_s := self._clock.boottime_s() - requested_s) > _BEGIN_S:
            raise RequestRefused(
                f"{request}: a device kept it waiting for {late_s:.1f} s, allowed are {_BEGIN_S:g} s; nothing moved;"
                " ask again"
            )

    def _require_lease(self, axis: str, asker: Asker) -> None:
        """Refuse what nobody keeps alive any more. Raises: RequestRefused."""
        if not self.guard.has_lease(axis, asker.client):
            raise RequestRefused(f"{axis}: who asked has let go, or did not answer in time; it does not move")

    def _silent_wait(self, duration_s: float) -> None:
        self._wait(duration_s, is_looking=False)

    def _wait(self, duration_s: float, *, is_looking: bool = True) -> None:
        """Axes are looked at meanwhile: positions are shown, and machines hear that their host lives.

        Raises: WaitEnded at a stop.
        """
        left_s = duration_s
        while True:
            if self.guard.is_stopping or self._is_closing:
                raise WaitEnded("stopped by the operator")
            if is_looking:
                self._polling.axes_now_and_then()
                self._publish()
            if left_s <= 0.0:
                return
            slice_s = min(left_s, self._rig.clock.slice_s / 2.0)
            self._rig.clock.sleep(slice_s)
            left_s -= slice_s

    def _stop_everything(self, why: str, *, is_last: bool = False) -> None:
        """Stop, see every axis stand for a second, and let nothing go on that was asked for before."""
        while self._next() is not None:
            pass
        self._waiting_motion = ""
        self._polling.awaited = "every axis to be seen at rest"
        self._publish()
        outcome = stopped_in_reach(self._rig) if is_last else stopped(self._rig)
        if is_last:
            self.last_stop = outcome
        self._polling.all_stand()
        self._rig.heed_stop()
        self.guard.stood_still()
        self._log.write("stopped", outcome=outcome.in_words, why=why)
        self._tell("stopped" if outcome.is_clean else "failed", outcome.in_words)

    def _reconnect(self) -> None:
        """Open every line that is lost, and see that the same devices answer."""
        self._wait(_IDLE_S)
        if self._clock.monotonic_s() - self._tried_s < _RECONNECT_S:
            return
        self._tried_s = self._clock.monotonic_s()
        self._polling.awaited = "the lines to be open again"
        unopened = self._rig.open_lost(self._rig.clock.monotonic_s() + BACK_S)
        self._polling.begin_anew()  # a line that stays away keeps no axis on another one from being seen at rest
        if unopened:
            self._lost_line = unopened
            return
        try:
            identities = self._rig.identities()
        except RigError as error:
            self._lost_line = str(error)
            return
        self._lost_line = ""
        strangers = "; ".join(self._rig.strangers(identities).values())
        self._strangers = strangers and f"{strangers}; put the cables right and start anew"
        self._tell("failed" if self._strangers else "note", self._strangers or "every line is open again")
        self._log.write("reconnected", identities=identities)

    def _tell(self, tone: Tone, text: str) -> None:
        self._messages = (*self._messages, message_at(self._clock.now_utc(), tone, text))[-SHOWN_LINES:]
        self._seen = replace(self._seen, messages=self._messages)

    def _publish(self) -> None:
        axes, channels, chambers, attitude = self._polling.views()
        self._seen_s = self._clock.monotonic_s()
        self._seen = BenchView(
            axes=axes,
            channels=channels,
            chambers=chambers,
            attitude=attitude,
            doing=self._doing or self._polling.turning(),
            messages=self._messages,
        )
