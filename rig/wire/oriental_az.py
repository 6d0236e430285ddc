"""Registers of the Oriental Motor AZ series, Modbus RTU: direct data operation, inputs, status, feedback.

Values of 32 bits take two registers, the upper word at the even address. Writing the whole direct data block with
trigger 1 starts an operation at once, in one frame.

Source: docs/devices/oriental-az.md: the maker's public samples for the AZ, and a public driver that cites the pages of
manual HM-60262-6E (internal output signals, software limits). The bits of the outputs are as somebody assigned them;
those of the internal signals are fixed. The registers of gear and wrap are remembered.
"""

from collections.abc import Sequence
from dataclasses import dataclass

DIRECT_DATA = 0x58
"""Data number, type, position, speed, starting rate, stopping rate, current, trigger: eight values of 32 bits."""
CURRENT = 0x64
TRIGGER = 0x66
INPUTS, AUTO_INPUTS, OUTPUTS, ALARM = 0x7C, 0x78, 0x7E, 0x80
POSITION, FEEDBACK_RPM, FEEDBACK_HZ = 0xCC, 0xCE, 0xD0
SIGNALS, SIGNAL_WORDS = 0x178, 8
"""Internal output signals, always readable; in words, the first of them 0178h."""
HOME_END, ABSPEN = 1 << 0, 1 << 1
"""Bits of 0178h: at home; the coordinates are set."""
ALARM_A, READY, MOVE, IN_POSITION = 1 << 1, 1 << 4, 1 << 6, 1 << 10
"""Bits of 0179h."""
PARAMETERS = 0x380
"""Electronic gear A and B, direction, software overtravel, its upper and lower limit in steps, preset, wrap: eight."""
PARAMETER_VALUES = 8
NO_OVERTRAVEL = -1
SILENCE_ALARM = 0x85
"""RS-485 communication timeout: nothing came from the master for as long as the parameter of that name allows."""
FULL_CURRENT = 1000
MOST_HZ, MOST_RATE = 4_000_000, 1_000_000_000
"""Largest operating speed, steps a second, and starting or stopping rate, steps a second each second."""
"""Tenths of a percent."""
SILENCE_MS = 0x138A
"""That parameter: milliseconds, 0 is never. Remembered: a setting of the driver."""
LONGEST_SILENCE_MS = 10_000

ABSOLUTE, INCREMENTAL, CONTINUOUS_SPEED = 1, 2, 16
FULL_CURRENT = 1000
START_ALL = 1

ZHOME, STOP, FREE, ALARM_RESET = 1 << 4, 1 << 5, 1 << 6, 1 << 7
"""Inputs, lower word."""


@dataclass(frozen=True, slots=True)
class Parameters:
    """What the drive is set up to, as far as it bears on positions."""

    gear: tuple[int, int]
    """Electronic gear, A and B."""
    direction: int
    """Motor rotation direction: which way counts upward, as the drive's own program numbers it."""
    limits: tuple[int, int] | None
    """Software limits in steps, None where overtravel is off."""
    wraps: bool


def parameters_of(values: Sequence[int]) -> Parameters:
    """Return the eight values from :data:`PARAMETERS` on. Raises: ValueError where the last is no switch."""
    gear_a, gear_b, direction, overtravel, upper, lower, _, wrap = values
    if wrap not in (0, 1):
        raise ValueError(f"{wrap} is neither on nor off")
    return Parameters((gear_a, gear_b), direction, None if overtravel == NO_OVERTRAVEL else (lower, upper), bool(wrap))


@dataclass(frozen=True, slots=True)
class Operation:
    """One direct data operation. Steps, Hz (steps a second) and Hz per second; current in 0.1 %."""

    kind: int
    position: int
    speed_hz: int
    starting_rate: int
    stopping_rate: int
    current: int = FULL_CURRENT
    number: int = 0


def encode(operation: Operation) -> tuple[int, ...]:
    """Encode the operation in sixteen registers from :data:`DIRECT_DATA` that start it.

    Raises: ValueError beyond 32 bits.
    """
    values = (
        operation.number,
        operation.kind,
        operation.position,
        operation.speed_hz,
        operation.starting_rate,
        operation.stopping_rate,
        operation.current,
        START_ALL,
    )
    return tuple(word for value in values for word in words(value))


def decode(registers: Sequence[int]) -> Operation:
    """Return the operation in sixteen registers."""
    number, kind, position, speed_hz, starting, stopping, current, _ = (
        value_of(registers[index], registers[index + 1]) for index in range(0, 16, 2)
    )
    return Operation(kind, position, speed_hz, starting, stopping, current, number)


def words(value: int) -> tuple[int, int]:
    """Return the words of a signed value of 32 bits, upper word first. Raises: ValueError."""
    if not -(2**31) <= value < 2**31:
        raise ValueError(f"{value} does not fit in 32 bits")
    return (value >> 16) & 0xFFFF, value & 0xFFFF


def value_of(upper: int, lower: int) -> int:
    value = upper << 16 | lower
    return value - 2**32 if value >= 2**31 else value
