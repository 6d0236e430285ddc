"""The stop of a servo by who has its line alone: it is asked where it is, and sent there where the answer is trusted.

An answer is trusted where it is whole, the script's state stands before, between and behind the two positions in it,
these agree, and they lie within the channel's limits and on the way of the order that moves the servo.
"""

from typing import Any

from rig.errors import DeviceNonsense
from rig.guard.outcomes import goes_on
from rig.wire.maestro import (
    QUARTERS_PER_US,
    MaestroCodec,
    aim_questions,
    decode_aim,
    set_target,
    within_way,
)

AGREE = 32
"""Between the two positions of one answer: at 9600 baud the second is asked 10 ms behind the first, in which a servo
at 8 µs per 10 ms goes so far; it was told to go at its lowest speed before."""


class Untrusted(Exception):
    """An answer that nothing may be sent by; the text says why."""


class ServoStop:
    """Of one servo. ``aim``: as of :class:`rig.abilities.abilities.ServoAim`; ``way``: its order's, from and to."""

    def __init__(self, aim: dict[str, Any], way: list[int]) -> None:
        codec = MaestroCodec(aim["device"], aim["has_crc"])
        self._codec, self._channel = codec, aim["channel"]
        self.question = b"".join(codec.encode(request) for request in aim_questions(self._channel))
        self.patience_s: float = aim["patience_s"]
        self.aimed: int | None = None
        """Quarter-microseconds that were sent as its target."""
        self.is_seen = False
        """It was read back there."""
        self._allowed = within_way(way, aim["limits"])

    def position(self, reply: bytes) -> int:
        """Return quarter-microseconds. Raises: Untrusted."""
        try:
            first, second = decode_aim(reply)
        except DeviceNonsense as error:
            raise Untrusted(str(error)) from error
        if abs(second - first) > AGREE:
            raise Untrusted(f"it says {pulse_us(first)} and {pulse_us(second)} in one answer")
        lowest, highest = self._allowed
        if not (lowest <= first <= highest and lowest <= second <= highest):
            raise Untrusted(f"it says {pulse_us(second)}, and its way is {pulse_us(lowest)} to {pulse_us(highest)}")
        return second

    def is_about_there(self, position: int) -> bool:
        """Return whether it is where it was sent, or comes back to it from a few milliseconds beyond."""
        return self.aimed is not None and abs(position - self.aimed) <= AGREE

    def order(self, position: int) -> bytes:
        """Return what makes a trusted position its target."""
        self.aimed = position
        return self._codec.encode(set_target(self._channel, position))

    def outcome(self, why_not: str) -> str:
        """Return what it was told, for the record. ``why_not``: of the last answer that was not trusted."""
        if self.aimed is None:
            return goes_on(why_not)
        seen = "read back there" if self.is_seen else f"not read back: {why_not}"
        return f"told to stop at {pulse_us(self.aimed)}, which it said it was at, on its way; {seen}"


def pulse_us(quarters: int) -> str:
    """Return a pulse for a sentence."""
    return f"{quarters / QUARTERS_PER_US:g} µs"
