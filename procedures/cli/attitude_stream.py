"""Rows that arrive on standard input, each answered at once.

A file with a wrong cell is refused whole. A stream cannot be: the row is answered with empty cells and a flag, and the
next one is read. What ends a stream is its end.
"""

import csv
import sys
from collections.abc import Iterator
from typing import TextIO

import numpy as np

from ams.inference.inference import Inference
from ams.inputs.csv_table import is_number
from procedures.cli.attitude_rows import row_lines
from procedures.errors import RequestError

LONGEST_LINE = 65_536
"""Letters of a row; no package has so many outputs, and what never ends must not fill the memory."""


def answer_stream(found: Inference, target: TextIO, source: TextIO | None = None) -> None:
    """Read a header and rows, write a header and answers, flushed line by line.

    Raises: RequestError where the header lacks a column.
    """
    lines = _lines(sys.stdin if source is None else source)
    first = next(lines, "")
    if first is None:
        raise RequestError(f"standard input: line 1: longer than {LONGEST_LINE} letters; send a header first")
    header = [name.strip() for name in next(csv.reader([first]), [])]
    missing = [name for name in found.needed if name not in header]
    if missing:
        raise RequestError(
            f"standard input: line 1: column {', '.join(missing)} missing; found: {', '.join(header) or 'nothing'}; "
            "send a header first"
        )
    _write(target, ",".join(found.answers) + "\n")
    for number, line in enumerate(lines, start=2):
        if line is None:
            _write(target, _refused(found, number, f"longer than {LONGEST_LINE} letters"))
        elif line.strip():
            _write(target, _answer(found, header, line, number))


def _lines(source: TextIO) -> Iterator[str | None]:
    """Each line; None for one that is too long, of which no more is kept than a row may have."""
    while line := source.readline(LONGEST_LINE + 1):
        if len(line) <= LONGEST_LINE or line.endswith("\n"):
            yield line
            continue
        while (more := source.readline(LONGEST_LINE)) and not more.endswith("\n"):
            pass
        yield None


def _refused(found: Inference, number: int, why: str) -> str:
    return "," * (len(found.answers) - 1) + f"line {number}: {why}\n"


def _write(target: TextIO, line: str) -> None:
    target.write(line)
    target.flush()


def _answer(found: Inference, header: list[str], line: str, number: int) -> str:
    cells = [cell.strip() for cell in line.split(",")]
    wrong = _wrong(found, header, cells)
    if wrong:
        return _refused(found, number, wrong)
    row = dict(zip(header, cells, strict=True))
    known = [name for name in (*found.needed, "temperature_degc") if is_number(row.get(name, ""))]
    return next(row_lines(found.answers, found.infer({name: np.array([float(row[name])]) for name in known})))


def _wrong(found: Inference, header: list[str], cells: list[str]) -> str:
    if len(cells) != len(header):
        return f"{len(cells)} cells instead of {len(header)}"
    row = dict(zip(header, cells, strict=True))
    named = [name for name in found.needed if not is_number(row[name])]
    return f"{' and '.join(named)} no number" if named else ""
