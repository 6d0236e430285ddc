"""Parquet: one row a value of the whole document, and the document itself with its checksum in the file's metadata.

Columns: ``path``, ``kind``, ``value`` (text) and ``unit`` as in the CSV export, and ``number`` (double, null where the
value is none), so that a query needs no parsing. The metadata key ``file_sha256`` holds the SHA-256 of the file, taken
with 64 zeros in its place.
"""

import io
from typing import Any

from ams.errors import SetError
from ams.exports.checksum_inside import CHECKSUM_SLOT, check_inside, check_layout, with_checksum_inside
from ams.exports.checksum_line import INTACT
from ams.exports.csv_text import HEADER, rows_of
from ams.exports.format import Format
from ams.exports.json_text import from_json, to_json
from ams.exports.optional_libraries import library
from ams.exports.plain_values import check_same
from ams.sets.coefficients import CoefficientSet

MAGIC = b"PAR1"
LAYOUT = "calrig coefficient set as Parquet, version 1"
DOCUMENT = "document_json"
COLUMNS = ("path", "kind", "number", "value", "unit")


def to_parquet(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a Parquet file; the same set gives the same bytes.

    Raises: SetError where pyarrow is missing.
    """
    arrow = library("pyarrow", f"{coefficients.sensor}: Parquet")
    parquet = library("pyarrow.parquet", f"{coefficients.sensor}: Parquet")
    schema = arrow.schema([(name, arrow.float64() if name == "number" else arrow.string()) for name in COLUMNS])
    memory = io.BytesIO()
    with parquet.ParquetWriter(memory, schema, compression="none", store_schema=False) as writer:
        writer.write_table(arrow.table(_columns(coefficients), schema=schema))
        writer.add_key_value_metadata(
            {
                "file_format": LAYOUT,
                "file_sha256": CHECKSUM_SLOT.decode(),
                DOCUMENT: to_json(coefficients).decode("utf-8"),
            }
        )
    return with_checksum_inside(memory.getvalue())


def from_parquet(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError where the file is damaged or no set, or pyarrow is missing; VectorsDisagree where its rows are not
    those of the document in it.
    """
    check_inside(content, MAGIC, "Parquet", where)
    arrow, parquet = library("pyarrow", where), library("pyarrow.parquet", where)
    try:
        with parquet.ParquetFile(io.BytesIO(content)) as file:
            metadata: dict[bytes, bytes] = file.metadata.metadata or {}
            document = metadata[DOCUMENT.encode()]
            rows = file.read(columns=list(COLUMNS))
        read = {name: rows.column(name).to_pylist() for name in COLUMNS}
    except (arrow.ArrowException, KeyError) as error:
        raise SetError(f"{where}: has no {DOCUMENT} and rows to read: {error}; {INTACT}") from error
    check_layout(metadata.get(b"file_format", b"").decode(), LAYOUT, where)
    coefficients = from_json(document, f"{where}: {DOCUMENT}")
    check_same(_comparable(read), _comparable(_columns(coefficients)), "rows", where)
    return coefficients


def _columns(coefficients: CoefficientSet) -> dict[str, list[Any]]:
    rows = [dict(zip(HEADER, row, strict=True)) for row in rows_of(coefficients.document)]
    numbers = [float(row["value"]) if row["kind"] == "number" else None for row in rows]
    return {name: numbers if name == "number" else [row[name] for row in rows] for name in COLUMNS}


def _comparable(columns: dict[str, list[Any]]) -> dict[str, list[str]]:
    return {name: [repr(value) for value in column] for name, column in columns.items()}


FORMAT = Format("parquet", ".parquet", to_parquet, from_parquet, needs=("pyarrow",))
