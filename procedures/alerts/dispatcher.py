"""The dispatcher: hears what a run tells, decides what people should know, and never lets a slow server hold the run.

It is an observer in front of another one. Every message leaves by an outbox that waits for no server; what became of it
is handed to the engine at its next look, which journals it. A dead computer cannot ring: the heartbeat goes out
only while the engine looks, so whoever waits for it outside learns of a hung or dead run.

An alarm (whatever stands still though nobody asked for it) is told again until somebody acknowledges it, says
continue, or it is over; after a while others are told as well. That a hold which was told is over is told to the same
people: who was woken need not come. A run that has ended cannot ring by itself, so
:meth:`AlertDispatcher.ring_out` goes on for it.
"""

import shlex
import socket
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

from procedures.alerts.channels import Message, beat, by_apprise, by_command
from procedures.alerts.outbox import HEARTBEAT, Outbox
from procedures.alerts.settings import AlertSettings, Escalation
from procedures.records.progress import AT_REST, LEASE, LEASE_LOST, Progress, RunObserver, SilentObserver, line_of
from procedures.records.states import State, is_unasked
from rig.clock import Clock
from rig.local_time import at_both
from rig.plain_text import one_line

ALERTED_STATES = (State.HELD, State.TRIPPED, State.FAILED, State.STOPPED, State.ABORTED, State.INTERRUPTED)
"""At once. That a run has finished is told when it is known what it came to: :meth:`AlertDispatcher.tell_end`."""
OF_EVENTS = {
    "dropped": "a sensor was dropped",
    "terminal": "the terminal was closed",
    "chamber": "a chamber tells an alarm",
    AT_REST: "found while it stands still",
}
_NO_RUN = "RUN"
RING_S = 1.0
"""Between two looks whether an alarm of a run that has ended was acknowledged."""


def _nothing_known(_cause: str, _state: State) -> str:
    return ""


@dataclass(slots=True)
class _Alarm:
    """Told and not acknowledged."""

    progress: Progress
    since_utc: datetime
    since_s: float
    said_s: float
    is_escalated: bool = False


@dataclass(slots=True)
class _ReportedHold:
    """People know of it, and do not know yet that it is over."""

    since_s: float
    do_others_know: bool = False


class AlertDispatcher:
    """An observer; :meth:`pulse` is the engine's sign of life."""

    def __init__(
        self,
        settings: AlertSettings,
        title: str,
        clock: Clock,
        then: RunObserver,
        run: str = _NO_RUN,
        second_folder: str = "",
        rig: str = "",
        to_do: Callable[[str, State], str] = _nothing_known,
    ) -> None:
        """``run``: what a person gives the command that acknowledges. ``second_folder``: of the page that says why.

        ``rig``: its name; empty where it is not known. ``to_do``: what a person does first, by cause and state.
        """
        self._settings = settings
        self._title = title
        self._run = run
        self._to_do = to_do
        self._second_folder = second_folder
        whose = [] if run == _NO_RUN else [f"Run: {run}."]
        self._bench_sentence = "\n".join([*whose, bench_sentence(rig)])
        self._alarms: dict[str, _Alarm] = {}
        """At most one by what it is of: the state of the run, its lease."""
        self._reported_hold: _ReportedHold | None = None
        self._clock = clock
        self._then = then
        self._last: Progress | None = None
        self._said_s: dict[str, float] = {}
        self._progress_s = self._beat_s = clock.monotonic_s()
        # The first heartbeat is due at once: from then on its absence means something to whoever waits for it.
        self._beat_s -= settings.heartbeat_every_s
        self._outbox = Outbox(clock, settings.deadline_s, settings.secrets)

    def stand_by(self) -> None:
        """Get ready, while there are threads to be had, to tell people when there are none any more; until closed.

        Raises: MemoryError where none can be had now.
        """
        self._outbox.stand_by()

    def on_event(self, progress: Progress) -> None:
        """People first, the screen second: it may be gone."""
        self._last = progress
        if progress.event == "ack":
            self._alarms.clear()
        if (word := OF_EVENTS.get(progress.event)) is not None:
            self._tell(Message(f"calrig: {self._title}: {word}", self._text(progress)), progress.message)
        if progress.event in (LEASE, LEASE_LOST):
            self._heard_of_lease(progress)
        if progress.event == "state":
            is_alarm = is_unasked(progress.state, progress.requested_by)
            self._set_alarm("state", progress if is_alarm else None)
            if progress.state is State.RUNNING:
                self._tell_goes_on(progress)
            if progress.state in ALERTED_STATES:
                text = f"{self._text(progress)}\n{self._ack} ends the repeats." if is_alarm else self._text(progress)
                if self._tell(Message(f"calrig: {self._title}: {progress.state}", text), progress.message):
                    self._know_of(progress)
        self._then.on_event(progress)

    @property
    def has_heard(self) -> bool:
        """Whether it was told anything of the run."""
        return self._last is not None

    def tell_end(self, word: str, text: str) -> None:
        """Tell what a run came to, once, when everything is delivered or is known not to be."""
        self._post(Message(f"calrig: {self._title}: {word}", text))

    def _heard_of_lease(self, progress: Progress) -> None:
        """Lost is an alarm though nothing stands still: two computers may move one machine."""
        is_lost = progress.event == LEASE_LOST
        self._set_alarm(LEASE, progress if is_lost else None)
        word = "the lease of a device is lost" if is_lost else "the lease of a device is held again"
        text = self._text(progress) + (self._how_to_end if is_lost else "")
        self._tell(Message(f"calrig: {self._title}: {word}", text), progress.message)

    def _know_of(self, progress: Progress, do_others_know: bool = False) -> None:
        """Remember a hold that people have been told of."""
        if progress.state is State.HELD and progress.event == "state":
            hold = self._reported_hold or _ReportedHold(self._clock.monotonic_s())
            hold.do_others_know |= do_others_know
            self._reported_hold = hold

    def _tell_goes_on(self, progress: Progress) -> None:
        """Tell everybody who was told of a hold that it is over."""
        if (hold := self._reported_hold) is None:
            return
        self._reported_hold = None
        held_min = (self._clock.monotonic_s() - hold.since_s) / 60.0
        text = f"{self._text(progress)}\nThe hold is over, {held_min:.0f} min after it was told."
        message = Message(f"calrig: {self._title}: goes on", text)
        self._post(message)
        if hold.do_others_know and self._settings.escalate is not None:
            self._post_to(self._settings.escalate, message)

    def _set_alarm(self, of: str, progress: Progress | None) -> None:
        self._alarms.pop(of, None)
        if progress is not None:
            now_s = self._clock.monotonic_s()
            self._alarms[of] = _Alarm(progress, self._clock.now_utc(), now_s, now_s)

    def pulse(self) -> Sequence[Mapping[str, object]]:
        """Send what is due now and return what became of earlier messages."""
        now_s, settings = self._clock.monotonic_s(), self._settings
        if settings.heartbeat is not None and now_s - self._beat_s >= settings.heartbeat_every_s:
            self._beat_s = now_s
            target, deadline_s = settings.heartbeat, settings.deadline_s
            self._outbox.send(HEARTBEAT, lambda: beat(target, deadline_s))
        if settings.every_h is not None and now_s - self._progress_s >= settings.every_h * 3600.0 and self._last:
            self._progress_s = now_s
            self._post(Message(f"calrig: {self._title}: {self._last.state}", self._text(self._last)))
        for alarm in self._alarms.values():
            self._ring(alarm, now_s)
        return self._outbox.outcomes()

    def ring_out(self, is_acknowledged: Callable[[], bool]) -> Sequence[Mapping[str, object]]:
        """Go on for a run that has ended in an alarm, until it is acknowledged or others were told; nothing to do
        where nobody else is to be told. What became of the messages.
        """
        self._set_alarm(LEASE, None)  # given back with the rig
        alarm = self._alarms.get("state")
        while alarm is not None and self._settings.escalate is not None and not alarm.is_escalated:
            if is_acknowledged():
                self._alarms.clear()
                break
            self._clock.sleep(RING_S)
            self._ring(alarm, self._clock.monotonic_s())
            self._outbox.deliver_here()
        return self.close()

    def _ring(self, alarm: _Alarm, now_s: float) -> None:
        """Again, and to others after a while."""
        open_min = (now_s - alarm.since_s) / 60.0
        text = (
            f"{self._text(alarm.progress, alarm.since_utc)}\n"
            f"Nobody has acknowledged it for {open_min:.0f} min: {self._ack}"
        )
        word = "without its lease" if alarm.progress.event == LEASE_LOST else alarm.progress.state
        message = Message(f"calrig: {self._title}: still {word}", text)
        if now_s - alarm.said_s >= self._settings.repeat_every_s:
            alarm.said_s = now_s
            self._post(message)
            self._know_of(alarm.progress)
        others = self._settings.escalate
        if others is not None and not alarm.is_escalated and open_min >= others.after_min:
            alarm.is_escalated = True
            self._post_to(others, Message(f"{message.subject}, unacknowledged", text))
            self._know_of(alarm.progress, do_others_know=True)

    def close(self) -> Sequence[Mapping[str, object]]:
        """Deliver what no thread was to be had for, and wait for what is under way, at most its deadline; what became
        of it.
        """
        self._outbox.close()
        return self._outbox.outcomes()

    def _tell(self, message: Message, reason: str) -> bool:
        """Post a message unless the same was posted for the same reason a short time ago; returns whether it was."""
        key, now_s = f"{message.subject}\n{reason}", self._clock.monotonic_s()
        before_s = self._said_s.get(key)
        is_new = before_s is None or now_s - before_s >= self._settings.least_gap_s
        if is_new:
            self._said_s[key] = now_s
            self._post(message)
        return is_new

    def _post(self, message: Message) -> None:
        self._post_to(self._settings, message)

    def _post_to(self, whom: AlertSettings | Escalation, message: Message) -> None:
        """Every message says in the end which bench it is of: one telephone hears of several."""
        message = Message(message.subject, f"{message.text}\n{self._bench_sentence}")
        deadline_s = self._settings.deadline_s
        if whom.command:
            self._outbox.send(message.subject, lambda: by_command(whom.command, message, deadline_s))
        if whom.urls:
            self._outbox.send(message.subject, lambda: by_apprise(whom.urls, message))

    @property
    def _ack(self) -> str:
        return f"calrig ack {shlex.quote(self._run)}"

    @property
    def _how_to_end(self) -> str:
        return f"\n{self._ack} ends the repeats."

    def _text(self, progress: Progress, since_utc: datetime | None = None) -> str:
        """Return what is told of a moment; of a run that stands still also since when, whether anything moves, what a
        person does first, and where the page will be: people are told before a full disk is asked.

        ``since_utc``: when the alarm began; now where it is told first.
        """
        if not is_unasked(progress.state, progress.requested_by):
            return line_of(progress)
        since = at_both(since_utc or self._clock.now_utc(), to_the_second=True)
        waits = "The run waits, and moves nothing until it goes on." if progress.state is State.HELD else ""
        to_do = self._to_do(progress.cause, progress.state)
        elsewhere = f"; where its disk takes nothing, {self._second_folder} does" if self._second_folder else ""
        moved = f"Since {since}. {progress.motion or waits}".rstrip()
        first = f"\nWhat to do: {to_do}" if to_do else ""
        return f"{line_of(progress)}\n{moved}{first}\nThe folder {self._run} holds why.txt and why.html{elsewhere}."


def bench_sentence(rig: str) -> str:
    """Say of which rig and of which computer a message is."""
    computer = f"on the computer {one_line(socket.gethostname())}"
    return f"Rig: {one_line(rig)}, {computer}." if rig else f"It comes from calrig {computer}."


def tell_people(
    settings: AlertSettings, clock: Clock, title: str, word: str, text: str, rig: str = ""
) -> Sequence[Mapping[str, object]]:
    """Tell what no run can tell, since there is none; returns what became of it, at the latest after the deadline."""
    dispatcher = AlertDispatcher(settings, title, clock, SilentObserver(), rig=rig)
    dispatcher.tell_end(word, text)
    return dispatcher.close()
