"""HDF5: the document's own names as groups and datasets, units as attributes, and the document itself as text.

Tables are groups, numbers are scalars, lists of numbers are rows, lists of rows are matrices with NaN for null, test
vectors are columns, null is an empty dataset. In names ~0 stands for ~, ~1 for /, ~2 for a name of dots, ~3 for none.
The root attribute ``file_sha256`` holds the SHA-256 of the file, taken with 64 zeros in its place; there is no user
block, because not every reader knows that addresses count from behind it.
"""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from ams.errors import SetError
from ams.exports.checksum_inside import CHECKSUM_SLOT, check_inside, check_layout, with_checksum_inside
from ams.exports.checksum_line import INTACT
from ams.exports.csv_text import unit_below
from ams.exports.format import Format
from ams.exports.json_text import from_json, to_json
from ams.exports.optional_libraries import library
from ams.exports.plain_values import axes_used, check_same, columns, numeric
from ams.sets.canonical import Json
from ams.sets.coefficients import CoefficientSet

MAGIC = b"\x89HDF\r\n\x1a\n"
LAYOUT = "calrig coefficient set as HDF5, version 1"
DOCUMENT = "document_json"
HOW_TO_READ = (
    "axes/x/primary/values and axes/x/equation/primary give the output of axis x; check yours against "
    "test_vectors/forward; document_json is the whole set"
)


def to_hdf5(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of an HDF5 file; the same set gives the same bytes.

    Raises: SetError where h5py is missing.
    """
    h5py = library("h5py", f"{coefficients.sensor}: HDF5")
    memory = io.BytesIO()
    with h5py.File(memory, "w", libver=("earliest", "v110")) as file:
        file.attrs["file_format"] = LAYOUT
        file.attrs["file_sha256"] = np.bytes_(CHECKSUM_SLOT)
        file.attrs["how_to_read"] = HOW_TO_READ
        file.create_dataset(DOCUMENT, data=to_json(coefficients).decode("utf-8"))
        for name, value in coefficients.document.items():
            if name != "test_vectors":
                _write(file, name, value, unit_below(coefficients.document, name, ""))
        _write_vectors(file, coefficients)
    return with_checksum_inside(memory.getvalue())


def from_hdf5(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError where the file is damaged or no set, or h5py is missing; VectorsDisagree where its datasets hold
    other numbers than the document in it.
    """
    check_inside(content, MAGIC, "HDF5", where)
    h5py = library("h5py", where)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            layout, text = file.attrs.get("file_format"), file[DOCUMENT].asstr()[()]
            read = {name: _read(file[name], h5py) for name in ("axes", "test_vectors")}
    except (OSError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise SetError(
            f"{where}: has no {DOCUMENT}, axes and test_vectors that HDF5 can read: {error}; {INTACT}"
        ) from error
    check_layout(layout, LAYOUT, where)
    coefficients = from_json(str(text).encode("utf-8"), f"{where}: {DOCUMENT}")
    check_same(read["axes"], _plain(axes_used(coefficients)), "axes", where)
    check_same(read["test_vectors"], _named(_vectors(coefficients)), "test_vectors", where)
    return coefficients


def _write(group: Any, key: str, value: Json, unit: str) -> None:
    name = _name(key)
    if isinstance(value, dict):
        inside = group.create_group(name)
        for inner, content in value.items():
            _write(inside, inner, content, unit_below(value, inner, unit))
        return
    array = numeric(value) if isinstance(value, list) else None
    if isinstance(value, list) and array is None and not all(isinstance(entry, str) for entry in value):
        inside = group.create_group(name)
        for index, content in enumerate(value):
            _write(inside, str(index), content, unit)
        return
    dataset = group.create_dataset(name, data=_data(value) if array is None else array)
    if unit and dataset.dtype.kind == "f":
        dataset.attrs["unit"] = unit


def _data(value: Json) -> Any:
    """Return a leaf as HDF5 knows it: null as an empty dataset, integers as doubles, lists of text as lists of text."""
    if value is None:
        from h5py import Empty

        return Empty("f8")
    return float(value) if type(value) is int else value


def _write_vectors(file: Any, coefficients: CoefficientSet) -> None:
    group = file.create_group("test_vectors")
    for key, value in coefficients.test_vectors.items():
        if key not in ("forward", "inverse"):
            _write(group, key, value, "")
    for kind, found in _vectors(coefficients).items():
        _write_columns(group.create_group(kind), found)


def _write_columns(group: Any, found: Mapping[str, Any], unit: str = "") -> None:
    for key, column in found.items():
        here = unit_below({}, key, unit)
        if isinstance(column, Mapping):
            _write_columns(group.create_group(_name(key)), column, here)
        else:
            group.create_dataset(_name(key), data=column).attrs["unit"] = here


def _vectors(coefficients: CoefficientSet) -> dict[str, Any]:
    return {kind: columns(coefficients.test_vectors[kind]) or {} for kind in ("forward", "inverse")}


def _read(item: Any, h5py: Any) -> Any:
    if isinstance(item, h5py.Group):
        return {name: _read(inner, h5py) for name, inner in item.items()}
    if h5py.check_string_dtype(item.dtype):
        return item.asstr()[()]
    value = item[()]
    return np.zeros(0) if isinstance(value, h5py.Empty) else value


def _plain(value: Json) -> Any:
    """Return what reading gives of a written value."""
    if isinstance(value, dict):
        return {_name(key): _plain(inner) for key, inner in value.items()}
    if value is None:
        return np.zeros(0)
    return float(value) if type(value) is int else value


def _named(found: Mapping[str, Any]) -> dict[str, Any]:
    return {_name(key): _named(inner) if isinstance(inner, Mapping) else inner for key, inner in found.items()}


def _name(key: str) -> str:
    """Return a link name that HDF5 allows, another for every key."""
    escaped = key.replace("~", "~0").replace("/", "~1")
    if not escaped:
        return "~3"
    return "~2" * len(escaped) if not escaped.strip(".") else escaped


FORMAT = Format("hdf5", ".h5", to_hdf5, from_hdf5, needs=("h5py",))
