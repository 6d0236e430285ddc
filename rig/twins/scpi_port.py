"""The outside of a SCPI instrument's twin: messages in, answers out, an error queue, on a line or on a GPIB bus.

It takes messages apart and obeys command by command, in order; an answer that is not due yet holds everything
behind it. What the commands mean is the business of the unit behind.
"""

from collections import deque
from collections.abc import Callable, Mapping
from typing import Protocol

from rig.wire import scpi

LONGEST_MESSAGE = 4096
LONGEST_QUEUE = 10

Error = tuple[int, str]
UNDEFINED_HEADER: Error = (-113, "Undefined header")
SETTINGS_CONFLICT: Error = (-221, "Settings conflict")
OUT_OF_RANGE: Error = (-222, "Data out of range")
ILLEGAL_VALUE: Error = (-224, "Illegal parameter value")
DATA_STALE: Error = (-230, "Data corrupt or stale")
TOO_MANY_ERRORS: Error = (-350, "Too many errors")
INPUT_OVERRUN: Error = (-363, "Input buffer overrun")
MESSAGE_AVAILABLE, ERRORS_WAIT = 16, 4
"""Bits of the status byte."""


class Refused(Exception):
    """The unit does not do what it was told; carries the entry of the error queue."""

    def __init__(self, error: Error) -> None:
        super().__init__(*error)
        self.error = error


class ScpiUnit(Protocol):
    """The instrument behind the port."""

    words: Mapping[str, str]
    """Long form of every header word to its short form."""

    def answered_from_s(self, header: str) -> float | None:
        """Return when ``header`` can be obeyed, None for now."""

    def expand(self, header: str, parameters: str) -> tuple[tuple[str, str], ...] | None:
        """Return the commands that ``header`` stands for, None where it stands for itself."""

    def obey(self, header: str, parameters: str, now_s: float) -> bytes | None:
        """Do what it says and return the answer, None where there is none. Raises: Refused."""

    def advance(self, now_s: float) -> None:
        """Let everything happen that is due by ``now_s``."""


class ScpiPort:
    """A :class:`rig.twins.twin.Twin`, and an instrument for :class:`rig.twins.prologix.PrologixTwin`."""

    def __init__(self, unit: ScpiUnit, format_error: Callable[[int, str], bytes] = scpi.format_error) -> None:
        self.unit = unit
        self._format_error = format_error
        self.errors: deque[Error] = deque()
        self._received = b""
        self._pending: deque[tuple[str, str]] = deque()
        self._answers: list[bytes] = []
        self._due = b""

    def receive(self, data: bytes, now_s: float) -> None:
        *lines, rest = (self._received + data).split(b"\n")
        for line in lines:
            self._take(line, now_s)
        self._received = rest
        if len(rest) > LONGEST_MESSAGE:
            self._received = b""
            self._refuse(INPUT_OVERRUN)

    def transmit(self, now_s: float) -> bytes:
        self._work(now_s)
        due, self._due = self._due, b""
        return due

    def next_event_s(self) -> float | None:
        return self.unit.answered_from_s(self._pending[0][0]) if self._pending else None

    def listen(self, message: bytes, now_s: float) -> float:
        self._due = b""
        for line in message.split(b"\n"):
            self._take(line, now_s)
        return now_s

    def talk(self, now_s: float) -> tuple[bytes, bool]:
        said = self.transmit(now_s)
        return said, bool(said)

    def next_talk_s(self) -> float | None:
        return self.next_event_s()

    def serial_poll(self, now_s: float) -> int:
        self._work(now_s)
        return (MESSAGE_AVAILABLE if self._due else 0) | (ERRORS_WAIT if self.errors else 0)

    def clear(self, now_s: float) -> None:  # noqa: ARG002 it takes no time
        self._received = self._due = b""
        self._pending.clear()
        self._answers.clear()

    def advance(self, now_s: float) -> None:
        self._work(now_s)

    def _take(self, line: bytes, now_s: float) -> None:
        commands = [
            (self._short(header), parameters)
            for header, parameters in scpi.split_message(line.decode("latin-1").strip())
        ]
        if commands:
            self._pending += [*commands, ("", "")]
            self._work(now_s)

    def _work(self, now_s: float) -> None:
        self.unit.advance(now_s)
        while self._pending:
            header, parameters = self._pending[0]
            free_s = self.unit.answered_from_s(header)
            if free_s is not None and now_s < free_s:
                return
            self._pending.popleft()
            if header:
                self._obey(header, parameters, now_s)
            elif self._answers:
                self._due += b";".join(self._answers) + b"\n"
                self._answers.clear()

    def _obey(self, header: str, parameters: str, now_s: float) -> None:
        if header == "SYST:ERR?":
            self._answers.append(self._format_error(*(self.errors.popleft() if self.errors else scpi.NO_ERROR)))
        elif header == "*CLS":
            self.errors.clear()
        elif header == "*STB?":
            self._answers.append(b"%+d" % (ERRORS_WAIT if self.errors else 0))
        elif expanded := self.unit.expand(header, parameters):
            self._pending.extendleft(reversed(expanded))
        else:
            try:
                answer = self.unit.obey(header, parameters, now_s)
            except Refused as refused:
                self._refuse(refused.error)
            else:
                self._answers += [answer] if answer is not None else []

    def _refuse(self, error: Error) -> None:
        if len(self.errors) < LONGEST_QUEUE:
            self.errors.append(error)
        else:
            self.errors[-1] = TOO_MANY_ERRORS

    def _short(self, header: str) -> str:
        """Return every word in its short form, the node SENSe left out."""
        query = "?" if header.endswith("?") else ""
        words = [self.unit.words.get(word, word) for word in header.removesuffix("?").split(":")]
        return ":".join(words[1:] if len(words) > 1 and words[0] == "SENS" else words) + query
