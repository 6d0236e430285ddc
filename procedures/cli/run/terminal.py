"""The terminal of a run: it may be closed, suspended or sent to the background, and the run goes on.

A signal that was ignored when the command began (``nohup``) stays ignored where nothing is shown on a terminal; where
something is, it ends nothing either.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from procedures.run.steering import HANG_UP, job_control_ignored


@contextmanager
def outlived() -> Iterator[None]:
    """Inside, a hang-up only sends to nowhere what would have gone to the terminal, and nothing suspends us."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    shown = [handle for handle in (0, 1, 2) if _is_terminal(handle)]

    def hung_up(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  the signature of a handler
        nowhere = os.open(os.devnull, os.O_RDWR)
        for handle in shown:
            os.dup2(nowhere, handle)
        os.close(nowhere)

    before = {number: signal.getsignal(number) for number in HANG_UP}
    for number, handler in before.items():
        if shown or handler is not signal.SIG_IGN:  # ignored by a shell: what is written to the lost terminal fails
            signal.signal(number, hung_up)
    try:
        with job_control_ignored():
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_terminal(handle: int) -> bool:
    try:
        return os.isatty(handle)
    except OSError:
        return False
