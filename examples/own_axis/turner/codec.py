"""Bytes of the TURNER drive, which is made up: nine bytes there, nine bytes back, whole degrees divided by 1000.

A frame: drive number (16 times the controller's address, and the drive's own), command, status (0 where it asks), a
signed 32-bit value with the high byte first, a count that the answer repeats, and the low byte of the sum of the eight
before.

Fails with: a sum that is wrong, an answer of another drive, to another command or with another count. All are refused:
nothing is taken from such a frame.
"""

import struct
from dataclasses import dataclass

from rig.errors import DeviceNonsense

LENGTH = 9
UNITS_PER_DEG = 1000.0
MOVE, TURN, STOP, HOME, POSITION, STATE, SPEED, MODEL = range(1, 9)
DONE, REFUSED = 100, 3
MOVING, HOMED = 0b01, 0b10
"""Bits of ``STATE``."""
MODEL_NUMBER = 7
_FRAME = struct.Struct(">BBBiB")


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame, either way."""

    drive: int
    command: int
    value: int = 0
    count: int = 0
    status: int = 0


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame with its sum."""
    body = _FRAME.pack(frame.drive, frame.command, frame.status, frame.value, frame.count)
    return body + bytes([sum(body) & 0xFF])


def decode(data: bytes) -> Frame:
    """Parse nine bytes. Raises: DeviceNonsense."""
    if len(data) != LENGTH or sum(data[:-1]) & 0xFF != data[-1]:
        raise DeviceNonsense("the sum of the frame is wrong")
    drive, command, status, value, count = _FRAME.unpack(data[:-1])
    return Frame(drive, command, value, count, status)


def answer_to(request: Frame, data: bytes) -> Frame:
    """Parse the answer to a frame. Raises: DeviceNonsense where it is one to another."""
    answer = decode(data)
    if (answer.drive, answer.command, answer.count) != (request.drive, request.command, request.count):
        raise DeviceNonsense(f"the answer is of drive {answer.drive}, command {answer.command}, count {answer.count}")
    return answer


def units(angle_deg: float) -> int:
    """Return degrees as the drive counts them."""
    return round(angle_deg * UNITS_PER_DEG)
