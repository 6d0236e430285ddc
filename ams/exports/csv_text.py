"""CSV: the whole document, one row a value, with a checksum line last.

Columns: ``path`` (where in the document: names after a slash, places in a list as [0]; in a name ~0 stands for ~,
~1 for / and ~2 for [), ``kind`` (number, text, true, false, null, empty list, empty table), ``value``, ``unit``.
Numbers are plain and exact. A text that a spreadsheet could take for a formula has an apostrophe before it, which
reading takes away again.
"""

import csv
import io
import json
import re
from collections.abc import Iterator
from itertools import groupby

from ams.errors import SetError
from ams.exports.checksum_line import INTACT, ChecksumLine
from ams.exports.format import Format
from ams.sets.canonical import Json
from ams.sets.coefficients import CoefficientSet, from_document
from ams.units import unit_of

HEADER = ("path", "kind", "value", "unit")
LINE_END = "\r\n"
CHECKSUM_LINE = ChecksumLine(
    kind="CSV",
    head=(",".join(HEADER) + LINE_END).encode(),
    before=b"sha256 of all bytes above this line,text,",
    after=("," + LINE_END).encode(),
)
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "\n", "'", "＝", "＋", "－", "＠")
DIMENSIONLESS = "1"
IN_STATED_UNIT = ("value", "standard_uncertainty", "tp_standard_uncertainty", "interval_95")


def to_csv(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a CSV file."""
    body = io.StringIO()
    writer = csv.writer(body, lineterminator=LINE_END)
    writer.writerow(HEADER)
    writer.writerows(rows_of(coefficients.document))
    return CHECKSUM_LINE.append_to(body.getvalue().encode("utf-8"))


def from_csv(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError where the file is not whole, was changed, or is no set.
    """
    body = CHECKSUM_LINE.checked_body(content, where)
    rows = csv.reader(io.StringIO(body.decode("utf-8"), newline=""))
    leaves = [_leaf(row, f"{where}: row {number}") for number, row in enumerate(rows, 1) if number > 1]
    return from_document(_tree(leaves, where) if leaves else {}, where)


def rows_of(value: Json, path: str = "", unit: str = "") -> Iterator[tuple[str, str, str, str]]:
    """Yield path, kind, value and unit of every leaf of the document."""
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            name = key.replace("~", "~0").replace("/", "~1").replace("[", "~2")
            yield from rows_of(inner, f"{path}/{name}", unit_below(value, key, unit))
    elif isinstance(value, list) and value:
        for index, inner in enumerate(value):
            yield from rows_of(inner, f"{path}/[{index}]", unit)
    else:
        kind, text = _cell(value)
        yield path, kind, text, unit if kind == "number" else ""


def unit_below(table: dict[str, Json], key: str, unit: str) -> str:
    """Return the unit of an entry: as its table states, else as its name ends, else that of the name above it."""
    stated = table.get("unit")
    if unit == DIMENSIONLESS or key == "effective_degrees_of_freedom":
        return DIMENSIONLESS
    if isinstance(stated, str):
        return stated if key in IN_STATED_UNIT else ""
    return unit_of(key) or unit


def _cell(value: Json) -> tuple[str, str]:
    if isinstance(value, str):
        return "text", "'" + value if value.startswith(FORMULA_STARTS) else value
    if value is None or isinstance(value, bool):
        return json.dumps(value), ""
    if isinstance(value, list):
        return "empty list", ""
    if isinstance(value, dict):
        return "empty table", ""
    return "number", json.dumps(value)


Leaf = tuple[tuple[str | int, ...], Json]


def _leaf(row: list[str], where: str) -> Leaf:
    if len(row) != len(HEADER):
        raise SetError(f"{where}: has {len(row)} cells, needed are {len(HEADER)}; {INTACT}")
    return _parts(row[0]), _value(row[1], row[2], f"{where}: {row[0]}")


def _value(kind: str, text: str, where: str) -> Json:
    if kind == "text":
        return text.removeprefix("'")
    if kind == "number":
        if not re.fullmatch(r"-?\d{1,400}(\.\d+)?(e[+-]\d{1,3})?", text):
            raise SetError(f"{where}: is no number: got {text[:40]!r}; {INTACT}")
        return float(text) if re.search(r"[.e]", text) else int(text)
    constants: dict[str, Json] = {"true": True, "false": False, "null": None, "empty list": [], "empty table": {}}
    if kind not in constants:
        raise SetError(f"{where}: kind: got {kind!r}, allowed are number, text, {', '.join(constants)}; {INTACT}")
    return constants[kind]


def _parts(path: str) -> tuple[str | int, ...]:
    return tuple(
        int(part[1:-1])
        if re.fullmatch(r"\[\d{1,9}\]", part)
        else part.replace("~2", "[").replace("~1", "/").replace("~0", "~")
        for part in path.split("/")[1:]
    )


def _tree(leaves: list[Leaf], where: str) -> Json:
    """Return the value whose leaves, in order, these are. Raises: SetError where they make no value."""
    if not leaves[0][0] and len(leaves) == 1:
        return leaves[0][1]
    branches = [
        (first, [(parts[1:], value) for parts, value in inside])
        for first, inside in groupby(leaves, key=lambda leaf: leaf[0][0] if leaf[0] else None)
    ]
    names = [first for first, _ in branches]
    if all(isinstance(name, str) for name in names) and len(set(names)) == len(names):
        return {str(name): _tree(inside, where) for name, inside in branches}
    if names == list(range(len(names))):
        return [_tree(inside, where) for _, inside in branches]
    raise SetError(f"{where}: rows contradict each other: one path stands twice or ends inside another; {INTACT}")


FORMAT = Format("csv", ".csv", to_csv, from_csv)
