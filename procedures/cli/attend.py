"""What surrounds a run that is started from the command line: screen, alerts, heartbeat, a machine that stays awake."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from procedures.cli.output import note

if TYPE_CHECKING:
    from procedures.run.care import Care, Pulse
    from procedures.run.progress import RunObserver


@contextmanager
def attended(title: str, alerts: Path | None, *, is_virtual: bool) -> "Iterator[tuple[RunObserver, Care]]":
    """Observer and care of a run. In virtual time nobody is told and nothing is kept awake.

    Raises: DescriptionError where the file of alerts is wrong.
    """
    from platformdirs import user_state_path

    from procedures.run.care import Care
    from procedures.run.progress import shown_on

    with ExitStack() as opened:
        if is_virtual:
            yield opened.enter_context(shown_on(sys.stderr)), Care()
            return
        screen, pulse = _told(title, alerts, opened)
        yield screen, Care(pulse=pulse, second_place=user_state_path("calrig") / "emergency")


def _told(title: str, alerts: Path | None, opened: ExitStack) -> "tuple[RunObserver, Pulse]":
    from procedures.alerts.desk import AlertDesk
    from procedures.alerts.settings import AlertSettings, default_alerts, read_alerts
    from procedures.run.inhibit import awake
    from procedures.run.progress import shown_on
    from rig.clock import SystemClock

    settings = read_alerts(alerts) if alerts is not None else default_alerts()
    refusal = opened.enter_context(awake(title))
    screen = opened.enter_context(shown_on(sys.stderr))
    desk = AlertDesk(settings or AlertSettings(), title, SystemClock(), screen)
    opened.callback(lambda: _tell_losses(desk.close()))
    first: list[Mapping[str, object]] = [{"what": "inhibitor", "failed": refusal}]

    def pulse() -> Sequence[Mapping[str, object]]:
        due, first[:] = list(first), []
        return [*due, *desk.pulse()]

    return desk, pulse


def _tell_losses(outcomes: Sequence[Mapping[str, object]]) -> None:
    for outcome in outcomes:
        if outcome["failed"]:
            note(f"{outcome['what']}: not delivered: {outcome['failed']}")
