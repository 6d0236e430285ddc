"""Rows of angles as CSV, JSON lines or Parquet, written piece by piece.

Text has nine digits of every number, and nothing where there is none. pyarrow writes CSV where it is installed, pandas
where it is not; a handful of rows, as a stream brings them, is written sooner than either has begun.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Final, Protocol

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.attitude.flag_codes import distinct_words
from ams.inference.rows.angle_stream import Answer
from ams.inputs.number_blocks import parquet
from procedures.errors import RequestError

FEW_ROWS: Final = 50
_DIGITS: Final = 9
_POWERS: Final = np.array([10.0**power for power in range(23)])
"""Those that are exact."""


@dataclass(frozen=True)
class Rows:
    """Answers with the words of their flags, each of which stands once."""

    columns: Mapping[str, FloatArray]
    words: Sequence[str]
    indices: IntArray
    """(N,) of every row's flag among the words."""

    @classmethod
    def of(cls, answer: Answer) -> "Rows":
        words, indices = distinct_words(answer.codes, answer.reasons)
        return cls(answer.columns, words, indices)

    @property
    def flags(self) -> list[str]:
        return [self.words[index] for index in self.indices.tolist()]


class RowWriter(Protocol):
    """What takes answers and makes a file of them."""

    def write(self, rows: Rows) -> None:
        """Append rows."""

    def close(self) -> None:
        """Write what is still to be written; the file itself stays open."""

    def discard(self) -> None:
        """End without a word: what was written is thrown away."""


def writer_named(name: Path | None, file: IO[bytes], columns: Sequence[str]) -> RowWriter:
    """Return the writer that a file's name asks for; without one, CSV.

    Raises: RequestError for another name, ObservationsError for Parquet without pyarrow.
    """
    writer = WRITERS.get(".csv" if name is None else name.suffix)
    if writer is None:
        raise RequestError(
            f"--out {name}: the name must end in .csv or .jsonl or, for files, .parquet; nothing was written"
        )
    return writer(file, columns)


@dataclass
class CsvRows:
    """A header, and one line a row."""

    file: IO[bytes]
    columns: Sequence[str]

    def __post_init__(self) -> None:
        self.file.write((",".join(self.columns) + "\n").encode())

    def write(self, rows: Rows) -> None:
        if rows.indices.size <= FEW_ROWS:
            text = "".join(row_lines(self.columns, {**rows.columns, "flag": rows.flags}))
            self.file.write(text.encode())
        elif find_spec("pyarrow") is not None:
            writer = import_module("pyarrow.csv")
            # pyarrow's "needed" quotes every text, also those that need it not.
            style = "none" if all(_quoted(word) == word for word in rows.words) else "needed"
            options = writer.WriteOptions(include_header=False, quoting_style=style)
            writer.write_csv(_arrow_table(rows, nine_digits), self.file, options)
        else:
            import pandas as pd

            rounded = {name: nine_digits(values) for name, values in rows.columns.items()}
            flags = np.array(rows.words, dtype=object)[rows.indices]
            pd.DataFrame({**rounded, "flag": flags}).to_csv(self.file, header=False, index=False)

    def close(self) -> None:
        """Nothing is held back."""

    def discard(self) -> None:
        """Nothing is held back."""


@dataclass
class JsonRows:
    """One JSON document a line."""

    file: IO[bytes]
    columns: Sequence[str]

    def write(self, rows: Rows) -> None:
        if not rows.indices.size:
            return
        import pandas as pd

        rounded = {name: nine_digits(values) for name, values in rows.columns.items()}
        frame = pd.DataFrame({**rounded, "flag": np.array(rows.words, dtype=object)[rows.indices]})
        text = frame.to_json(orient="records", lines=True, double_precision=15, force_ascii=False)
        self.file.write(text.encode())

    def close(self) -> None:
        """Nothing is held back."""

    def discard(self) -> None:
        """Nothing is held back."""


class ParquetRows:
    """A Parquet file; every number with all its digits."""

    def __init__(self, file: IO[bytes], columns: Sequence[str]) -> None:
        arrow = parquet()
        types = import_module("pyarrow")
        schema = types.schema([(name, types.string() if name == "flag" else types.float64()) for name in columns])
        self._writer = arrow.ParquetWriter(file, schema)

    def write(self, rows: Rows) -> None:
        self._writer.write_table(_arrow_table(rows, lambda values: values))

    def close(self) -> None:
        self._writer.close()

    def discard(self) -> None:
        self._writer.close()


WRITERS: Final[Mapping[str, Callable[[IO[bytes], Sequence[str]], RowWriter]]] = {
    ".csv": CsvRows,
    ".jsonl": JsonRows,
    ".parquet": ParquetRows,
}


def row_lines(names: Sequence[str], answer: Mapping[str, Any]) -> Iterator[str]:
    """Yield one line a row; what is not a number is an empty cell."""
    for row in zip(*(answer[name] for name in names), strict=True):
        yield ",".join(_quoted(cell) if isinstance(cell, str) else _cell(cell) for cell in row) + "\n"


def nine_digits(values: FloatArray) -> FloatArray:
    """Return the numbers with nine significant digits, so that their shortest form has no more."""
    size = np.abs(values)
    with np.errstate(divide="ignore", invalid="ignore"):
        decimals = _DIGITS - 1 - np.nan_to_num(np.floor(np.log10(size)), nan=0.0, neginf=0.0, posinf=0.0)
    shift = _POWERS[np.clip(np.abs(decimals), 0, _POWERS.size - 1).astype(np.int64)]
    return np.asarray(np.where(decimals >= 0.0, np.rint(values * shift) / shift, np.rint(values / shift) * shift))


def _arrow_table(rows: Rows, rounded: Callable[[FloatArray], FloatArray]) -> Any:
    arrow = import_module("pyarrow")
    columns = {name: arrow.array(rounded(values), mask=np.isnan(values)) for name, values in rows.columns.items()}
    return arrow.table(
        {**columns, "flag": arrow.array(list(rows.words), arrow.string()).take(arrow.array(rows.indices))}
    )


def _quoted(cell: str) -> str:
    return '"' + cell.replace('"', '""') + '"' if any(letter in cell for letter in ',"\n') else cell


def _cell(value: float) -> str:
    return "" if value != value else f"{value:.9g}"
