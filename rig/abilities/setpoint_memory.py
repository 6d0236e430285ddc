"""What calrig set a chamber to: compared with what the chamber says, since panel and other programs may set it as well.

A set point is written, read back, and written once more where it reads back otherwise; a chamber that stands is started
only then. Where that does not help the chamber is made harmless, as the device allows, and is written to no more.

From the first write until it was read back, whatever set point is found may be ours: a digit that the line turned
over. What is found otherwise after that somebody else set. It is a fault that a person looks at: it is not written
over, and a loop that was switched off is not switched on again: that belongs to the first set point of a session, or to
one that a person asks for by hand. A session is a process: what was set outlives lines that are opened anew.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from rig.errors import ChamberFault, DeviceRefused, RigError

DRIFTS = "it neither heats nor cools, and its air drifts to that of the room"


class SetpointMemory:
    """The set point of one chamber, as calrig wrote it."""

    def __init__(self, name: str, limits_degc: tuple[float, float]) -> None:
        """``limits_degc``: of the rig file, degrees Celsius."""
        self.name = name
        self._limits_degc = limits_degc
        self._written_degc: tuple[float, ...] = ()
        """The last is in force; those before it as well may be, until it was read back."""
        self._is_overruled = False
        self._given_up = ""
        """Why calrig writes to it no more; empty where it does."""
        self._corrections: list[str] = []
        self._pending = 0
        """Set points that were written and not read back since."""
        self._found_degc: float | None = None
        """The set point before the first of these, which stays where no write arrives."""
        self.is_on = False
        """Control was seen on since calrig set it."""

    @property
    def is_set(self) -> bool:
        return bool(self._written_degc)

    @property
    def is_pending(self) -> bool:
        """Return whether a set point was written, and not read back since."""
        return self._pending > 0

    @property
    def expected_degc(self) -> tuple[float, ...]:
        """What is in force where no digit was turned over: as found, or as written; the last one at the end."""
        found = () if self._found_degc is None else (self._found_degc,)
        return (*found, *self._written_degc)

    def overrule(self) -> None:
        """Let the next set point be written whatever somebody set since: a person asks for it."""
        self._is_overruled = True

    def begin(self, setpoint_degc: float, found_degc: float) -> None:
        """Take note of a set point before it is written: from now on it may be in force.

        ``found_degc``: the one that is in force before.
        """
        if self._is_overruled:
            self._forget()
        self._found_degc = self._found_degc if self.is_pending else found_degc
        self._written_degc, self._pending = (*self._written_degc, setpoint_degc), self._pending + 1

    def withdraw(self) -> None:
        """Take note that the last one was refused: the chamber did not take it."""
        self._written_degc, self._pending = self._written_degc[:-1], self._pending - 1

    def confirm(self) -> None:
        """Take note that the last one was read back, and control was seen on."""
        self._written_degc, self._pending, self.is_on = self._written_degc[-1:], 0, True

    def give_up(self, reason: str) -> None:
        """Write to the chamber no more in this session, but where a person asks for it by hand."""
        self._forget()
        self._given_up = reason

    def _forget(self) -> None:
        self._written_degc, self._pending, self._given_up = (), 0, ""
        self.is_on = self._is_overruled = False

    def correct(self, sentence: str) -> None:
        """Take note of a set point that was written again."""
        self._corrections.append(sentence)

    def take_corrections(self) -> tuple[str, ...]:
        """Return what was written again since this was asked last, a sentence each."""
        taken, self._corrections = tuple(self._corrections), []
        return taken

    def require_before_writing(self, found: Callable[[], Iterable["Otherwise"]]) -> None:
        """Refuse to write over what somebody set since, and to a chamber that was given up; see :meth:`require`."""
        if self._is_overruled:
            return
        if self._given_up:
            raise ChamberFault(f"{self.name}: calrig writes to it no more: {self._given_up}")
        self.require(found)

    def require(self, found: Callable[[], Iterable["Otherwise"]]) -> None:
        """Raise ChamberFault where the chamber is set otherwise; ``found`` returns in which respects."""
        if self.is_set and (otherwise := tuple(found())):
            raise ChamberFault(
                f"{self.name}: calrig set it to {self._written_degc[-1]:g} °C, and now"
                f" {' and '.join(respect.clause for respect in otherwise)}: somebody set it since, at the panel or by"
                f" another program; nothing was written over it: {otherwise[0].heading}; ask who and why, then begin"
                " anew, which sets it again"
            )

    def is_as_written(self, is_found: Callable[[float], bool]) -> bool:
        """Return whether a set point that was found, which ``is_found`` compares in the chamber's steps, is ours.

        While a set point is pending every one may be: :func:`settle` puts that right.
        """
        return self.is_pending or any(map(is_found, self._written_degc))

    def is_allowed(self, degc: float) -> bool:
        """Return whether a set point lies inside the limits of the rig file."""
        return self._limits_degc[0] <= degc <= self._limits_degc[1]

    def beyond(self, degc: float) -> str:
        """Say by which limits a set point is wrong; empty where it lies inside them."""
        low_degc, high_degc = self._limits_degc
        allowed = f"beyond {low_degc:g} to {high_degc:g} °C (environment.{self.name}: limits_degc)"
        return "" if self.is_allowed(degc) else f", {allowed}"

    def heading(self, degc: float) -> str:
        """Say where a chamber is heading that follows a set point."""
        return f"the chamber is heading for {degc:g} °C{self.beyond(degc)}"


@dataclass(frozen=True, slots=True)
class Otherwise:
    """One respect in which a chamber is not set as calrig set it."""

    clause: str
    heading: str = DRIFTS
    """Where its air goes by that."""


@runtime_checkable
class KeepsSetpointMemory(Protocol):
    """An environment that somebody may set beside calrig."""

    setpoint_memory: SetpointMemory


class WrittenChamber(KeepsSetpointMemory, Protocol):
    """A chamber whose set point is written and read back here."""

    def write_setpoint(self, setpoint_degc: float) -> None: ...

    def read_otherwise_degc(self, setpoint_degc: float) -> float | None:
        """Return the set point that is read back; None where it is ``setpoint_degc`` to the chamber's step."""

    def make_harmless(self) -> str:
        """Stop heating and cooling, or go back to a good set point; return what was done and seen, empty: nothing."""


def write_and_read_back(chamber: WrittenChamber, setpoint_degc: float, takes_later_degc: float | None = None) -> None:
    """Write a set point, read it back, and write it once more where it reads back otherwise.

    ``takes_later_degc``: a set point that may read back as well, of a chamber that takes a new one when it starts.

    Raises: ChamberFault where that does not help; the chamber was made harmless, or the sentence says where it heads.
    """
    memory = chamber.setpoint_memory
    try:
        chamber.write_setpoint(setpoint_degc)
    except DeviceRefused:
        memory.withdraw()
        raise
    found_degc = chamber.read_otherwise_degc(setpoint_degc)
    if found_degc is None or found_degc == takes_later_degc:
        return
    memory.correct(
        f"{memory.name}: set point {setpoint_degc:g} °C was written and reads back {found_degc:g} °C; written once more"
    )
    try:
        chamber.write_setpoint(setpoint_degc)
    except DeviceRefused as error:
        raise _given_up(chamber, f"set point {setpoint_degc:g} °C reads back", found_degc, f" ({error})") from error
    found_degc = chamber.read_otherwise_degc(setpoint_degc)
    if found_degc is not None and found_degc != takes_later_degc:
        raise _given_up(chamber, f"set point {setpoint_degc:g} °C was written twice and reads back", found_degc)


def settle(chamber: WrittenChamber) -> None:
    """Write the last set point again where one is pending, and another is in force than was found or written.

    Raises: as :func:`write_and_read_back`.
    """
    memory = chamber.setpoint_memory
    if memory.is_pending and None not in [chamber.read_otherwise_degc(degc) for degc in memory.expected_degc]:
        write_and_read_back(chamber, memory.expected_degc[-1])


def _given_up(chamber: WrittenChamber, written: str, found_degc: float, because: str = "") -> ChamberFault:
    """Make the chamber harmless, write to it no more; return its fault."""
    memory = chamber.setpoint_memory
    written = f"{written} {found_degc:g} °C{memory.beyond(found_degc)}{because}"
    try:
        done, why_not = chamber.make_harmless(), ""
    except RigError as error:
        done, why_not = "", f" ({error})"
    if done:
        sentence = f"{written}; {done}; look at its line, then at its panel, before it is started or set again"
    else:
        sentence = (
            f"the chamber is heading for {found_degc:g} °C: {written}, and calrig could not stop it{why_not};"
            " stop it at its panel"
        )
    memory.give_up(sentence)
    return ChamberFault(f"{memory.name}: {sentence}")


def carry_over(before: Mapping[str, object], after: Mapping[str, object]) -> None:
    """Let chambers whose lines were opened anew know what they were set to."""
    for name, chamber in after.items():
        known = before.get(name)
        if isinstance(chamber, KeepsSetpointMemory) and isinstance(known, KeepsSetpointMemory):
            chamber.setpoint_memory = known.setpoint_memory
