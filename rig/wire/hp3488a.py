"""HP 3488A switch and control unit: its command words and lines.

A channel is the slot (1 to 5) and two digits. There is no query that names all closed channels: ``VIEW`` tells the
state of one. Relays latch, and ``CLOSE`` opens no other; ``CRESET`` opens those of one card, a device clear those of
all. Commands carry no answer; a serial poll tells ready.

Source: HP 3488A operating manual as used by gpib-utils' hp3488; docs/devices/hp3488a.md.
"""

import re
from collections.abc import Iterable, Mapping
from enum import IntFlag

from rig.errors import DeviceNonsense

DEFAULT_ADDRESS = 9
IDENTITY = b"HP3488A"


class Status(IntFlag):
    """The status byte of a serial poll."""

    SCAN_DONE = 1
    OUTPUT = 2
    POWER_ON = 4
    FRONT_PANEL = 8
    READY = 16
    ERROR = 32
    SERVICE = 64


ERRORS: Mapping[int, str] = {1: "syntax", 2: "execution", 4: "trigger too fast", 8: "logic", 16: "power"}
"""Bit of the answer to ``ERROR`` to its meaning; asking clears."""

_DECADE = frozenset(range(10))
SWITCHED_BY: Mapping[str, frozenset[int]] = {
    "44470": _DECADE,  # multiplexer
    "44471": _DECADE,  # relays; 44476 and 44477 name themselves so, too
    "44472": frozenset((0, 1, 2, 3, 10, 11, 12, 13)),  # VHF switch
}
"""Card to the channels (without the slot) that can connect an input to the meter."""
NAMED_ALIKE: Mapping[str, tuple[frozenset[int], ...]] = {
    "44471": (_DECADE, frozenset(range(7)), frozenset(range(4))),  # 44471, 44477, 44476
}
"""Answer to ``CTYPE`` that several cards give, to the channels that each of them has."""

_VIEW = re.compile(rb"(?:(CLOSED) {1,3}0|OPEN {1,3}1) *")
_CARD = re.compile(rb"[ -~]{11}([0-9]{5})[ -~]*")
_NUMBER = re.compile(rb" *[+-]?\d{1,5} *")


def close(channel: int) -> bytes:
    return b"CLOSE %03d" % channel


def open_channel(channel: int) -> bytes:
    return b"OPEN %03d" % channel


def view(channel: int) -> bytes:
    return b"VIEW %03d" % channel


def card_type(slot: int) -> bytes:
    return b"CTYPE %d" % slot


def reset_card(slot: int) -> bytes:
    return b"CRESET %d" % slot


def slot_of(channel: int) -> int:
    return channel // 100


def by_slot(channels: Iterable[int]) -> dict[int, list[int]]:
    """Return the channels of every slot that has some, slot by slot."""
    numbers = sorted(channels)
    return {
        slot: [number for number in numbers if slot_of(number) == slot] for slot in sorted(set(map(slot_of, numbers)))
    }


def has_channel(card: str, channel: int) -> bool:
    """Return whether a card of that model has the channel (slot and two digits)."""
    return channel % 100 in SWITCHED_BY.get(card, frozenset())


def channels_of(slot: int, card: str) -> list[int]:
    """Return all channels (with the slot) of a card of that model, none where it connects nothing to a meter."""
    return [100 * slot + number for number in sorted(SWITCHED_BY.get(card, frozenset()))]


def cards_for(channels: Iterable[int]) -> list[str]:
    """Return the models of card that have all these channels of one slot."""
    wanted = {channel % 100 for channel in channels}
    return [card for card, has in SWITCHED_BY.items() if wanted <= has]


def parse_identity(line: bytes) -> str:
    """Return the name of a 3488A. Raises: DeviceNonsense where it is another."""
    if line.strip() != IDENTITY:
        raise DeviceNonsense("a 3488A answers ID? with HP3488A")
    return IDENTITY.decode("ascii")


def parse_view(line: bytes) -> bool:
    """Return whether the channel is closed: ``CLOSED 0`` or ``OPEN   1``. Raises: DeviceNonsense."""
    match = _VIEW.fullmatch(line)
    if match is None:
        raise DeviceNonsense("the scanner answers VIEW with CLOSED 0 or OPEN   1")
    return match[1] is not None


def parse_card_type(line: bytes) -> str:
    """Return the model number of the card in a slot, such as ``44470``. Raises: DeviceNonsense."""
    match = _CARD.fullmatch(line)
    if match is None:
        raise DeviceNonsense("the scanner answers CTYPE with a text whose model number starts at character 12")
    return match[1].decode("ascii")


def parse_errors(line: bytes) -> tuple[str, ...]:
    """Parse ``ERROR``: the meanings of the set bits, empty when there is none. Raises: DeviceNonsense."""
    if _NUMBER.fullmatch(line) is None or not 0 <= int(line) < 32:
        raise DeviceNonsense("the scanner answers ERROR with a sum of 1, 2, 4, 8 and 16")
    return tuple(text for bit, text in ERRORS.items() if int(line) & bit)
