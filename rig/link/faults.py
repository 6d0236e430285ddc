"""Faults of a line, as a script: what happens to the n-th piece that is written or read.

A fault turns one piece of bytes into the parts that really travel, each with a delay. The script is what tests and
rehearsed failures are made of: late, lost, doubled, cut and damaged replies, stale bytes, a line that hangs up.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from rig.errors import LinkLost


@dataclass(frozen=True, slots=True)
class Part:
    """Bytes that travel, and how much later than they should (rig seconds)."""

    data: bytes
    delay_s: float = 0.0
    stalls: bool = False
    """Whether what follows waits for this part, as on a wire; otherwise it may be overtaken, as over some gateways."""


Fault = Callable[[bytes], tuple[Part, ...]]


class LinkFaults(Protocol):
    """What a memory line asks about each piece. Raises: LinkLost where the line hangs up."""

    def on_write(self, data: bytes) -> tuple[Part, ...]: ...

    def on_read(self, data: bytes) -> tuple[Part, ...]: ...


@dataclass(slots=True)
class FaultScript:
    """Faults by the running number of the piece, counted from 0 in each direction."""

    writes: Mapping[int, Fault] = field(default_factory=dict)
    reads: Mapping[int, Fault] = field(default_factory=dict)
    written: int = 0
    taken: int = 0

    def on_write(self, data: bytes) -> tuple[Part, ...]:
        self.written += 1
        return self.writes.get(self.written - 1, intact)(data)

    def on_read(self, data: bytes) -> tuple[Part, ...]:
        self.taken += 1
        return self.reads.get(self.taken - 1, intact)(data)


def intact(data: bytes) -> tuple[Part, ...]:
    return (Part(data),)


def drop(_data: bytes) -> tuple[Part, ...]:
    return ()


def hang_up(data: bytes) -> tuple[Part, ...]:
    raise LinkLost(f"the line hung up with {len(data)} bytes on the way; check the cable and the adapter")


def delay(delay_s: float) -> Fault:
    """Let the piece arrive late; it may be overtaken."""
    return lambda data: (Part(data, delay_s),)


def stall(delay_s: float) -> Fault:
    """Stop the line: the piece and all that follows arrive no earlier than ``delay_s`` from now."""
    return lambda data: (Part(data, delay_s, stalls=True),)


def duplicate(delay_s: float = 0.0) -> Fault:
    """Let the piece arrive, and again ``delay_s`` later."""
    return lambda data: (Part(data), Part(data, delay_s))


def truncate(keep: int) -> Fault:
    """Let only the first ``keep`` bytes arrive."""
    return lambda data: (Part(data[:keep]),)


def split(at: int, delay_s: float) -> Fault:
    """Let the piece arrive in two parts, the second ``delay_s`` later."""
    return lambda data: (Part(data[:at]), Part(data[at:], delay_s))


def prepend(stale: bytes) -> Fault:
    return lambda data: (Part(stale + data),)


def replace(other: bytes) -> Fault:
    """Let other bytes arrive instead: the answer to an earlier question, a boot banner."""
    return lambda _data: (Part(other),)


def flip_bit(position: int, bit: int) -> Fault:
    """Turn over one bit of the byte at ``position`` (from the end when negative)."""

    def flipped(data: bytes) -> tuple[Part, ...]:
        damaged = bytearray(data)
        damaged[position] ^= 1 << bit
        return (Part(bytes(damaged)),)

    return flipped
