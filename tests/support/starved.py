"""How long whoever tests waited for a processor: a promise in seconds is one of a machine that has one."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rig.clock import SystemClock

_NAP_S = 0.005
HANDS = 4
"""A page, its server, the bench and the machine: each waits for a processor as this process does."""


class Starved:
    """Measured beside a test, from its beginning."""

    def __init__(self) -> None:
        self._longest_s = 0.0
        self._is_over = threading.Event()

    @property
    def allowance_s(self) -> float:
        """So much later than promised may what several processes do be: nothing on a machine that is quiet."""
        return HANDS * self._longest_s

    def measure(self) -> None:
        clock = SystemClock()
        while not self._is_over.is_set():
            before_s = clock.monotonic_s()
            clock.sleep(_NAP_S)
            self._longest_s = max(self._longest_s, clock.monotonic_s() - before_s - 2.0 * _NAP_S)

    def end(self) -> None:
        self._is_over.set()


@contextmanager
def starved() -> Iterator[Starved]:
    """Measure while inside."""
    meter = Starved()
    thread = threading.Thread(target=meter.measure, daemon=True)
    thread.start()
    try:
        yield meter
    finally:
        meter.end()
        thread.join()
