"""What surrounds a run that is started from the command line: screen, alerts, heartbeat, a machine that stays awake."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_state_path

from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings, default_alerts, read_alerts
from procedures.cli.output import note
from procedures.cli.own_log import LoggedObserver
from procedures.cli.places import login_name
from procedures.errors import ProcedureError
from procedures.journal.corrections import acknowledge, is_acknowledged
from procedures.observers.audience import with_observers
from procedures.records.progress import RunObserver
from procedures.run.progress import shown_on
from procedures.run.services import Pulse, RunServices
from procedures.run.watch.keep_awake import awake
from procedures.solution.sufficient import sufficient
from rig.clock import SystemClock


@dataclass(frozen=True, slots=True)
class Attendance:
    """What surrounds one run."""

    observer: RunObserver
    services: RunServices
    dispatcher: AlertDispatcher | None = None

    def ring_out(self, folder: Path) -> None:
        """Ring on with an alarm that others are to be told of, until it is acknowledged.

        Called after everything is delivered.

        Ctrl-C acknowledges it: somebody is there.
        """
        if self.dispatcher is None:
            return
        try:
            _tell_losses(self.dispatcher.ring_out(lambda: _is_known(folder)))
        except KeyboardInterrupt:
            try:
                acknowledge(folder, login_name(), "Ctrl-C")
            except ProcedureError as error:
                note(f"acknowledged, but not on record: {error}")

    def tell_end(self, word: str, text: str) -> None:
        """Tell what the run came to, to whoever is told of its end."""
        if self.dispatcher is not None:
            self.dispatcher.tell_end(word, text)


@contextmanager
def attended(title: str, alerts: Path | None, run: Path, *, is_virtual: bool) -> Iterator[Attendance]:
    """Observer and care of a run, which is told by its folder once nothing refuses it.

    In virtual time nobody is told and nothing is kept awake.

    Raises: DescriptionError where the file of alerts is wrong.
    """

    def begun() -> None:
        note(str(run))

    with ExitStack() as opened:
        if is_virtual:
            screen = _screen(run, opened)
            yield Attendance(screen, RunServices(begun=begun, enough=sufficient))
            return
        second_place = user_state_path("calrig") / "emergency"
        dispatcher, pulse = _dispatcher_and_pulse(title, alerts, run, second_place / run.name, opened)
        yield Attendance(
            dispatcher, RunServices(pulse=pulse, begun=begun, second_place=second_place, enough=sufficient), dispatcher
        )


def _screen(run: Path, opened: ExitStack) -> RunObserver:
    """Return what sees the run: the terminal, calrig's own log, observers of others."""
    shown = LoggedObserver(str(run), opened.enter_context(shown_on(sys.stderr, run)))
    return with_observers(shown, run, note)


def _dispatcher_and_pulse(
    title: str, alerts: Path | None, run: Path, second_place: Path, opened: ExitStack
) -> tuple[AlertDispatcher, Pulse]:
    settings = read_alerts(alerts) if alerts is not None else default_alerts()
    refusal = opened.enter_context(awake(title))
    screen = _screen(run, opened)
    dispatcher = AlertDispatcher(settings or AlertSettings(), title, SystemClock(), screen, str(run), str(second_place))
    opened.callback(lambda: _tell_losses(dispatcher.close()))
    first: list[Mapping[str, object]] = [{"what": "inhibitor", "failed": refusal}]

    def pulse() -> Sequence[Mapping[str, object]]:
        due, first[:] = list(first), []
        return [*due, *dispatcher.pulse()]

    return dispatcher, pulse


def _is_known(folder: Path) -> bool:
    """Return whether somebody knows of the alarm; a journal that cannot be read tells of nobody."""
    try:
        return is_acknowledged(folder)
    except ProcedureError:
        return False


def _tell_losses(outcomes: Sequence[Mapping[str, object]]) -> None:
    for outcome in outcomes:
        if outcome["failed"]:
            note(f"{outcome['what']}: not delivered: {outcome['failed']}")
