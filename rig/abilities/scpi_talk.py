"""What every driver of a SCPI instrument does: a setting read back, the error queue emptied, a burst left quietly."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rig.abilities.read_back import LONGEST_ERROR_LIST, READ_BACK_TOLERANCE
from rig.errors import DeviceFault, DeviceNonsense, DeviceRefused, LinkClosed, LinkLost
from rig.link.messages import MessageLine
from rig.wire import scpi

NOT_TAKEN = "no reading is taken; compare the rig file with what the unit offers"


def require(line: MessageLine, name: str, query: bytes, need: float, consequence: str = NOT_TAKEN) -> None:
    """Ask for a number that was set. Raises: DeviceRefused where it reads back otherwise."""
    got = line.ask(query, scpi.parse_number, idempotent=True)
    if abs(got - need) > READ_BACK_TOLERANCE * abs(need):
        raise DeviceRefused(
            f"{name}: {query.decode('ascii')} reads back {got:g}, it was set to {need:g}; {consequence}"
        )


def take_errors(line: MessageLine, name: str) -> list[tuple[int, str]]:
    """Ask until the queue is empty; asking takes the oldest one out. Raises: DeviceNonsense where it never ends."""
    errors: list[tuple[int, str]] = []
    while (error := line.ask(b"SYST:ERR?", scpi.parse_error, idempotent=False))[0]:
        errors.append(error)
        if len(errors) > LONGEST_ERROR_LIST:
            raise DeviceNonsense(f"{name}: more than {LONGEST_ERROR_LIST} errors; power it off and on")
    return errors


def clear_earlier_errors(line: MessageLine, name: str) -> None:
    """Empty the error queue of what earlier use left there. Raises: DeviceFault where it speaks of the unit itself."""
    harmful = [f"{number:+d} {text}" for number, text in take_errors(line, name) if scpi.is_harmful(number, text)]
    if harmful:
        raise DeviceFault(
            f"{name}: before anything was set: {', '.join(harmful)}; nothing is measured; the queue is empty now, so "
            "the unit says this once: have it looked at, and test it (*TST?) before it is used again"
        )


def require_no_error(line: MessageLine, name: str, after: str, consequence: str) -> None:
    """Empty the error queue. Raises: DeviceRefused with what stood in it."""
    if errors := take_errors(line, name):
        complaints = ", ".join(f"{number:+d} {text}" for number, text in errors)
        raise DeviceRefused(f"{name}: {after}: {complaints}; {consequence}; look at the unit's display")


@contextmanager
def quiet_unless_done(forget: Callable[[], object], quieten: Callable[[], object]) -> Iterator[None]:
    """Leave the unit at rest and everything to be set up again, whatever ends a burst early.

    ``quieten`` is not asked for where the link is gone: there is no line to stop it by.
    """
    try:
        yield
    except (LinkLost, LinkClosed):
        forget()
        raise
    except BaseException:
        forget()
        quieten()
        raise


def listed(numbers: tuple[float, ...]) -> str:
    """Return numbers for a message."""
    return ", ".join(f"{number:g}" for number in numbers)


def as_sent(value: float) -> bytes:
    """Return a number as it is sent."""
    return b"%.9g" % value
