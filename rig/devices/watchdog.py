"""The proof that a machine notices a silent host: by being silent for longer than it may allow, while nothing moves.

A time-out that was only set, or only read back, proves nothing: it may need a restart of the machine, another register
or another mode. Half the time-out must pass unnoticed (else a healthy run would end by it), a quarter more than it must
not.
"""

from collections.abc import Callable

from rig.devices.abilities import Wait
from rig.errors import DeviceFault

UNNOTICED, NOTICED = 0.5, 1.25
"""Silences in time-outs."""


def prove(name: str, watchdog_s: float, has_noticed: Callable[[], bool], wait: Wait, remedy: str) -> str:
    """Be silent twice; return what was seen.

    ``has_noticed`` asks, and thereby speaks. Raises: DeviceFault.
    """
    wait(UNNOTICED * watchdog_s)
    if has_noticed():
        raise DeviceFault(
            f"{name}: the machine stopped by itself after {UNNOTICED * watchdog_s:g} s of silence, its watchdog should"
            f" allow {watchdog_s:g} s (axes.{name}: watchdog_s); nothing moved; {remedy}"
        )
    wait(NOTICED * watchdog_s)
    if not has_noticed():
        raise DeviceFault(
            f"{name}: the machine did not notice a silence of {NOTICED * watchdog_s:g} s, its watchdog should act after"
            f" {watchdog_s:g} s (axes.{name}: watchdog_s); nothing moved; {remedy}, or leave watchdog_s out: then"
            " nothing stops a turning axis when this computer dies"
        )
    return (
        f"watchdog of {watchdog_s:g} s: {UNNOTICED * watchdog_s:g} s of silence passed,"
        f" {NOTICED * watchdog_s:g} s were noticed"
    )
