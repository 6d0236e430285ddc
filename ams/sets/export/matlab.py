"""MATLAB ``.mat`` (level 5): a struct ``calrig`` with the document's own names, and the document itself as text.

Tables are structs, lists of numbers are rows, lists of rows are matrices, lists of text are cells, null is [] (NaN
inside a matrix), true and false are logicals, test vectors are columns. A name that MATLAB does not allow has ``f_``
before it. The 116 bytes of text at the head of the file hold the SHA-256 of everything behind them.
"""

import hashlib
import io
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ams.errors import SetError, VectorsDisagree
from ams.sets.canonical import Document, Json, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.export.json_text import from_json, to_json

HEAD_BYTES = 116
HEAD = b"MATLAB 5.0 MAT-file calrig, SHA-256 from byte 117: "
VARIABLE = "calrig"
LONGEST_NAME = 63
HOW_TO_READ = (
    "calrig.axes.x.primary.values and calrig.axes.x.equation.primary give the output of axis x; check yours against "
    "calrig.test_vectors.forward. [] is null, in matrices NaN. jsondecode(calrig.document_json) is the whole set."
)
INTACT = "the set is not used; take an intact copy, or export the set again"


def to_matlab(coefficients: CoefficientSet) -> bytes:
    """The bytes of the file; the same set gives the same bytes."""
    from scipy.io import savemat

    file = io.BytesIO()
    savemat(file, {VARIABLE: _struct(coefficients)}, long_field_names=True, oned_as="row")  # type: ignore[arg-type]  # the stubs lack file objects
    body = file.getvalue()[HEAD_BYTES:]
    return _head(body) + body


def from_matlab(content: bytes, where: str) -> CoefficientSet:
    """The set in the bytes of a file.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its struct holds other numbers than the
    document in it.
    """
    _check_head(content, where)
    struct = _read_struct(content, where)
    coefficients = from_json(str(struct["document_json"]).encode("utf-8"), f"{where}: document_json")
    _check_numbers(struct, coefficients, where)
    return coefficients


def _head(body: bytes) -> bytes:
    return (HEAD + hashlib.sha256(body).hexdigest().encode()).ljust(HEAD_BYTES)


def _check_head(content: bytes, where: str) -> None:
    if not content:
        raise SetError(f"{where}: is empty: got 0 bytes; {INTACT}")
    if not content.startswith(HEAD):
        raise SetError(
            f"{where}: is not a coefficient set as MATLAB file: it begins with {content[:40]!r}, needed is {HEAD!r}; "
            f"it is another kind of file, was saved again by another program, or is damaged; {INTACT}"
        )
    if content[:HEAD_BYTES] != _head(content[HEAD_BYTES:]):
        raise SetError(
            f"{where}: checksum: does not fit the {len(content)} bytes of the file: truncated, changed or damaged "
            f"after it was written; {INTACT}"
        )


def _read_struct(content: bytes, where: str) -> Mapping[str, Any]:
    from scipy.io import loadmat

    file = io.BytesIO(content)
    struct = loadmat(file, simplify_cells=True).get(VARIABLE)  # type: ignore[arg-type]  # the stubs lack file objects
    if not isinstance(struct, Mapping) or not {"document_json", "axes", "test_vectors"} <= set(struct):
        raise SetError(f"{where}: has no struct {VARIABLE!r} with document_json, axes and test_vectors; {INTACT}")
    return struct


def _struct(coefficients: CoefficientSet) -> dict[str, Any]:
    document = coefficients.document
    content = _matlab({key: value for key, value in document.items() if key != "test_vectors"})
    content["test_vectors"] = _vectors_struct(coefficients.test_vectors)
    content["how_to_read"] = HOW_TO_READ
    content["document_json"] = to_json(coefficients).decode("utf-8")
    return dict(content)


def _vectors_struct(section: Document) -> dict[str, Any]:
    texts = {key: _matlab(value) for key, value in section.items() if key not in ("forward", "inverse")}
    return {**texts, "forward": _columns(section["forward"]), "inverse": _columns(section["inverse"])}


def _columns(vectors: Json) -> Any:
    """A struct of columns from a list of test vectors; [] where there are none."""
    if not isinstance(vectors, list):
        return np.zeros((0, 0))
    return _stacked([vector for vector in vectors if isinstance(vector, dict)])


def _stacked(tables: list[Document]) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    for key, first in tables[0].items():
        inner = [table[key] for table in tables]
        if isinstance(first, dict):
            columns[_name(key, columns)] = _stacked([table for table in inner if isinstance(table, dict)])
        else:
            columns[_name(key, columns)] = np.array(inner, dtype=float).reshape(-1, 1)
    return columns


def _matlab(value: Json) -> Any:
    if isinstance(value, dict):
        named: dict[str, Any] = {}
        for key, inner in value.items():
            named[_name(key, named)] = _matlab(inner)
        return named if named else np.zeros((0, 0))
    if isinstance(value, list):
        return _matlab_list(value)
    if value is None:
        return np.zeros((0, 0))
    return value if isinstance(value, str | bool) else float(value)


def _matlab_list(values: list[Json]) -> Any:
    rows = [row if isinstance(row, list) else [row] for row in values]
    numeric = all(entry is None or type(entry) in (int, float) for row in rows for entry in row)
    if numeric and len({len(row) for row in rows}) <= 1:
        matrix = np.array([[np.nan if entry is None else entry for entry in row] for row in rows], dtype=float)
        is_row = not any(isinstance(row, list) for row in values)
        return matrix.reshape(1, -1) if is_row else matrix
    cells = np.empty((1, len(values)), dtype=object)
    for index, inner in enumerate(values):
        cells[0, index] = _matlab(inner)
    return cells


def _name(key: str, taken: Mapping[str, Any]) -> str:
    """A field name that MATLAB allows and that is not taken."""
    allowed = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", key) is not None and len(key) <= LONGEST_NAME
    stem = key if allowed else "f_" + re.sub(r"[^A-Za-z0-9_]", "_", key)[: LONGEST_NAME - 6]
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem[: LONGEST_NAME - 4]}_{number}", number + 1
    return name


def _check_numbers(struct: Mapping[str, Any], coefficients: CoefficientSet, where: str) -> None:
    """What a reader of the struct uses is what the document says. Raises: VectorsDisagree."""
    axes = table(coefficients.document["axes"])
    expected = _matlab({name: _used_numbers(table(section)) for name, section in axes.items()})
    if not _agrees(struct["axes"], expected):
        raise VectorsDisagree(
            f"{where}: axes: the struct holds other coefficients than the document in the same file; "
            "do not use this file; export the set again"
        )
    if not _agrees(struct["test_vectors"], _vectors_struct(coefficients.test_vectors)):
        raise VectorsDisagree(
            f"{where}: test_vectors: the struct holds other test vectors than the document in the same file; "
            "do not use this file; export the set again"
        )


def _used_numbers(section: Document) -> Document:
    parameters = table(section["parameters"])
    return {
        "nominal_axis": section["nominal_axis"],
        "equation": section["equation"],
        "primary": {"values": table(section["primary"])["values"]},
        "parameters": {name: {"value": table(entry)["value"]} for name, entry in parameters.items()},
    }


def _agrees(read: Any, expected: Any) -> bool:
    """Whether what was read holds at least what is expected, number for number."""
    if isinstance(expected, dict):
        return isinstance(read, dict) and all(
            name in read and _agrees(read[name], inner) for name, inner in expected.items()
        )
    return bool(np.array_equal(np.ravel(read), np.ravel(expected)))
