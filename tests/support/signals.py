"""Signals as a program in a terminal has them, whoever started the tests.

``nohup`` ignores SIGHUP, a shell's background ignores SIGINT, and a process hands what it ignores to its children.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

FROM_A_TERMINAL = {
    signal.SIGHUP: signal.SIG_DFL,
    signal.SIGINT: signal.default_int_handler,
    signal.SIGQUIT: signal.SIG_DFL,
    signal.SIGTERM: signal.SIG_DFL,
}


def take_default_signals() -> None:
    """Let the terminal's signals do what they do by default."""
    for number, handler in FROM_A_TERMINAL.items():
        signal.signal(number, handler)


@contextmanager
def default_signals() -> Iterator[None]:
    """Take the defaults for the length of the context; what was ignored before is ignored again."""
    before = {number: signal.getsignal(number) for number in FROM_A_TERMINAL}
    take_default_signals()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
