"""``calrig attach`` and ``calrig status --follow``: a run that another process runs, as it goes on, and its keys.

The screen is a reader: it reads the journal by the follower and asks by the spool, so that whatever becomes of it the
run does not notice.
"""

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from procedures.cli.output import note
from procedures.errors import ExitStatus, RequestError
from procedures.journal.requests.spool import ask
from procedures.journal.sidecar.live import read_live
from procedures.journal.status.follower import Follower, News
from procedures.journal.status.standing import RunStatus, progress_of
from procedures.journal.status.standing_words import live_rows
from procedures.journal.status.status import status
from procedures.records.progress import Progress, RunObserver
from procedures.records.states import ACTIVE, EXIT_STATUS
from procedures.run.progress import shown_on
from rig.clock import Clock, SystemClock
from rig.system_parts import module_here

LOOK_S = 0.25
SIGN_EVERY_S = 60.0
DWELL_PHASES = ("", "moving", "settling", "reading")
"""What the line of a dwell will tell soon."""
Steering = Literal["pause", "continue", "stop", "abort"]
KEYS: dict[str, Steering] = {"p": "pause", "c": "continue", "s": "stop", "a": "abort"}
LEAVE = ("q", "\x04")
HELP = "p pauses, c continues, s stops after the dwell, a twice aborts, q leaves; the run goes on without this screen"


def follow(folder: Path, observer: RunObserver, is_left: Callable[[], bool], clock: Clock) -> RunStatus:
    """Tell the observer of everything from now on until no process runs the run, or the person leaves."""
    with closing(Follower(folder, with_dwells=False, clock=clock)) as follower:
        news = follower.poll()
        observer.on_event(progress_of("state", news.status, news.status.why))
        signs = _SignsOfLife(folder, clock)
        while news.status.state in ACTIVE and not is_left():
            clock.sleep(LOOK_S)
            news = follower.poll()
            for progress in _progress_of(news):
                observer.on_event(progress)
            if sign := signs.due():
                observer.on_event(progress_of("soak", news.status, sign))
        return news.status


class _SignsOfLife:
    """What a run is at where no dwell tells it: at once, and every minute while it lasts."""

    def __init__(self, folder: Path, clock: Clock) -> None:
        self._folder = folder
        self._clock = clock
        self._phase = ""
        self._announced_s = 0.0

    def due(self) -> str:
        """Return what is to be told now; empty where nothing is."""
        live, now_s = read_live(self._folder), self._clock.monotonic_s()
        phase = "" if live is None or live.phase in DWELL_PHASES else live.phase
        if live is None or not phase or (phase == self._phase and now_s - self._announced_s < SIGN_EVERY_S):
            self._phase = phase
            return ""
        self._phase, self._announced_s = phase, now_s
        return "; ".join(f"{name} {text}" for name, text in live_rows(live, self._clock.now_utc()))


def attach_to(folder: Path, by: str, clock: Clock | None = None) -> int:
    """Show a run with its keys until it ends or the person leaves. Raises: RequestError where no process runs it."""
    clock = clock or SystemClock()
    with closing(Follower(folder, with_dwells=False, clock=clock)) as follower:
        found = follower.poll().status
    if found.state not in ACTIVE:
        raise RequestError(
            f"{folder}: no process runs this run, it is {found.state}; nothing can be shown as it goes on; calrig "
            "status and calrig handover tell of it"
        )
    with shown_on(sys.stderr, folder) as observer, _keys(folder, by) as is_left:
        return shown_until_left(folder, observer, is_left, clock)


def shown_until_left(folder: Path, observer: RunObserver, is_left: Callable[[], bool], clock: Clock) -> int:
    """Return the exit status of the screen: that of the run where it has ended. Ctrl-C leaves it; the run goes on."""
    try:
        found = follow(folder, observer, is_left, clock)
    except KeyboardInterrupt:
        found = status(folder)
    if found.state in ACTIVE:
        note(f"{folder}: goes on; calrig attach {folder} shows it again")
        return ExitStatus.DONE
    note(f"{folder}: {found.state}{f': {found.why}' if found.why else ''}")
    return EXIT_STATUS.get(found.state, ExitStatus.FAILED)


def _progress_of(news: News) -> Iterator[Progress]:
    for event in news.events:
        detail = event.detail
        match event.kind:
            case "dwell":
                reasons = detail.get("reasons")
                listed = "; ".join(map(str, reasons)) if isinstance(reasons, list) else ""
                yield progress_of("dwell" if detail.get("accepted") else "rejected", news.status, listed)
            case "state":
                yield progress_of("state", news.status, news.status.why)
            case "request" if detail.get("refused"):
                yield progress_of("refused", news.status, str(detail["refused"]))
            case "terminal" | "lease" | "note" | "ack":
                yield progress_of("void", news.status, f"{detail.get('by', '')}: {detail.get('text', '')}".lstrip(": "))


@contextmanager
def _keys(folder: Path, by: str) -> Iterator[Callable[[], bool]]:
    """Yield what asks whether the person has left and meanwhile obeys the keys; some systems have none."""
    termios, tty = module_here("termios"), module_here("tty")
    if not sys.stdin.isatty() or termios is None or tty is None:
        yield lambda: False
        return
    handle = sys.stdin.fileno()
    before = termios.tcgetattr(handle)
    note(HELP)
    pressed: list[str] = []
    try:
        tty.setcbreak(handle)
        yield lambda: _obey(handle, folder, by, pressed)
    finally:
        termios.tcsetattr(handle, termios.TCSADRAIN, before)


def _obey(handle: int, folder: Path, by: str, pressed: list[str]) -> bool:
    while select.select([handle], [], [], 0.0)[0]:
        typed = os.read(handle, 64).decode("utf-8", errors="replace")
        for key in typed:
            pressed.append(key)
            if key in LEAVE:
                return True
            if key == "a" and pressed[-2:] != ["a", "a"]:
                note("a again aborts: every axis stops at once")
            elif key in KEYS:
                kind = KEYS[key]
                try:
                    ask(folder, kind, by, datetime.now(UTC))
                except RequestError as error:
                    note(str(error))
                else:
                    note(f"asked to {kind}")
                pressed.clear()
        if not typed:
            return True
    return False
