"""Bytes of the Pololu Maestro servo controllers: command bytes have bit 7 set, data bytes have it clear.

A command goes in the compact form (``84 00 70 2E``) or the Pololu form (``AA``, device number, command without bit 7,
data); with the CRC switched on, one more byte follows every command, never a reply. Numbers in commands are two bytes
of seven bits; replies are plain little-endian bytes. Targets and positions are quarter-microseconds of pulse.

Source: Pololu Maestro user's guide, sections 4.e and 5.c to 5.e (pages 39, 42, 43, 52 to 58).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntFlag

from rig.errors import DeviceNonsense

START = 0xAA
MINI_SSC = 0xFF
DEFAULT_DEVICE = 12
HIGHEST_NUMBER = 0x3FFF
QUARTERS_PER_US = 4

SET_TARGET, SET_SPEED, SET_ACCELERATION = 0x84, 0x87, 0x89
SET_PWM, SET_MULTIPLE_TARGETS = 0x8A, 0x9F
GET_POSITION, GET_MOVING_STATE, GET_ERRORS = 0x90, 0x93, 0xA1
GO_HOME, STOP_SCRIPT, RESTART_SCRIPT, RESTART_SCRIPT_WITH, GET_SCRIPT_STATUS = 0xA2, 0xA4, 0xA7, 0xA8, 0xAE
MINI_ONLY = frozenset({SET_PWM, SET_MULTIPLE_TARGETS})

DATA_BYTES = {
    SET_TARGET: 3,
    SET_SPEED: 3,
    SET_ACCELERATION: 3,
    SET_PWM: 4,
    GET_POSITION: 1,
    GET_MOVING_STATE: 0,
    GET_ERRORS: 0,
    GO_HOME: 0,
    STOP_SCRIPT: 0,
    RESTART_SCRIPT: 1,
    RESTART_SCRIPT_WITH: 3,
    GET_SCRIPT_STATUS: 0,
}
"""Data bytes of each command; Set Multiple Targets has two and two for each target."""


class Errors(IntFlag):
    """Bits of Get Errors; reading clears them. Any of them sends every servo to its home."""

    SERIAL_SIGNAL = 1
    SERIAL_OVERRUN = 2
    BUFFER_FULL = 4
    CRC = 8
    PROTOCOL = 16
    TIMEOUT = 32
    SCRIPT_STACK = 64
    CALL_STACK = 128
    PROGRAM_COUNTER = 256


ALL_ERRORS = 0x1FF


@dataclass(frozen=True, slots=True)
class Request:
    """One command as both sides see it: its byte in the compact form, and its data bytes."""

    command: int
    data: tuple[int, ...] = ()


def number(value: int) -> tuple[int, int]:
    """Return two bytes of seven bits, low first. Raises: ValueError outside 0 to 16383."""
    if not 0 <= value <= HIGHEST_NUMBER:
        raise ValueError(f"{value} does not fit in 14 bits")
    return value & 0x7F, value >> 7


def value_of(low: int, high: int) -> int:
    return low | high << 7


def unit_s(period_ms: int) -> float:
    """Return the time unit of speeds and accelerations.

    10 ms, but the period itself on a Mini with another than 20 ms.
    """
    return 0.010 if period_ms == 20 else period_ms / 1000.0


def set_target(channel: int, quarter_us: int) -> Request:
    """Return the request for a target; 0 stops the pulses."""
    return Request(SET_TARGET, (channel, *number(quarter_us)))


def set_speed(channel: int, speed: int) -> Request:
    """Return the request for a speed in 0.25 µs per 10 ms; 0 is unlimited."""
    return Request(SET_SPEED, (channel, *number(speed)))


def set_acceleration(channel: int, acceleration: int) -> Request:
    """Return the request for an acceleration in 0.25 µs per 10 ms per 80 ms, 0 to 255; 0 is unlimited."""
    if not 0 <= acceleration <= 255:
        raise ValueError(f"an acceleration is 0 to 255, got {acceleration}")
    return Request(SET_ACCELERATION, (channel, *number(acceleration)))


def get_position(channel: int) -> Request:
    return Request(GET_POSITION, (channel,))


LOWEST_SPEED = 1
WAY_TOLERANCE = QUARTERS_PER_US
"""Beyond a way, in quarter-microseconds: the read-back of a servo at either end of it."""
AIM_ANSWER = 7
"""Bytes of the answer to :func:`aim_questions`."""


def aim_questions(channel: int) -> tuple[Request, ...]:
    """Return questions whose answers together can be no others': the position twice, marked by the script's state."""
    mark, position = Request(GET_SCRIPT_STATUS), get_position(channel)
    return mark, position, mark, position, mark


def decode_aim(reply: bytes) -> tuple[int, int]:
    """Return both positions, quarter-microseconds. Raises: DeviceNonsense for another length or no marks."""
    if len(reply) != AIM_ANSWER:
        raise DeviceNonsense(f"its answer has {len(reply)} bytes, need {AIM_ANSWER}")
    marks = {reply[0], reply[3], reply[6]}
    if len(marks) != 1 or max(marks) > 1:
        found = " and ".join(map(str, sorted(marks)))
        raise DeviceNonsense(f"the marks in its answer are {found}, allowed is one of 0 and 1")
    return decode_word(reply[1:3]), decode_word(reply[4:6])


def within_way(way: Sequence[int], limits: Sequence[int]) -> tuple[int, int]:
    """Return between which positions a servo on its way may be stopped, inside its channel's limits."""
    return max(min(way) - WAY_TOLERANCE, limits[0]), min(max(way) + WAY_TOLERANCE, limits[1])


@dataclass(frozen=True, slots=True)
class MaestroCodec:
    """How requests are written."""

    device: int | None = None
    """Number for the Pololu form; None writes the compact form."""
    has_crc: bool = False

    def encode(self, request: Request) -> bytes:
        head = [request.command] if self.device is None else [START, self.device, request.command & 0x7F]
        packet = bytes([*head, *request.data])
        return packet + bytes([crc7(packet)]) if self.has_crc else packet


def crc7(packet: bytes) -> int:
    """Return the checksum of a whole command packet; bit 7 is clear. ``83 01`` gives 17 (hexadecimal)."""
    crc = 0
    for byte in packet:
        crc ^= byte
        for _ in range(8):
            crc = (crc ^ 0x91) >> 1 if crc & 1 else crc >> 1
    return crc


def decode_word(reply: bytes) -> int:
    """Decode the reply to Get Position or Get Errors."""
    return int.from_bytes(reply, "little")


def encode_word(value: int) -> bytes:
    return value.to_bytes(2, "little")


def error_words(errors: Errors) -> str:
    """Return the bits by name, for messages."""
    return ", ".join((bit.name or "").lower().replace("_", " ") for bit in Errors if bit in errors)
