"""How a machine is started: once only, since a start that is sent twice may move twice."""

from collections.abc import Callable

from rig.errors import DeviceNonsense, DeviceSilent


def start_once(send: Callable[[], object], has_started: Callable[[], bool]) -> None:
    """Send a start. Where its acknowledgement is lost or damaged, the machine itself is asked whether it started.

    Raises: what ``send`` raises, where it has not.
    """
    try:
        send()
    except (DeviceSilent, DeviceNonsense):
        if not has_started():
            raise
