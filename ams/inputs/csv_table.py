"""A CSV file as columns of text, and its cells as numbers and labels; every refusal names file, line and column.

The header is line 1. Commas separate, decimals have a point; nothing is converted, clipped or skipped.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import NoReturn

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_WHOLE = re.compile(r"\d{1,15}(\.0*)?", re.ASCII)


@dataclass(frozen=True)
class CsvTable:
    """Header and rows as they stand."""

    file: str
    columns: tuple[str, ...]
    lines: tuple[int, ...]
    """Line of the file at which each row ends."""
    rows: tuple[tuple[str, ...], ...]

    def column(self, name: str) -> list[str]:
        place = self.columns.index(name)
        return [row[place].strip() for row in self.rows]


def _read_text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as failure:
        reason = failure.strerror or str(failure)
        raise ObservationsError(
            f"{path}: cannot be read: {reason}; nothing was solved; name a readable file"
        ) from failure
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        line = content.count(b"\n", 0, failure.start) + 1
        raise ObservationsError(
            f"{path}: line {line}: not UTF-8: byte 0x{content[failure.start]:02x}; nothing was solved; "
            "save the file as CSV UTF-8"
        ) from failure


def parse_csv(path: Path) -> CsvTable:
    """Read header and rows of a file. Raises: ObservationsError: it cannot be read or is no CSV file."""
    text = _read_text(path)
    if "\x00" in text:
        line = text.count("\n", 0, text.index("\x00")) + 1
        raise ObservationsError(
            f"{path}: line {line}: a NUL character: not a CSV file; nothing was solved; export it as CSV"
        )
    reader = csv.reader(StringIO(text, newline=""), strict=True)
    lines, rows = [], []
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                lines.append(reader.line_num)
                rows.append(tuple(cells))
    except csv.Error as failure:
        raise ObservationsError(
            f"{path}: line {reader.line_num}: not a CSV line ({failure}); nothing was solved; correct the line"
        ) from failure
    if not rows:
        raise ObservationsError(
            f"{path}: empty: no header and no rows; nothing was solved; export the observations again"
        )
    columns = tuple(cell.strip() for cell in rows[0])
    table = CsvTable(str(path), columns, tuple(lines[1:]), tuple(rows[1:]))
    _refuse_shape(table)
    return table


def _refuse_shape(table: CsvTable) -> None:
    if len(table.columns) == 1 and re.search(r"[;\t]", table.columns[0]):
        character = "semicolons" if ";" in table.columns[0] else "tabs"
        raise ObservationsError(
            f"{table.file}: line 1: columns are separated by {character}; allowed: commas, with decimal points; "
            "nothing was solved; export with comma and point, not with the local separators"
        )
    for name in table.columns:
        if table.columns.count(name) > 1:
            raise ObservationsError(
                f"{table.file}: line 1: column {name!r} stands {table.columns.count(name)} times; allowed once; "
                "nothing was solved; rename or remove one"
            )
    if not table.rows:
        raise ObservationsError(
            f"{table.file}: a header and no rows; nothing was solved; export the observations again"
        )
    for line, row in zip(table.lines, table.rows, strict=True):
        if len(row) != len(table.columns):
            raise ObservationsError(
                f"{table.file}: line {line}: {len(row)} cells, allowed {len(table.columns)} as in the "
                f"header; nothing was "
                "solved; complete the line (a decimal comma splits a number in two, a cut file ends in the middle)"
            )


def table_of(columns: Mapping[str, Sequence[object]], name: str) -> CsvTable:
    """Return columns that a program has at hand as the table that their CSV file would be; lines count from 2.

    Numbers are told in the fewest digits that give them back. Raises: ObservationsError.
    """
    cells = [[_cell(value) for value in column] for column in columns.values()]
    rows = tuple(zip(*cells, strict=True))
    table = CsvTable(name, tuple(columns), tuple(range(2, 2 + len(rows))), rows)
    _refuse_shape(table)
    return table


def _cell(value: object) -> str:
    return repr(float(value)) if isinstance(value, float) else str(value)


def refuse_missing_columns(table: CsvTable, wanted: Sequence[str]) -> None:
    """Refuse a table without the wanted columns.

    Raises: ObservationsError naming those that are not there, and those that are.
    """
    missing = [name for name in dict.fromkeys(wanted) if name not in table.columns]
    if missing:
        raise ObservationsError(
            f"{table.file}: line 1: column {' and '.join(map(repr, missing))} missing; found: "
            f"{', '.join(table.columns)}; "
            "nothing was solved; add the column or name another"
        )


def refuse_cell(table: CsvTable, name: str, line: int, cell: str, allowed: str) -> NoReturn:
    """Refuse a cell. Raises: ObservationsError naming file, line and column."""
    what = "the cell is empty" if cell == "" else f"got {cell!r}"
    raise ObservationsError(
        f"{table.file}: line {line}: column {name}: {what}, allowed {allowed}; nothing was solved; "
        f"correct or remove the row"
    )


def is_number(cell: str) -> bool:
    """Return whether a cell is a finite number with a decimal point, nothing around it."""
    return _NUMBER.fullmatch(cell) is not None and bool(np.isfinite(float(cell)))


def numbers(table: CsvTable, name: str) -> FloatArray:
    """Return the column as (N,) finite numbers. Raises: ObservationsError."""
    cells = table.column(name)
    for line, cell in zip(table.lines, cells, strict=True):
        if not is_number(cell):
            refuse_cell(table, name, line, cell, "a finite number with a decimal point")
    return np.array([float(cell) for cell in cells])


def labels(table: CsvTable, name: str) -> IntArray:
    """Return the column as (N,) whole numbers from 0. Raises: ObservationsError."""
    cells = table.column(name)
    for line, cell in zip(table.lines, cells, strict=True):
        if _WHOLE.fullmatch(cell) is None:
            refuse_cell(table, name, line, cell, "a whole number, 0 or more")
    return np.array([int(cell.partition(".")[0]) for cell in cells], dtype=np.int64)
