"""Columns of numbers from a file of any size, piece by piece: CSV and Parquet.

pandas reads the numbers, many thousand rows at a time. It forgives more than a table of measurements may be forgiven
(cells too few or too many, "inf", words that stand for nothing), so a piece is taken from it only where every line has
as many commas as the header and every number is finite; anything else goes through the careful reader of
:mod:`ams.inputs.csv_table`, which accepts what is odd and right (quotes, blank lines) and words every refusal.
"""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError
from ams.inputs.csv_table import (
    PLAIN,
    SOLVING,
    CsvForm,
    CsvTable,
    Header,
    Remedies,
    careful_tables,
    header_of,
    labels,
    numbers,
    numbers_or_nan,
    refuse_missing_columns,
)

PIECE_BYTES: Final = 1 << 21
"""Of a CSV file read at once; no row is longer."""
PIECE_ROWS: Final = 65536
"""Of a Parquet file read at once."""
SMALL_BYTES: Final = 1 << 18
"""A file up to this length is read sooner by the careful way than pandas is imported."""
_LARGEST_LABEL: Final = 1e15
_NOTHING: Final = re.compile(rb"(?m)^,+$")

Block = Mapping[str, FloatArray]
"""(n,) numbers by column."""


@dataclass(frozen=True)
class NumberTable:
    """A whole file's columns of numbers, with the line that each row stands on."""

    file: str
    columns: tuple[str, ...]
    lines: IntArray
    values: Block
    rows: CsvTable | None = None
    """The cells themselves, where there is no file to look at again."""

    @property
    def form(self) -> CsvForm:
        return PLAIN if self.rows is None else self.rows.form

    def labels(self, name: str) -> IntArray:
        """Return the column as (N,) whole numbers from 0. Raises: ObservationsError."""
        values = self.values[name]
        if np.all((values >= 0.0) & (values < _LARGEST_LABEL) & (values == np.floor(values))):
            return values.astype(np.int64)
        tables = careful_tables(Path(self.file)) if self.rows is None else (self.rows,)
        return np.concatenate([labels(table, name) for table in tables])


def numbers_in(table: CsvTable, wanted: Sequence[str], optional: Sequence[str] = ()) -> NumberTable:
    """Return columns of a table that is read already, as :func:`read_numbers` does. Raises: ObservationsError."""
    refuse_missing_columns(table, wanted)
    names = dict.fromkeys((*wanted, *(name for name in optional if name in table.columns)))
    values = {name: numbers(table, name) for name in names}
    return NumberTable(table.file, table.columns, np.array(table.lines), values, table)


def read_numbers(path: Path, wanted: Sequence[str], optional: Sequence[str] = ()) -> NumberTable:
    """Read columns of a CSV file that must be there, and others where they are. Raises: ObservationsError."""
    header, names = _named(path, wanted, optional)
    pieces = list(_csv_pieces(path, header, names))
    values = {name: np.concatenate([found[name] for _, found in pieces]) for name in names}
    return NumberTable(header.file, header.columns, np.concatenate([lines for lines, _ in pieces]), values)


def csv_blocks(
    path: Path, wanted: Sequence[str], optional: Sequence[str] = (), remedies: Remedies = SOLVING
) -> Iterator[Block]:
    """Yield columns of a CSV file piece by piece; what is missing in it is NaN.

    Raises: ObservationsError, at the piece that is wrong.
    """
    header, names = _named(path, wanted, optional, CsvForm(remedies=remedies))
    for _, found in _csv_pieces(path, header, names, may_miss=True):
        yield found


def _named(
    path: Path, wanted: Sequence[str], optional: Sequence[str], form: CsvForm = PLAIN
) -> tuple[Header, list[str]]:
    header = header_of(path, form)
    refuse_missing_columns(header, wanted)
    return header, list(dict.fromkeys((*wanted, *(name for name in optional if name in header.columns))))


def _csv_pieces(
    path: Path, header: Header, names: Sequence[str], *, may_miss: bool = False
) -> Iterator[tuple[IntArray, Block]]:
    """Yield the lines and the numbers of each piece; from the first that is odd, as the careful reader says."""
    start, line = 0, 1
    with path.open("rb") as file:
        first = file.readline(PIECE_BYTES)
        if path.stat().st_size > SMALL_BYTES and _is_one_plain_line(first):
            start, line = len(first), 2
            for piece in whole_lines(file):
                found = numbers_of(piece, header.columns, names, may_miss=may_miss)
                if found is None:
                    break
                yield np.arange(line, line + found[names[0]].size), found
                start, line = start + len(piece), line + found[names[0]].size
            else:
                return
    for table in careful_tables(path, header if start else None, start, line, header.form):
        cells = numbers_or_nan if may_miss else numbers
        yield np.array(table.lines), {name: cells(table, name) for name in names}


def whole_lines(file: IO[bytes]) -> Iterator[bytes]:
    """Yield what is left of a file in pieces that end with a line, the last as it stands."""
    rest = b""
    while read := file.read(PIECE_BYTES):
        whole, end, rest = (rest + read).rpartition(b"\n")
        if end:
            yield whole + end
        elif len(rest) > PIECE_BYTES:
            yield rest
            rest = b""
    if rest:
        yield rest


def _is_one_plain_line(header: bytes) -> bool:
    return bool(header.strip()) and b'"' not in header and header.endswith(b"\n") and b"\r" not in header[:-2]


def numbers_of(
    piece: bytes, columns: Sequence[str], names: Sequence[str], *, may_miss: bool = False
) -> dict[str, FloatArray] | None:
    """Return the columns of whole lines of a CSV file; None where the careful reader must look at them.

    Where cells ``may_miss``, those that are empty or say so are NaN; a line of commas alone is no row.
    """
    # A quote, a NUL or a byte beyond ASCII asks for a closer look.
    if not (piece.isascii() and b'"' not in piece and b"\0" not in piece):
        return None
    piece = piece.replace(b"\r\n", b"\n") if b"\r" in piece else piece
    piece = piece.rstrip(b"\n") + b"\n"
    lines = _rectangular_lines(piece, len(columns))
    if lines is None or b"\r" in piece or (may_miss and _NOTHING.search(piece)):
        return None
    import pandas as pd

    indices = [columns.index(name) for name in names]
    try:
        frame = pd.read_csv(
            io.BytesIO(piece),
            header=None,
            usecols=indices,
            dtype=np.float64,
            engine="c",
            na_filter=may_miss,
            keep_default_na=False,
            na_values=[""],
        )
    except (ValueError, OverflowError):
        return None
    if len(frame) != lines:
        return None
    found = {name: frame[index].to_numpy() for name, index in zip(names, indices, strict=True)}
    if not all(np.isfinite(values).all() for values in found.values()):
        if not may_miss:
            return None
        found = {name: np.where(np.isfinite(values), values, np.nan) for name, values in found.items()}
    # A column of nothing but the words true and false comes out as ones and zeros.
    is_words = any(np.all((values == 0.0) | (values == 1.0) | np.isnan(values)) for values in found.values())
    return None if is_words and re.search(rb"(?i)true|false", piece) else found


def _rectangular_lines(piece: bytes, columns: int) -> int | None:
    """Return the number of lines, None where one has too few or too many commas or is blank."""
    letters = np.frombuffer(piece, dtype=np.uint8)
    ends = np.flatnonzero(letters == ord("\n"))
    if columns == 1:
        is_right = piece.count(b",") == 0 and b"\n\n" not in piece and not piece.startswith(b"\n")
        return ends.size if is_right else None
    commas = np.flatnonzero(letters == ord(","))
    if commas.size != ends.size * (columns - 1):
        return None
    rows = commas.reshape(ends.size, columns - 1)
    is_right = bool(np.all(rows[:, -1] < ends) and np.all(rows[1:, 0] > ends[:-1]))
    return ends.size if is_right else None


def parquet_blocks(
    path: Path, wanted: Sequence[str], optional: Sequence[str] = (), remedies: Remedies = SOLVING
) -> Iterator[Block]:
    """Yield columns of a Parquet file piece by piece; what is missing in it is NaN.

    Raises: ObservationsError for a file that is none, a column that is missing or holds no numbers.
    """
    arrow = parquet()
    try:
        file = arrow.ParquetFile(path)
        columns = list(file.schema_arrow.names)
    except (OSError, ValueError) as error:
        raise ObservationsError(f"{path}: cannot be read as Parquet: {str(error).splitlines()[0]}") from error
    refuse_missing_names(path, wanted, columns, remedies)
    names = list(dict.fromkeys((*wanted, *(name for name in optional if name in columns))))
    with file:
        for batch in file.iter_batches(batch_size=PIECE_ROWS, columns=names):
            yield {name: _numbers_of_arrow(path, name, batch.column(name), remedies) for name in names}


def refuse_missing_names(path: Path, wanted: Sequence[str], columns: Sequence[str], remedies: Remedies) -> None:
    """Refuse a binary file without the wanted columns. Raises: ObservationsError."""
    missing = [name for name in wanted if name not in columns]
    if missing:
        raise ObservationsError(
            f"{path}: column {', '.join(missing)} missing; found: {', '.join(columns) or 'none'}; {remedies.not_done}; "
            f"add the column, or name the one that is meant ({remedies.column})"
        )


def _numbers_of_arrow(path: Path, name: str, column: Any, remedies: Remedies) -> FloatArray:
    try:
        return np.asarray(column.cast("float64", safe=False).to_numpy(zero_copy_only=False))
    except (NotImplementedError, TypeError, ValueError):
        raise ObservationsError(f"{path}: column {name}: holds no numbers; {remedies.not_done}") from None


def parquet() -> Any:
    """Return pyarrow's module for Parquet. Raises: ObservationsError where it is not installed."""
    if find_spec("pyarrow") is None:
        raise ObservationsError(
            "Parquet: the library pyarrow is not installed; nothing was written; install calrig[export], or use CSV"
        )
    return import_module("pyarrow.parquet")
