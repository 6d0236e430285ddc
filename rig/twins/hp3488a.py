"""The twin of an HP 3488A scanner: latching relays that take a moment to move, several closed at a time if told so.

Source: HP 3488A operating manual as used by gpib-utils' hp3488 (answers of ID?, VIEW, CTYPE, ERROR; status byte);
3499A user's manual p. 230 (44470A: "multiple channels closed at the same time").
"""

import re
from collections.abc import Callable, Mapping

from rig.wire import hp3488a as wire

RELAY_S = 0.006
"""From the command to the contact at rest."""
MOVING = ("CLOSE", "OPEN", "CRESET")

_COMMAND = re.compile(r"([A-Z]+\??) *([\d, ]*)")


class Hp3488aTwin:
    """A GPIB instrument: ``cards`` are model numbers by slot."""

    def __init__(self, cards: Mapping[int, str] | None = None) -> None:
        self._cards = dict(cards) if cards is not None else {1: "44470"}
        self.missing: dict[int, frozenset[int]] = {}
        """Slot to channels that a 44471 lacks, as a 44476 and a 44477 do, which call themselves so."""
        self.welded: set[int] = set()
        """Contacts that stay closed whatever their relay is told: that VIEW sees contacts is stated nowhere."""
        self._closed: set[int] = set()
        self._errors = 0
        self._reply = b""
        self._ready_s = float("-inf")
        self._commands: dict[str, Callable[[str], None]] = {
            "ID?": lambda _argument: self._say(wire.IDENTITY),
            "CLOSE": self._close,
            "OPEN": self._open,
            "VIEW": self._view,
            "CTYPE": self._card_type,
            "CRESET": self._reset_card,
            "ERROR": self._report_errors,
            "DON": lambda _argument: None,
            "DOFF": lambda _argument: None,
        }

    def closed_channels(self) -> frozenset[int]:
        """Return whose contacts are closed: what is connected to the meter."""
        return frozenset(self._closed | self.welded)

    def listen(self, message: bytes, now_s: float) -> float:
        for text in message.decode("latin-1").upper().replace(";", "\n").split("\n"):
            if command := text.strip():
                self._execute(command)
                if command.startswith(MOVING):
                    self._ready_s = now_s + RELAY_S
        return now_s

    def talk(self, _now_s: float) -> tuple[bytes, bool]:
        reply, self._reply = self._reply, b""
        return reply, bool(reply)

    def next_talk_s(self) -> float | None:
        return None

    def serial_poll(self, now_s: float) -> int:
        ready = wire.Status.READY if now_s >= self._ready_s else 0
        output = wire.Status.OUTPUT if self._reply else 0
        return int(ready) | int(output) | (int(wire.Status.ERROR) if self._errors else 0)

    def clear(self, now_s: float) -> None:
        self._closed.clear()
        self._reply = b""
        self._ready_s = now_s + RELAY_S

    def advance(self, _now_s: float) -> None:
        return None

    def _execute(self, text: str) -> None:
        match = _COMMAND.fullmatch(text)
        command = self._commands.get(match[1]) if match else None
        if match is None or command is None:
            self._errors |= 1
        else:
            command(match[2])

    def _close(self, argument: str) -> None:
        for channel in self._channels(argument):
            self._closed.add(channel)

    def _open(self, argument: str) -> None:
        for channel in self._channels(argument):
            self._closed.discard(channel)

    def _view(self, argument: str) -> None:
        for channel in self._channels(argument)[:1]:
            self._say(b"CLOSED 0" if channel in self._closed else b"OPEN   1")

    def _card_type(self, argument: str) -> None:
        slot = int(argument) if argument.strip().isdigit() else 0
        if slot not in range(1, 6):
            self._errors |= 2
        else:
            self._say(b"CARD #%d    %-7s" % (slot, self._cards.get(slot, "00000").encode("ascii")))

    def _reset_card(self, argument: str) -> None:
        slot = int(argument) if argument.strip().isdigit() else 0
        self._closed = {channel for channel in self._closed if wire.slot_of(channel) != slot}

    def _report_errors(self, _argument: str) -> None:
        self._say(b"%d" % self._errors)
        self._errors = 0

    def _channels(self, argument: str) -> list[int]:
        """Return the channels named; none and an error bit when one of them does not exist."""
        numbers = [int(number) for number in argument.split(",") if number.strip().isdigit()]
        if not numbers or not all(map(self._has_relay, numbers)):
            self._errors |= 2
            return []
        return numbers

    def _has_relay(self, number: int) -> bool:
        slot = wire.slot_of(number)
        return wire.has_channel(self._cards.get(slot, ""), number) and number % 100 not in self.missing.get(slot, ())

    def _say(self, text: bytes) -> None:
        self._reply = text + b"\r\n"
