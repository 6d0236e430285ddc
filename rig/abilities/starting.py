"""How a machine is started: once only, since a start that is sent twice may move twice."""

from collections.abc import Callable

from rig.clock import Clock
from rig.errors import DeviceFault, DeviceNonsense, DeviceSilent

TAKEN_UP_S = 0.5
"""A start that was heard shows itself within this time; a public driver looks 40 ms later."""
_BETWEEN_LOOKS_S = 0.02


def start_once(send: Callable[[], object], has_started: Callable[[], bool]) -> None:
    """Send a start. Where its acknowledgement is lost or damaged, the machine itself is asked whether it started.

    Raises: what ``send`` raises, where it has not.
    """
    try:
        send()
    except (DeviceSilent, DeviceNonsense):
        if not has_started():
            raise


def see_taken_up(has_begun: Callable[[], bool], clock: Clock, unseen: str) -> None:
    """Look until the machine shows that it took up what it was told: what was only sent may be lost on the line.

    Raises: DeviceFault with ``unseen``, where it does not within :data:`TAKEN_UP_S`.
    """
    limit_s = clock.monotonic_s() + TAKEN_UP_S
    while not has_begun():
        if clock.monotonic_s() >= limit_s:
            raise DeviceFault(unseen)
        clock.sleep(_BETWEEN_LOOKS_S)
