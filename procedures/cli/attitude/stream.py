"""Rows that arrive on standard input, answered as they come: what has arrived together is solved together.

A file with a word for a number is refused whole. A stream cannot be: the row is answered with empty cells and a flag,
and the next one is read. What ends a stream is its end. A row that is alone is answered at once; where rows come faster
than they are answered, what is waiting is taken as one block.
"""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import IO, Final

import numpy as np

from ams.arrays import FloatArray
from ams.inference.rows.angle_stream import AngleStream
from ams.inputs.csv_table import CsvForm, header_from, is_number
from ams.inputs.number_blocks import numbers_of
from procedures.cli.attitude.rows import Rows, RowWriter
from procedures.cli.attitude.source import REMEDIES
from procedures.errors import RequestError

WriterOf = Callable[[Sequence[str]], tuple[RowWriter, IO[bytes]]]
"""From the columns of the answers to what takes them, and the file that it writes to."""
LONGEST_LINE: Final = 65_536
"""Letters of a row; no package has so many outputs, and what never ends must not fill the memory."""
_AT_ONCE: Final = 1 << 18
"""Bytes that are taken at a time."""
_FORM: Final = CsvForm(remedies=REMEDIES)
_FEW: Final = 50
"""Rows up to which a look at every cell costs less than pandas' start."""


def answer_stream(
    found: AngleStream,
    writer_of: WriterOf,
    source: IO[bytes],
) -> None:
    """Read a header and rows, write a header and answers, flushed whenever all that arrived is answered.

    Raises: RequestError where the header lacks a column, or no row follows it.
    """
    pieces = _pieces(source)
    header, first = _header(found, pieces)
    writer, target = writer_of(found.answers)
    target.flush()
    line, has_rows = 2, False
    for piece in chain([first], pieces):
        names = [name for name in (*found.needed, *found.optional) if name in header]
        names = list(dict.fromkeys(names))
        readings, wrong = _readings(header, names, found.needed, piece, line)
        if readings[names[0]].size:
            rows = Rows.of(found.answer(readings))
            writer.write(_with_reasons(rows, wrong) if wrong and found.answers_at_once else rows)
            has_rows = True
        line = line + len(piece)
        target.flush()
    _end(found, writer, target)
    if not has_rows:
        raise RequestError(f"standard input: a header and no rows; {REMEDIES.not_done}; send rows after the header")


def answer_blocks(
    found: AngleStream,
    writer_of: WriterOf,
    blocks: Iterable[Mapping[str, FloatArray]],
) -> None:
    """Answer readings that are numbers already, written and flushed block by block."""
    writer, target = writer_of(found.answers)
    target.flush()
    for readings in blocks:
        writer.write(Rows.of(found.answer(readings)))
        target.flush()
    _end(found, writer, target)


def _end(found: AngleStream, writer: RowWriter, target: IO[bytes]) -> None:
    writer.write(Rows.of(found.finish()))
    writer.close()
    target.flush()


def _pieces(source: IO[bytes]) -> Iterator[list[bytes | None]]:
    """Yield the lines that have arrived; None for one that is too long, of which no more is kept than a row has."""
    rest, is_too_long = b"", False
    read = getattr(source, "read1", source.read)
    while arrived := read(_AT_ONCE):
        *lines, rest = (rest + arrived).split(b"\n")
        found: list[bytes | None] = [None if len(line) > LONGEST_LINE else line for line in lines]
        if found and is_too_long:
            found[0], is_too_long = None, False
        if len(rest) > LONGEST_LINE:
            rest, is_too_long = b"", True
        if found:
            yield found
    if is_too_long:
        yield [None]
    elif rest:
        yield [rest]


def _header(found: AngleStream, pieces: Iterator[list[bytes | None]]) -> tuple[list[str], list[bytes | None]]:
    """Return the names of the columns and the lines that came with them."""
    nothing: list[bytes | None] = [b""]
    lines = next(pieces, nothing)
    if lines[0] is None:
        raise RequestError(f"standard input: line 1: longer than {LONGEST_LINE} letters; send a header first")
    text = lines[0].decode("utf-8-sig", "replace")
    header = list(header_from("standard input", next(csv.reader([text]), []), _FORM).columns)
    missing = [name for name in found.needed if name not in header]
    if missing:
        raise RequestError(
            f"standard input: line 1: column {', '.join(missing)} missing; found: {', '.join(header) or 'nothing'}; "
            f"send a header first, and name columns that are called otherwise ({REMEDIES.column})"
        )
    return header, lines[1:]


def _readings(
    header: Sequence[str], names: Sequence[str], needed: Sequence[str], lines: list[bytes | None], line: int
) -> tuple[Mapping[str, FloatArray], Mapping[int, str]]:
    """Return the numbers of the rows, NaN where there is none, and by row what is wrong with it."""
    if len(lines) > _FEW:
        quick = _quick(header, names, lines)
        if quick is not None:
            return quick, {}
        return _halved(header, names, needed, lines, line)
    found: list[list[float]] = []
    wrong = {}
    for number, text_line in enumerate(lines, start=line):
        if text_line is not None and not text_line.strip():
            continue
        cells, why = _cells(header, names, needed, text_line)
        if why:
            wrong[len(found)] = f"line {number}: {why}"
        found.append(cells)
    values = np.array(found, dtype=float).reshape(len(found), len(names))
    return {name: values[:, index] for index, name in enumerate(names)}, wrong


def _quick(header: Sequence[str], names: Sequence[str], lines: list[bytes | None]) -> Mapping[str, FloatArray] | None:
    """Return the numbers of lines that are all plain rows; None where one of them asks for a closer look."""
    plain = [line for line in lines if line is not None]
    if len(plain) < len(lines):
        return None
    found = numbers_of(b"\n".join(plain), header, names)
    return found if found is not None and found[names[0]].size == len(lines) else None


def _halved(
    header: Sequence[str], names: Sequence[str], needed: Sequence[str], lines: list[bytes | None], line: int
) -> tuple[Mapping[str, FloatArray], Mapping[int, str]]:
    """Read both halves by themselves: one wrong row costs its neighbours a closer look, not all that came with it."""
    half = len(lines) // 2
    first, wrong_of_first = _readings(header, names, needed, lines[:half], line)
    second, wrong_of_second = _readings(header, names, needed, lines[half:], line + half)
    rows = first[names[0]].size
    wrong = {**wrong_of_first, **{rows + row: why for row, why in wrong_of_second.items()}}
    return {name: np.concatenate([first[name], second[name]]) for name in names}, wrong


def _cells(
    header: Sequence[str], names: Sequence[str], needed: Sequence[str], line: bytes | None
) -> tuple[list[float], str]:
    nothing = [np.nan] * len(names)
    if line is None:
        return nothing, f"longer than {LONGEST_LINE} letters"
    text = line.decode("utf-8", "replace")
    cells = [cell.strip() for cell in (next(csv.reader([text]), []) if '"' in text else text.split(","))]
    if len(cells) != len(header):
        return nothing, f"{len(cells)} {'cell' if len(cells) == 1 else 'cells'} instead of {len(header)}"
    row = dict(zip(header, cells, strict=True))
    bad = [name for name in needed if not is_number(row[name])]
    found = [float(row[name]) if is_number(row[name]) else np.nan for name in names]
    return found, f"{' and '.join(bad)} no number" if bad else ""


def _with_reasons(rows: Rows, wrong: Mapping[int, str]) -> Rows:
    """Return the rows with the reasons of those that could not be read."""
    words, indices = list(rows.words), rows.indices.copy()
    for row, reason in wrong.items():
        indices[row] = len(words)
        words.append(reason)
    return Rows(rows.columns, words, indices)
