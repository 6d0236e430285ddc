"""The proof that a machine notices a silent host: by being silent for longer than it may allow, while nothing moves.

A time-out that was only set, or only read back, proves nothing: it may need a restart of the machine, another register
or another mode. Half the time-out must pass unnoticed (else a healthy run would end by it), a quarter more than it must
not.
"""

from collections.abc import Callable

from rig.abilities.abilities import Wait
from rig.clock import Clock
from rig.errors import DeviceFault

UNNOTICED, NOTICED = 0.5, 1.25
"""Silences in time-outs."""


def prove(name: str, watchdog_s: float, has_noticed: Callable[[], bool], wait: Wait, clock: Clock, remedy: str) -> str:
    """Be silent twice; return what was seen, with the silences as they were and not as they were meant.

    ``has_noticed`` asks, and thereby speaks. Raises: DeviceFault.
    """
    passed_s, is_noticed = _after_silence(UNNOTICED * watchdog_s, has_noticed, wait, clock)
    if is_noticed and passed_s >= watchdog_s:
        raise DeviceFault(
            f"{name}: this computer was silent for {passed_s:.3g} s where {UNNOTICED * watchdog_s:g} s were meant,"
            f" longer than its watchdog allows ({watchdog_s:g} s; axes.{name}: watchdog_s), and the machine stopped;"
            " nothing moved; nothing is proven: find what keeps this computer from its work, or allow more"
        )
    if is_noticed:
        raise DeviceFault(
            f"{name}: the machine stopped by itself after {passed_s:.3g} s of silence, its watchdog should"
            f" allow {watchdog_s:g} s (axes.{name}: watchdog_s); nothing moved; {remedy}"
        )
    noticed_s, is_noticed = _after_silence(NOTICED * watchdog_s, has_noticed, wait, clock)
    if not is_noticed:
        raise DeviceFault(
            f"{name}: the machine did not notice a silence of {noticed_s:.3g} s, its watchdog should act after"
            f" {watchdog_s:g} s (axes.{name}: watchdog_s); nothing moved; {remedy}, or leave watchdog_s out: then"
            " nothing stops a turning axis when this computer dies"
        )
    return f"watchdog of {watchdog_s:g} s: {passed_s:.3g} s of silence passed, {noticed_s:.3g} s were noticed"


def _after_silence(meant_s: float, has_noticed: Callable[[], bool], wait: Wait, clock: Clock) -> tuple[float, bool]:
    """Return how long nothing was said, and whether the machine noticed."""
    since_s = clock.monotonic_s()
    wait(meant_s)
    silent_s = clock.monotonic_s() - since_s
    return silent_s, has_noticed()
