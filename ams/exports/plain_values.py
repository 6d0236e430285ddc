"""The document in the terms of formats that know structures and arrays, and whether such a file still says the same.

Lists of numbers are rows, lists of rows are matrices with NaN for null, test vectors are columns.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ams.arrays import FloatArray
from ams.errors import VectorsDisagree
from ams.sets.canonical import Document, Json, listed, table
from ams.sets.coefficients import CoefficientSet


def numeric(values: list[Json]) -> FloatArray | None:
    """Return the list as (n,) row or (n, m) matrix, None where it holds something else than numbers and nulls."""
    rows = [row if isinstance(row, list) else [row] for row in values]
    if not all(entry is None or type(entry) in (int, float) for row in rows for entry in row):
        return None
    if len({len(row) for row in rows}) > 1:
        return None
    matrix = np.array([[np.nan if entry is None else entry for entry in row] for row in rows], dtype=float)
    return matrix if any(isinstance(row, list) for row in values) else matrix.reshape(-1)


def columns(vectors: Json) -> dict[str, Any] | None:
    """Test vectors as named columns (n,), None where there are none."""
    rows = [table(vector) for vector in listed(vectors)]
    return _stacked(rows) if rows else None


def _stacked(rows: list[Document]) -> dict[str, Any]:
    return {
        name: _stacked([table(row[name]) for row in rows])
        if isinstance(first, dict)
        else np.array([row[name] for row in rows], dtype=float)
        for name, first in rows[0].items()
    }


def used_numbers(section: Document) -> Document:
    """Return what somebody takes out of an axis' section to evaluate it."""
    parameters = table(section["parameters"])
    return {
        "nominal_axis": section["nominal_axis"],
        "equation": section["equation"],
        "primary": {"values": table(section["primary"])["values"]},
        "parameters": {name: {"value": table(entry)["value"]} for name, entry in parameters.items()},
    }


def agrees(read: Any, expected: Any) -> bool:
    """Return whether what was read holds at least what is expected, number for number."""
    if isinstance(expected, Mapping):
        return isinstance(read, Mapping) and all(
            name in read and agrees(read[name], inner) for name, inner in expected.items()
        )
    read, expected = np.ravel(read), np.ravel(expected)
    both_numbers = read.dtype.kind == expected.dtype.kind == "f"
    return bool(np.array_equal(read, expected, equal_nan=both_numbers))


def check_same(read: Any, expected: Any, part: str, where: str) -> None:
    """Refuse a format's own numbers that are others than those of the document in the file.

    Raises: VectorsDisagree.
    """
    if not agrees(read, expected):
        raise VectorsDisagree(
            f"{where}: {part}: the file's own are others than those of the document in the same file; "
            "do not use this file; export the set again"
        )


def axes_used(coefficients: CoefficientSet) -> Document:
    """Return ``used_numbers`` of every axis."""
    return {name: used_numbers(table(section)) for name, section in table(coefficients.document["axes"]).items()}
