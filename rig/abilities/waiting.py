"""Waiting for a device to say that it is ready: polled, in slices, with a limit that both clocks must reach."""

from collections.abc import Callable

from rig.abilities.abilities import Wait
from rig.clock import Clock
from rig.errors import DeviceSilent

FIRST_PAUSE_S = 0.002
LONGEST_PAUSE_S = 0.1


def wait_until(
    is_so: Callable[[], bool],
    wait: Wait,
    clocks: tuple[Clock, Clock],
    limit_s: float,
    complaint: Callable[[], str],
) -> None:
    """Ask ``is_so`` with growing pauses until it is.

    ``clocks`` are the rig's and the link's: where rig time runs scaled, a port still needs its own seconds, so
    ``limit_s`` must have passed on both. Raises: DeviceSilent, and what ``wait`` raises.
    """
    ends_s = [clock.monotonic_s() + limit_s for clock in clocks]
    pause_s = FIRST_PAUSE_S
    while not is_so():
        if all(clock.monotonic_s() >= end_s for clock, end_s in zip(clocks, ends_s, strict=True)):
            raise DeviceSilent(complaint())
        wait(pause_s)
        pause_s = min(2.0 * pause_s, LONGEST_PAUSE_S)
