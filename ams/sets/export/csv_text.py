"""CSV: the whole document, one row a value, with a checksum line last.

Columns: ``path`` (where in the document: names after a slash, places in a list as [0]; in a name ~0 stands for ~,
~1 for / and ~2 for [), ``kind`` (number, text, true, false, null, empty list, empty table), ``value``, ``unit``.
Numbers are plain and exact. A text that a spreadsheet could take for a formula has an apostrophe before it, which
reading takes away again.
"""

import csv
import hashlib
import io
import json
import re
from collections.abc import Iterator
from itertools import groupby

from ams.errors import SetError
from ams.sets.canonical import Json
from ams.sets.coefficients import CoefficientSet, from_document
from ams.sets.units import unit_of

HEADER = ("path", "kind", "value", "unit")
LINE_END = "\r\n"
CHECKSUM_PATH = "sha256 of all bytes above this line"
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "\n", "'", "＝", "＋", "－", "＠")
DIMENSIONLESS = "1"
IN_STATED_UNIT = ("value", "standard_uncertainty", "tp_standard_uncertainty", "interval_95")
INTACT = "the set is not used; take an intact copy, or export the set again"


def to_csv(coefficients: CoefficientSet) -> bytes:
    """The bytes of the file."""
    body = io.StringIO()
    writer = csv.writer(body, lineterminator=LINE_END)
    writer.writerow(HEADER)
    writer.writerows(_rows(coefficients.document))
    content = body.getvalue().encode("utf-8")
    return content + _checksum_line(content)


def from_csv(content: bytes, where: str) -> CoefficientSet:
    """The set in the bytes of a file. Raises: SetError where the file is not whole, was changed, or is no set."""
    body = _checked_body(content, where)
    rows = list(csv.reader(io.StringIO(body.decode("utf-8"), newline="")))[1:]
    leaves = [(_parts(path), _value(kind, text, f"{where}: {path}")) for path, kind, text, _ in rows]
    return from_document(_tree(leaves), where)


def _checksum_line(content: bytes) -> bytes:
    return f"{CHECKSUM_PATH},text,{hashlib.sha256(content).hexdigest()},{LINE_END}".encode()


def _checked_body(content: bytes, where: str) -> bytes:
    first_line = content.split(b"\n")[0][:60]
    head = ",".join(HEADER).encode() + LINE_END.encode()
    if not content:
        raise SetError(f"{where}: is empty: got 0 bytes; {INTACT}")
    if not content.startswith(head):
        raise SetError(
            f"{where}: is not a coefficient set as CSV: its first line is {first_line!r}, "
            f"needed is {','.join(HEADER)}; another kind of file, saved again by a spreadsheet, or damaged; {INTACT}"
        )
    found = re.search(rb"(?:^|\n)(" + CHECKSUM_PATH.encode() + rb",text,[^\n]*\n)\Z", content)
    if found is None:
        raise SetError(
            f"{where}: is truncated or was saved again by another program: the checksum line is missing "
            f"at the end of its {len(content)} bytes; {INTACT}"
        )
    body = content[: found.start(1)]
    if _checksum_line(body) != found.group(1):
        raise SetError(
            f"{where}: checksum: does not fit the content: changed or damaged after it was written; {INTACT}"
        )
    return body


def _rows(value: Json, path: str = "", unit: str = "") -> Iterator[tuple[str, str, str, str]]:
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            name = key.replace("~", "~0").replace("/", "~1").replace("[", "~2")
            yield from _rows(inner, f"{path}/{name}", _unit_below(value, key, unit))
    elif isinstance(value, list) and value:
        for index, inner in enumerate(value):
            yield from _rows(inner, f"{path}/[{index}]", unit)
    else:
        kind, text = _cell(value)
        yield path, kind, text, unit if kind == "number" else ""


def _unit_below(table: dict[str, Json], key: str, unit: str) -> str:
    """The unit of an entry: as its table states, else as its name ends, else that of the name it stands under."""
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


def _value(kind: str, text: str, where: str) -> Json:
    if kind == "text":
        return text.removeprefix("'")
    constants: dict[str, Json] = {"true": True, "false": False, "null": None, "empty list": [], "empty table": {}}
    if kind == "number":
        number: Json = json.loads(text)
        return number
    if kind not in constants:
        raise SetError(f"{where}: kind: got {kind!r}, allowed are number, text, {', '.join(constants)}; {INTACT}")
    return constants[kind]


Leaf = tuple[tuple[str | int, ...], Json]


def _parts(path: str) -> tuple[str | int, ...]:
    return tuple(
        int(part[1:-1]) if part.startswith("[") else part.replace("~2", "[").replace("~1", "/").replace("~0", "~")
        for part in path.split("/")[1:]
    )


def _tree(leaves: list[Leaf]) -> Json:
    """The value whose leaves, in order, these are."""
    if not leaves or not leaves[0][0]:
        return leaves[0][1] if leaves else {}
    branches: list[tuple[str | int, Json]] = [
        (first, _tree([(parts[1:], value) for parts, value in inside]))
        for first, inside in groupby(leaves, key=lambda leaf: leaf[0][0])
    ]
    if isinstance(branches[0][0], int):
        return [value for _, value in branches]
    return {str(first): value for first, value in branches}
