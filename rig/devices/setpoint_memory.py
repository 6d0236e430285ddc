"""What calrig set a chamber to: compared with what the chamber says, since panel and other programs may set it as well.

What somebody set otherwise is a fault that a person looks at. It is not written over, and a loop that was switched off
is not switched on again: that belongs to the first set point of a session, or to one that a person asks for by hand.
A session is a process: what was set outlives lines that are opened anew.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol, runtime_checkable

from rig.errors import DeviceFault


class SetpointMemory:
    """The set point of one chamber, as calrig wrote it."""

    def __init__(self) -> None:
        self._written_degc: tuple[float, ...] = ()
        """The last is in force; those before it as well may be, until it was read back."""
        self._is_overruled = False
        self.is_on = False
        """Control was seen on since calrig set it."""

    @property
    def is_set(self) -> bool:
        return bool(self._written_degc)

    def overrule(self) -> None:
        """Let the next set point be written whatever somebody set since: a person asks for it."""
        self._is_overruled = True

    def begin(self, setpoint_degc: float) -> None:
        """Take note of a set point before it is written: from now on it may be in force."""
        if self._is_overruled:
            self._written_degc, self.is_on, self._is_overruled = (), False, False
        self._written_degc = (*self._written_degc, setpoint_degc)

    def confirm(self) -> None:
        """Take note that the last one was read back, and control was seen on."""
        self._written_degc, self.is_on = self._written_degc[-1:], True

    def require_before_writing(self, name: str, found: Callable[[], Iterable[str]]) -> None:
        """Refuse to write over what somebody set since; see :meth:`require`."""
        if not self._is_overruled:
            self.require(name, found)

    def require(self, name: str, found: Callable[[], Iterable[str]]) -> None:
        """Raise DeviceFault where the chamber is set otherwise; ``found`` returns in which respects, a clause each."""
        if self.is_set and (clauses := tuple(found())):
            raise DeviceFault(
                f"{name}: calrig set it to {self._written_degc[-1]:g} °C, and now {' and '.join(clauses)}: somebody set"
                " it since, at the panel or by another program; nothing was written over it; ask who and why, then"
                " begin anew, which sets it again"
            )

    def is_as_written(self, is_found: Callable[[float], bool]) -> bool:
        """Return whether a set point that was found, which ``is_found`` compares in the chamber's steps, is ours."""
        return any(map(is_found, self._written_degc))


@runtime_checkable
class KeepsSetpointMemory(Protocol):
    """An environment that somebody may set beside calrig."""

    setpoint_memory: SetpointMemory


def carry_over(before: Mapping[str, object], after: Mapping[str, object]) -> None:
    """Let chambers whose lines were opened anew know what they were set to."""
    for name, chamber in after.items():
        known = before.get(name)
        if isinstance(chamber, KeepsSetpointMemory) and isinstance(known, KeepsSetpointMemory):
            chamber.setpoint_memory = known.setpoint_memory
