"""What a line can do to a reply: the value, the sign, the axis, a word of the state, twice, never, late.

As :mod:`command_strikes`, the other way: checksums are made right again, and the reply stays one of its protocol.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from command_strikes import LATE_S, other_axis, signed, turned_digit
from pymodbus.framer import FramerRTU

from rig.link.faults import Fault, Part, delay, drop, duplicate
from rig.wire import maestro, oriental_az, zaber

REPLY_KINDS = ("value", "sign", "axis", "word", "doubled", "swallowed", "late")
WITHIN = 30
"""One of so many replies from the order on is struck: those of the start, of the way and of the arrival."""
_OPPOSITES = ((b"MOVING", b"IDLE"), (b"UNHOMED", b"HOMED"), (b"LIFTED", b"SEATED"), (b"UNLOCKED", b"LOCKED"))
_LEFT = {"value": turned_digit, "sign": lambda text, _chance: signed(text)}


def _table(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    if kind == "axis":
        found = re.match(rb"(\d+) ", data)
        return None if found is None else b"%d" % other_axis(int(found[1])) + data[found.end(1) :]
    if kind == "word":
        words = data.split()
        indices = [index for index, word in enumerate(words) if any(word in pair for pair in _OPPOSITES)]
        if not indices:
            return None
        index = int(chance.choice(indices))
        pair = next(pair for pair in _OPPOSITES if words[index] in pair)
        words[index] = pair[words[index] == pair[0]]
        return b" ".join(words) + b"\r\n"
    return _number_in(rb"(?<= POS )[+-][\d.]+", data, kind, chance)


def _esp301(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    """Its replies name no axis."""
    if kind == "word":
        flag = data.strip()
        return {b"0": b"1\r\n", b"1": b"0\r\n"}.get(flag)
    return _number_in(rb"\A[+-]?\d+\.\d+(?=\r\n)", data, kind, chance)


def _number_in(pattern: bytes, data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    found = re.search(pattern, data)
    if found is None or kind not in _LEFT:
        return None
    return data[: found.start()] + _LEFT[kind](found[0], chance) + data[found.end() :]


def _zaber(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    reply = zaber.decode_reply(data.rstrip(b"\r\n"))
    if reply is None:
        return None
    if kind == "axis":
        return zaber.encode_reply(replace(reply, device=other_axis(reply.device)))
    if kind == "word":
        if chance.integers(2):
            return zaber.encode_reply(replace(reply, is_busy=not reply.is_busy))
        return zaber.encode_reply(replace(reply, warning=str(chance.choice(["--", "WR", "FF", "NI"]))))
    if not re.fullmatch(r"-?\d+", reply.data):
        return None
    return zaber.encode_reply(replace(reply, data=_LEFT[kind](reply.data.encode(), chance).decode()))


def _oriental(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    if len(data) < 5 or data[1] != 0x03 or len(data) != 5 + data[2]:
        return None
    frame = bytearray(data[:-2])
    if kind == "axis":
        frame[0] = other_axis(frame[0])
    elif kind == "word":
        if data[2] != 2 * oriental_az.SIGNAL_WORDS:
            return None
        bits = (oriental_az.HOME_END, oriental_az.ABSPEN), (oriental_az.READY, oriental_az.MOVE, oriental_az.ALARM_A)
        location = int(chance.integers(2))
        bit = int(chance.choice(bits[location]))
        word = int.from_bytes(frame[3 + 2 * location : 5 + 2 * location], "big") ^ bit
        frame[3 + 2 * location : 5 + 2 * location] = word.to_bytes(2, "big")
    else:
        value = oriental_az.value_of(int.from_bytes(frame[3:5], "big"), int.from_bytes(frame[5:7], "big"))
        changed = int(_LEFT[kind](str(value).encode(), chance))
        frame[3:7] = b"".join(word.to_bytes(2, "big") for word in oriental_az.words(changed))
    head = bytes(frame)
    return head + FramerRTU.compute_CRC(head).to_bytes(2, "big")


def _maestro(data: bytes, kind: str, chance: np.random.Generator) -> bytes | None:
    """Its replies name no axis. Two bytes are error bits, more are a position with the script's state behind it."""
    if kind == "word":
        return maestro.encode_word(1 << int(chance.integers(9))) if len(data) == 2 else None
    if len(data) < 3 or kind == "axis":
        return None
    position = maestro.decode_word(data[:2])
    changed = 12000 - position if kind == "sign" else int(turned_digit(str(position).encode(), chance))
    return maestro.encode_word(min(max(changed, 0), 0x3FFF)) + data[2:]


ALTERED_REPLY: dict[str, Callable[[bytes, str, np.random.Generator], bytes | None]] = {
    "indexing-table": _table,
    "esp301": _esp301,
    "maestro": _maestro,
    "oriental-az": _oriental,
    "zaber": _zaber,
}
KINDS_OF: dict[str, Sequence[str]] = {
    driver: [kind for kind in REPLY_KINDS if kind != "axis" or driver not in ("esp301", "maestro")]
    for driver in ALTERED_REPLY
}


def a_reply(driver: str, kind: str, chance: np.random.Generator) -> "StruckReplies":
    """Strike one of the replies of a task."""
    return StruckReplies(driver, kind, int(chance.integers(WITHIN)), chance)


@dataclass
class StruckReplies:
    """The faults of a line on which the n-th reply that can be struck so is struck."""

    driver: str
    kind: str
    number: int
    chance: np.random.Generator
    seen: int = 0
    struck: str = ""

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        return (Part(data),)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        faults: dict[str, Fault] = {"doubled": duplicate(0.2), "swallowed": drop, "late": delay(LATE_S)}
        altered = data if self.kind in faults else ALTERED_REPLY[self.driver](data, self.kind, self.chance)
        if altered is None or self.struck:
            return (Part(data),)
        self.seen += 1
        if self.seen <= self.number:
            return (Part(data),)
        self.struck = f"reply {self.number}, {self.kind}: {data!r} became {altered!r}"
        return faults[self.kind](data) if self.kind in faults else (Part(altered),)
