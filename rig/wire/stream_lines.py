"""Lines of numbers as they stream in: taken apart many at a time, so that a fast stream costs little.

Every line is judged by one expression and its checksum (all lines of a piece in one pass); those that do not fit
are named with the place they stood at. Nothing is repaired.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np
from numpy.typing import NDArray

NUMBER = rb"[+-]?\d{1,12}(?:\.\d{0,12})?(?:[Ee][+-]?\d{1,3})?"
LONGEST_LINE = 1024
"""Bytes without a line feed after which it is noise."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Refusal:
    """A line that is no row: the number of rows that stood before it in its piece, and why."""

    before: int
    line: bytes
    why: str


@dataclass(frozen=True, slots=True)
class Rows:
    """What a piece of a stream held."""

    values: Floats
    """Shape (n, fields)."""
    refused: tuple[Refusal, ...] = ()


def split_whole_lines(received: bytes) -> tuple[bytes, bytes]:
    """Return everything to the last line feed, and the unfinished rest."""
    end = received.rfind(b"\n") + 1
    return received[:end], received[end:]


def row_pattern(fields: int, separator: bytes = b",", before: bytes = b"", behind: bytes = b"") -> re.Pattern[bytes]:
    """Return the pattern of one line with its line feed.

    Blanks around a number are allowed where they do not separate.
    """
    number = NUMBER if separator.isspace() else rb"[ \t]*" + NUMBER + rb"[ \t]*"
    numbers = re.escape(separator).join([number] * fields)
    return re.compile(before + numbers + behind + rb"\r?\n")


def parse_lines(
    piece: bytes,
    pattern: re.Pattern[bytes],
    fields: int,
    numbers_of: Callable[[bytes], bytes],
    kept: Callable[[bytes], Sequence[bool]],
    separator: bytes = b",",
) -> Rows:
    """Parse whole lines to rows.

    ``numbers_of`` strips well-shaped lines to numbers, separators and line feeds; ``kept`` tells of such lines, line
    by line, whether their checksum holds.
    """
    lines = piece.splitlines(keepends=True)
    shaped = [pattern.fullmatch(line) is not None for line in lines]
    judged = iter(kept(b"".join(compress(lines, shaped))))
    refused: list[Refusal] = []
    rows: list[bytes] = []
    for line, is_shaped in zip(lines, shaped, strict=True):
        if not is_shaped:
            refused.append(Refusal(len(rows), line, "not the shape of a row"))
        elif not next(judged):
            refused.append(Refusal(len(rows), line, "the checksum is wrong"))
        else:
            rows.append(line)
    numbers = numbers_of(b"".join(rows)).replace(b"\r", b"").replace(b"\n", separator).split(separator)
    values = np.array(list(map(float, numbers[:-1])), dtype=np.float64).reshape(len(rows), fields)
    return Rows(values, tuple(refused))


def checksums_hold(lines: bytes, start: bytes) -> list[bool]:
    """Return whether the checksums hold, line by line.

    The XOR of the bytes from behind ``start`` (as long as every line's beginning) to the ``*`` is what the two
    hexadecimal digits behind it say. Every line has exactly one ``*``.
    """
    if not lines:
        return []
    data = np.frombuffer(lines, dtype=np.uint8)
    stars = np.flatnonzero(data == ord("*"))
    feeds = np.flatnonzero(data == ord("\n"))
    edges = np.empty(2 * stars.size, dtype=np.intp)
    edges[::2] = np.concatenate([[0], feeds[:-1] + 1]) + len(start)
    edges[1::2] = stars
    computed = np.bitwise_xor.reduceat(data, edges)[::2]
    printed = 16 * _NIBBLES[data[stars + 1]] + _NIBBLES[data[stars + 2]]
    holds: list[bool] = (computed == printed).tolist()
    return holds


def _nibbles() -> NDArray[np.int64]:
    table = np.zeros(256, dtype=np.int64)
    for digit in b"0123456789ABCDEFabcdef":
        table[digit] = int(chr(digit), 16)
    return table


_NIBBLES = _nibbles()
