"""A CSV file as columns of text, and its cells as numbers and labels; every refusal names file, line and column.

The header is line 1. Commas separate and decimals have a point, unless a :class:`CsvForm` says otherwise; nothing is
converted, clipped or skipped.
"""

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import Final, NoReturn, Protocol

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MISSING = re.compile(r"|nan|[+-]?inf(inity)?", re.IGNORECASE)
_PIECE_ROWS: Final = 16384
_WHOLE = re.compile(r"\d{1,15}(\.0*)?", re.ASCII)


@dataclass(frozen=True)
class Remedies:
    """What a refusal says of whoever reads: what was not done, and by which options the file can be read after all."""

    not_done: str = "nothing was solved"
    column: str = "--axis AXIS=COLUMN for an output"
    """By which columns are named that are called otherwise."""
    separators: str = "calrig fit takes them: --separator semicolon --decimal comma"
    """By which local separators are read; empty: by nothing."""


SOLVING: Final = Remedies()


@dataclass(frozen=True)
class CsvForm:
    """What separates the cells of a file, and the whole part of a number from its decimals."""

    separator: str = ","
    decimal: str = "."
    remedies: Remedies = SOLVING

    @property
    def number(self) -> str:
        """What a number looks like, in words."""
        return f"a finite number with a decimal {'point' if self.decimal == '.' else 'comma'}"

    def swapped(self, cell: str) -> str:
        """Return a cell with point and comma in each other's place where the decimals have a comma.

        A number becomes one with a decimal point, and 1.234 becomes none: whether that were thousands, nobody knows.
        """
        return cell if self.decimal == "." else cell.translate(_SWAPPED)


_SEPARATORS: Final = {";": "semicolons", "\t": "tabs", ",": "commas"}
_SWAPPED: Final = str.maketrans(".,", ",.")
PLAIN: Final = CsvForm()


class NamedColumns(Protocol):
    """A file of which the columns are known."""

    @property
    def file(self) -> str: ...

    @property
    def columns(self) -> tuple[str, ...]: ...

    @property
    def form(self) -> CsvForm: ...


@dataclass(frozen=True)
class Header:
    """The first line of a file."""

    file: str
    columns: tuple[str, ...]
    form: CsvForm = PLAIN


@dataclass(frozen=True)
class CsvTable:
    """Header and rows as they stand."""

    file: str
    columns: tuple[str, ...]
    lines: tuple[int, ...]
    """Line of the file at which each row ends."""
    rows: tuple[tuple[str, ...], ...]
    form: CsvForm = PLAIN

    def column(self, name: str) -> list[str]:
        index = self.columns.index(name)
        return [row[index].strip() for row in self.rows]


def parse_csv(path: Path, form: CsvForm = PLAIN) -> CsvTable:
    """Read header and rows of a file. Raises: ObservationsError: it cannot be read or is no CSV file."""
    tables = list(careful_tables(path, form=form))
    lines = tuple(line for table in tables for line in table.lines)
    return CsvTable(str(path), tables[0].columns, lines, tuple(row for table in tables for row in table.rows), form)


def header_of(path: Path, form: CsvForm = PLAIN) -> Header:
    """Read the names of a file's columns. Raises: ObservationsError: it cannot be read or has none."""
    _, cells = next(_rows(path, 0, 1, form), (0, ()))
    return header_from(str(path), cells, form)


def careful_tables(
    path: Path, header: Header | None = None, start: int = 0, line: int = 1, form: CsvForm = PLAIN
) -> Iterator[CsvTable]:
    """Read a file piece by piece; with ``header`` from a byte on, where ``line`` begins.

    Raises: ObservationsError: it cannot be read, or from there on it is no CSV file.
    """
    rows = _rows(path, start, line, form)
    is_whole = header is None
    if header is None:
        header = header_from(str(path), next(rows, (0, ()))[1], form)
    while piece := list(islice(rows, _PIECE_ROWS)):
        lines, cells = zip(*piece, strict=True)
        table = CsvTable(header.file, header.columns, lines, cells, form)
        _refuse_shape(table)
        is_whole = False
        yield table
    if is_whole:
        raise _no_rows(header)


def _no_rows(header: NamedColumns) -> ObservationsError:
    return ObservationsError(
        f"{header.file}: a header and no rows; {header.form.remedies.not_done}; export the rows again"
    )


def _rows(path: Path, start: int, line: int, form: CsvForm) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Yield the rows that are not blank, each with the line at which it ends."""
    try:
        with path.open("rb") as binary:
            binary.seek(start)
            text = TextIOWrapper(binary, encoding="utf-8" if start else "utf-8-sig", newline="")
            reader = csv.reader(_without_nul(path, text, line, form), strict=True, delimiter=form.separator)
            try:
                for cells in reader:
                    if any(cell.strip() for cell in cells):
                        yield line - 1 + reader.line_num, tuple(cells)
            except csv.Error as failure:
                raise ObservationsError(
                    f"{path}: line {line - 1 + reader.line_num}: not a CSV line ({failure}); "
                    f"{form.remedies.not_done}; correct the line"
                ) from failure
    except UnicodeDecodeError as failure:
        raise _not_utf8(path, failure, form) from failure
    except OSError as failure:
        reason = failure.strerror or str(failure)
        raise ObservationsError(
            f"{path}: cannot be read: {reason}; {form.remedies.not_done}; name a readable file"
        ) from failure


def _without_nul(path: Path, text: Iterable[str], line: int, form: CsvForm) -> Iterator[str]:
    for number, text_line in enumerate(text, start=line):
        if "\x00" in text_line:
            raise ObservationsError(
                f"{path}: line {number}: a NUL character: not a CSV file; {form.remedies.not_done}; export it as CSV"
            )
        yield text_line


def _not_utf8(path: Path, failure: UnicodeDecodeError, form: CsvForm) -> ObservationsError:
    """Return the refusal, with the line of the whole file."""
    try:
        path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as whole:
        failure = whole
    line = failure.object.count(b"\n", 0, failure.start) + 1
    return ObservationsError(
        f"{path}: line {line}: not UTF-8: byte 0x{failure.object[failure.start]:02x}; {form.remedies.not_done}; "
        "save the file as CSV UTF-8"
    )


def header_from(file: str, cells: Sequence[str], form: CsvForm = PLAIN) -> Header:
    """Return the names in the cells of a first line. Raises: ObservationsError: there is none, or they tell nothing."""
    if not cells:
        raise ObservationsError(
            f"{file}: empty: no header and no rows; {form.remedies.not_done}; export the rows again"
        )
    header = Header(file, tuple(cell.strip() for cell in cells), form)
    others = [name for character, name in _SEPARATORS.items() if character in header.columns[0]]
    if len(header.columns) == 1 and others and form.separator not in header.columns[0]:
        options = f" ({form.remedies.separators})" if form.remedies.separators else ""
        raise ObservationsError(
            f"{header.file}: line 1: columns are separated by {others[0]}; allowed: {_SEPARATORS[form.separator]}, "
            f"with decimal {'points' if form.decimal == '.' else 'commas'}; {form.remedies.not_done}; export with "
            f"comma and point, not with the local separators{options}"
        )
    for name in header.columns:
        if header.columns.count(name) > 1:
            raise ObservationsError(
                f"{header.file}: line 1: column {name!r} stands {header.columns.count(name)} times; allowed once; "
                f"{form.remedies.not_done}; rename or remove one"
            )
    return header


def _refuse_shape(table: CsvTable) -> None:
    for line, row in zip(table.lines, table.rows, strict=True):
        if len(row) != len(table.columns):
            raise ObservationsError(
                f"{table.file}: line {line}: {len(row)} cells, allowed {len(table.columns)} as in the header; "
                f"{table.form.remedies.not_done}; complete the line (a decimal comma splits a number in two, a cut "
                "file ends in the middle)"
            )


def table_of(columns: Mapping[str, Sequence[object]], name: str) -> CsvTable:
    """Return columns that a program has at hand as the table that their CSV file would be; lines count from 2.

    Numbers are told in the fewest digits that give them back; a NaN is an empty cell, and a row of nothing else is
    none, as a line of commas alone. Raises: ObservationsError.
    """
    cells = [[_cell_of(value) for value in column] for column in columns.values()]
    filled = {line: row for line, row in enumerate(zip(*cells, strict=True), 2) if any(cell.strip() for cell in row)}
    table = CsvTable(name, header_from(name, tuple(columns)).columns, tuple(filled), tuple(filled.values()))
    if not filled:
        raise _no_rows(table)
    _refuse_shape(table)
    return table


def _cell_of(value: object) -> str:
    """Return a value as the text of its cell."""
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(float(value))
    return str(value)


def refuse_missing_columns(table: NamedColumns, wanted: Sequence[str]) -> None:
    """Refuse a table without the wanted columns.

    Raises: ObservationsError naming those that are not there, and those that are.
    """
    missing = [name for name in dict.fromkeys(wanted) if name not in table.columns]
    if missing:
        raise ObservationsError(
            f"{table.file}: line 1: column {' and '.join(map(repr, missing))} missing; found: "
            f"{', '.join(table.columns)}; {table.form.remedies.not_done}; add the column, or name the one that is "
            f"meant ({table.form.remedies.column})"
        )


def refuse_cell(table: NamedColumns, name: str, line: int, cell: str, allowed: str) -> NoReturn:
    """Refuse a cell. Raises: ObservationsError naming file, line and column."""
    what = "the cell is empty" if cell == "" else f"got {cell!r}"
    raise ObservationsError(
        f"{table.file}: line {line}: column {name}: {what}, allowed {allowed}; "
        f"{table.form.remedies.not_done}; correct or remove the row"
    )


def is_number(cell: str) -> bool:
    """Return whether a cell is a finite number with a decimal point, nothing around it."""
    return _NUMBER.fullmatch(cell) is not None and bool(np.isfinite(float(cell)))


def numbers(table: CsvTable, name: str) -> FloatArray:
    """Return the column as (N,) finite numbers. Raises: ObservationsError."""
    cells = [table.form.swapped(cell) for cell in table.column(name)]
    for line, cell in zip(table.lines, cells, strict=True):
        if not is_number(cell):
            refuse_cell(table, name, line, table.form.swapped(cell), table.form.number)
    return np.array([float(cell) for cell in cells])


def numbers_or_nan(table: CsvTable, name: str) -> FloatArray:
    """Return the column as (N,) numbers, NaN where a cell is empty or says that there is none.

    Raises: ObservationsError for any other word.
    """
    cells = table.column(name)
    for line, cell in zip(table.lines, cells, strict=True):
        if not is_number(cell) and _MISSING.fullmatch(cell) is None:
            refuse_cell(table, name, line, cell, "a number with a decimal point, or nothing where none was read")
    return np.array([float(cell) if is_number(cell) else np.nan for cell in cells])


def labels(table: CsvTable, name: str) -> IntArray:
    """Return the column as (N,) whole numbers from 0. Raises: ObservationsError."""
    cells = [table.form.swapped(cell) for cell in table.column(name)]
    for line, cell in zip(table.lines, cells, strict=True):
        if _WHOLE.fullmatch(cell) is None:
            refuse_cell(table, name, line, table.form.swapped(cell), "a whole number, 0 or more")
    return np.array([int(cell.partition(".")[0]) for cell in cells], dtype=np.int64)
