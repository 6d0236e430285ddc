"""Ctrl-C, SIGTERM and a lost terminal as a request that the next look of a wait passes on: no move goes unwatched.

Where nothing moves they end what is done at once, and its command says what is missing.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from procedures.run.steering import job_control_ignored
from rig.abilities.abilities import Wait
from rig.clock import Clock
from rig.errors import WaitEnded
from rig.system_parts import ENDS, present


@contextmanager
def stoppable_wait(clock: Clock) -> Iterator[Wait]:
    """Yield a :class:`Wait` that a signal ends: within a tenth of a second, and before the caller goes on."""
    signals: list[str] = []

    def ask(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  the signature of a handler
        signals.append(signal.Signals(number).name)

    def wait(duration_s: float) -> None:
        left_s = duration_s
        while True:
            if signals:
                raise WaitEnded(f"stopped by {signals[0]}; the axis was stopped where it was")
            if left_s <= 0.0:
                return
            clock.sleep(min(left_s, clock.slice_s))
            left_s -= clock.slice_s

    heeded = [number for number in ENDS if signal.getsignal(number) is not signal.SIG_IGN]  # nohup means it
    before = {number: signal.signal(number, ask) for number in heeded}
    try:
        with job_control_ignored():
            yield wait
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def ending_with_a_word() -> Iterator[None]:
    """Inside, what asks a program to end raises KeyboardInterrupt as Ctrl-C does, with the signal's name.

    So what is half done is taken back, and the command tells its end. In any thread but the main one, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  the signature of a handler
        raise KeyboardInterrupt(signal.Signals(number).name)

    before = {number: signal.signal(number, end) for number in present("SIGTERM", "SIGBREAK", "SIGQUIT")}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
