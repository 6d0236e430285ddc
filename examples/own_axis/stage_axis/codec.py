"""Frames of the TURN-2, a stage that is made up: eight bytes each way, no line end.

Question: address, motor, word, value (four bytes, most significant first, signed), sum of these seven modulo 256.
Answer: address, motor, status, value, sum. Angles are thousandths of a degree, speeds thousandths of a degree a second.
"""

import struct

from rig.errors import DeviceNonsense, DeviceRefused

LENGTH = 8
IDENTITY, STATE, POSITION, SPEED = b"i", b"s", b"p", b"v"
"""Questions: nothing changes."""
SET_SPEED, GO, HOME, STOP = b"V", b"g", b"h", b"x"
PER_DEG = 1000.0
DONE = 0
REFUSALS = {1: "it knows no such word", 2: "the value is out of its range", 3: "it is not homed", 4: "it has a fault"}
MOVING, HOMED, FAULT = 1, 2, 4
"""Bits of the state."""


def question(address: int, motor: int, word: bytes, value: int = 0) -> bytes:
    body = struct.pack(">BBci", address, motor, word, value)
    return body + bytes([sum(body) % 256])


def read_answer(name: str, address: int, motor: int, data: bytes) -> int:
    """Return the value of a whole answer. Raises: DeviceNonsense, DeviceRefused (the stage took nothing of it)."""
    if len(data) != LENGTH or sum(data[:-1]) % 256 != data[-1]:
        raise DeviceNonsense("need eight bytes, the last the sum of the others")
    told_address, told_motor, status, value = struct.unpack(">BBBi", data[:-1])
    if (told_address, told_motor) != (address, motor):
        raise DeviceNonsense(f"need an answer of address {address}, motor {motor}")
    if status != DONE:
        why = REFUSALS.get(status, f"status {status}, which is not in its manual")
        raise DeviceRefused(f"{name}: the stage refused: {why}; nothing moved; compare the file with the stage")
    return int(value)
