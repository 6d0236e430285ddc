"""Numbers streamed as text, a line a sample: no standard says how, so columns, separator and checksum are settings.

The usual boards of microcontrollers send ``t,ax,ay,az,…`` and CR LF, some with ``*XX``, the XOR of what stands
before it in the line, after a ``$`` where there is one.
"""

import re
from dataclasses import dataclass, field
from functools import reduce
from operator import xor
from typing import Literal

from rig.wire.stream_lines import Rows, checksums_hold, parse_lines, row_pattern

Checksum = Literal["none", "xor"]


@dataclass(frozen=True)
class RowShape:
    """How a line is written."""

    fields: int
    separator: bytes = b","
    prefix: bytes = b""
    """What every line begins with, such as ``$IMU,``."""
    checksum: Checksum = "none"
    pattern: re.Pattern[bytes] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        behind = rb"\*[0-9A-Fa-f]{2}" if self.checksum == "xor" else b""
        pattern = row_pattern(self.fields, self.separator, re.escape(self.prefix), behind)
        object.__setattr__(self, "pattern", pattern)


def parse_rows(piece: bytes, shape: RowShape) -> Rows:
    """Parse whole lines to rows of numbers; a header line, a comment or a damaged line is refused."""

    def numbers_of(lines: bytes) -> bytes:
        if shape.checksum == "xor":
            lines = re.sub(rb"\*..\r?\n", b"\n", lines)
        prefix = shape.prefix
        return lines.removeprefix(prefix).replace(b"\n" + prefix, b"\n") if prefix else lines

    def kept(lines: bytes) -> list[bool]:
        if shape.checksum == "none":
            return [True] * lines.count(b"\n")
        return checksums_hold(lines, b"$" if shape.prefix.startswith(b"$") else b"")

    return parse_lines(piece, shape.pattern, shape.fields, numbers_of, kept, shape.separator)


def format_row(fields: list[bytes], shape: RowShape) -> bytes:
    """Return a line with its checksum."""
    line = shape.prefix + shape.separator.join(fields)
    if shape.checksum == "xor":
        line += b"*%02X" % reduce(xor, line.removeprefix(b"$"), 0)
    return line + b"\r\n"
