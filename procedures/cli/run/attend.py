"""What surrounds a run that is started from the command line: screen, alerts, heartbeat, a machine that stays awake."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from procedures.alerts.addresses import usable_alerts
from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings
from procedures.cli.locations import JOURNAL, login_name
from procedures.cli.output import note
from procedures.cli.program_log import LoggedObserver
from procedures.cli.run.opening import Opening
from procedures.errors import ProcedureError
from procedures.journal.requests.corrections import acknowledge, is_acknowledged
from procedures.journal.sidecar.alert_record import (
    forget_acknowledgement,
    is_acknowledged_elsewhere,
    keep_outcomes,
    outcome_sentence,
)
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.status.stop_advice import advice_of
from procedures.observers.audience import with_observers
from procedures.records.progress import RunObserver
from procedures.run.progress import Lines, shown_on
from procedures.run.services import Pulse, RunServices
from procedures.run.watch.keep_awake import awake
from procedures.solution.sufficient import sufficient
from rig.clock import SystemClock
from rig.plain_text import shown


@dataclass(frozen=True, slots=True)
class Attendance:
    """What surrounds one run."""

    observer: RunObserver
    services: RunServices
    dispatcher: AlertDispatcher | None = None

    def ring_out(self, folder: Path) -> None:
        """Ring on with an alarm that others are to be told of; called after everything is delivered."""
        if self.dispatcher is not None:
            ring_out(folder, self.dispatcher)

    def tell_end(self, word: str, text: str) -> None:
        """Tell what the run came to, to whoever is told of its end."""
        if self.dispatcher is not None:
            self.dispatcher.tell_end(word, text)


def ring_out(folder: Path, dispatcher: AlertDispatcher) -> None:
    """Ring on with the alarm of a run that has ended, until it is acknowledged or others were told.

    Ctrl-C acknowledges it: somebody is there.
    """
    try:
        _tell_last(folder, dispatcher.ring_out(lambda: _is_known(folder)))
    except KeyboardInterrupt:
        try:
            acknowledge(folder, login_name(), "Ctrl-C")
        except ProcedureError as error:
            note(f"acknowledged, but not on record: {error}")


@contextmanager
def attended(opening: Opening, alerts: Path | None, run: Path) -> Iterator[Attendance]:
    """Observer and care of a run, which is told by its folder once nothing refuses it.

    In virtual time nobody is told, which is said where alerts are asked for, and nothing is kept awake.
    Raises: DescriptionError where the file of alerts is wrong.
    """
    opening.run = run
    tell = Lines(sys.stderr)

    def begun() -> None:
        opening.is_over = True
        tell(shown(str(run)))

    with ExitStack() as opened:
        if opening.is_virtual:
            if alerts is not None:
                note(f"{alerts}: read, but in virtual time nobody is told")
            screen = _screen(run, opened, tell)
            yield Attendance(screen, RunServices(begun=begun, enough=sufficient))
            return
        forget_acknowledgement(run.name)
        folder = second_folder()
        dispatcher, pulse = _dispatcher_and_pulse(opening, alerts, run, folder / run.name, opened, tell)
        services = RunServices(
            pulse=pulse, begun=begun, second_folder=folder, enough=sufficient, ring=ring_command(run, alerts)
        )
        try:
            yield Attendance(dispatcher, services, dispatcher)
        finally:
            opening.is_over |= dispatcher.has_heard


def ring_command(run: Path, alerts: Path | None) -> tuple[str, ...]:
    """Return what tells people of a run whose process has ended; its last word is to be what the stop guard knows."""
    whom = () if alerts is None else ("--alerts", str(alerts.absolute()))
    return (sys.executable, "-m", "procedures.cli.main", "ring", str(run.absolute()), *whom, "--record")


def _screen(run: Path, opened: ExitStack, tell: Lines) -> RunObserver:
    """Return what sees the run: the terminal, calrig's own log, observers of others."""
    screen = LoggedObserver(str(run), opened.enter_context(shown_on(sys.stderr, run)))
    return with_observers(screen, run, tell)


def _dispatcher_and_pulse(
    opening: Opening, alerts: Path | None, run: Path, folder: Path, opened: ExitStack, tell: Lines
) -> tuple[AlertDispatcher, Pulse]:
    settings = usable_alerts(alerts)
    refusal = opened.enter_context(awake(opening.title))
    screen, anywhere = _screen(run, opened, tell), str(run.absolute())
    dispatcher = AlertDispatcher(
        settings or AlertSettings(), opening.title, SystemClock(), screen, anywhere, str(folder), opening.rig,
        advice_of(anywhere),
    )  # fmt: skip
    dispatcher.stand_by()
    opened.callback(lambda: _tell_last(run, dispatcher.close()))
    first: list[Mapping[str, object]] = [{"what": "inhibitor", "failed": refusal}]

    def pulse() -> Sequence[Mapping[str, object]]:
        due, first[:] = list(first), []
        return [*due, *dispatcher.pulse()]

    return dispatcher, pulse


def _is_known(folder: Path) -> bool:
    """Return whether somebody knows of the alarm; by what was left beside its last words as well, since its journal may
    have been moved away.
    """
    with suppress(ProcedureError):
        if is_acknowledged(folder):
            return True
    return is_acknowledged_elsewhere(folder.name)


def _tell_last(run: Path, outcomes: Sequence[Mapping[str, object]]) -> None:
    """Tell what was not delivered once the journal was closed, and keep what became of all of it beside a run."""
    for outcome in outcomes:
        if outcome["failed"]:
            note(outcome_sentence(outcome))
    if (run / JOURNAL).exists():
        keep_outcomes(run, second_folder(), outcomes)
