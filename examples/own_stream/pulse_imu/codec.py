"""Packets of the PULSE board, which is made up: A5h, a count, three signed 16-bit counts (high byte first), a sum.

1000 counts are one g. The sum is the low byte of all that stands between A5h and itself.
"""

import struct
from dataclasses import dataclass

HEAD = 0xA5
LENGTH = 9
COUNTS_PER_G = 1000.0
COUNT_WRAPS = 256


@dataclass(frozen=True, slots=True)
class Sample:
    """One packet; ``count`` begins again at 256."""

    count: int
    force_g: tuple[float, float, float]


def take_samples(received: bytes) -> tuple[list[Sample], bytes, int]:
    """Return the whole packets, the rest that is not one yet, and how many bytes belonged to none."""
    samples: list[Sample] = []
    refused = 0
    while len(received) >= LENGTH:
        packet = received[:LENGTH]
        if packet[0] != HEAD or sum(packet[1:-1]) & 0xFF != packet[-1]:
            received = received[1:]  # the next packet may begin at the next byte
            refused += 1
            continue
        count, *counts = struct.unpack(">Bhhh", packet[1:-1])
        x, y, z = (value / COUNTS_PER_G for value in counts)
        samples.append(Sample(count, (x, y, z)))
        received = received[LENGTH:]
    return samples, received, refused
