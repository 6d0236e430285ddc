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

from ams.errors import SetError
from ams.exports.checksum_line import INTACT
from ams.exports.format import Format
from ams.exports.json_text import from_json, to_json
from ams.exports.plain_values import axes_used, check_same, columns, numeric
from ams.sets.canonical import Document, Json
from ams.sets.coefficients import CoefficientSet

HEAD_BYTES = 116
HEAD = b"MATLAB 5.0 MAT-file calrig, SHA-256 from byte 117: "
VARIABLE = "calrig"
LONGEST_NAME = 63
HOW_TO_READ = (
    "calrig.axes.x.primary.values and calrig.axes.x.equation.primary give the output of axis x; check yours against "
    "calrig.test_vectors.forward. [] is null, in matrices NaN. jsondecode(calrig.document_json) is the whole set."
)


def to_matlab(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a MATLAB file; the same set gives the same bytes."""
    from scipy.io import savemat

    file = io.BytesIO()
    document = coefficients.document
    content = _matlab({key: value for key, value in document.items() if key != "test_vectors"})
    content["test_vectors"] = _vectors_struct(coefficients.test_vectors)
    content["how_to_read"] = HOW_TO_READ
    content["document_json"] = to_json(coefficients).decode("utf-8")
    savemat(file, {VARIABLE: dict(content)}, long_field_names=True, oned_as="row")  # type: ignore[arg-type]  # the stubs lack file objects
    body = file.getvalue()[HEAD_BYTES:]
    return _head(body) + body


def from_matlab(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError where the file is damaged or no set; VectorsDisagree where its struct holds other numbers than the
    document in it.
    """
    _check_head(content, where)
    struct = _read_struct(content, where)
    coefficients = from_json(str(struct["document_json"]).encode("utf-8"), f"{where}: document_json")
    # A struct may tell its reader something else than the document inside it.
    check_same(struct["axes"], _matlab(axes_used(coefficients)), "axes", where)
    check_same(struct["test_vectors"], _vectors_struct(coefficients.test_vectors), "test_vectors", where)
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


def _vectors_struct(section: Document) -> dict[str, Any]:
    texts = {key: _matlab(value) for key, value in section.items() if key not in ("forward", "inverse")}
    return {**texts, "forward": _columns(section["forward"]), "inverse": _columns(section["inverse"])}


def _columns(vectors: Json) -> Any:
    """Return a struct of columns from a list of test vectors; [] where there are none."""
    found = columns(vectors)
    return np.zeros((0, 0)) if found is None else _upright(found)


def _upright(columns: Mapping[str, Any]) -> dict[str, Any]:
    named: dict[str, Any] = {}
    for key, column in columns.items():
        named[_name(key, named)] = _upright(column) if isinstance(column, Mapping) else column.reshape(-1, 1)
    return named


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
    matrix = numeric(values)
    if matrix is not None:
        return np.atleast_2d(matrix)
    cells = np.empty((1, len(values)), dtype=object)
    for index, inner in enumerate(values):
        cells[0, index] = _matlab(inner)
    return cells


def _name(key: str, taken: Mapping[str, Any]) -> str:
    """Return a field name that MATLAB allows and that is not taken."""
    allowed = re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", key) is not None and len(key) <= LONGEST_NAME
    stem = key if allowed else "f_" + re.sub(r"[^A-Za-z0-9_]", "_", key)[: LONGEST_NAME - 6]
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem[: LONGEST_NAME - 4]}_{number}", number + 1
    return name


FORMAT = Format("mat", ".mat", to_matlab, from_matlab)
