"""A set's document as bytes: one canonical form for the checksum, one readable form for the file.

Canonical: JSON with sorted keys, no spaces, UTF-8, numbers as their shortest text that reads back to the same double.
The checksum is the SHA-256 of that form of everything but the checksum itself. Both forms are pure functions of the
document, so the same set is the same bytes everywhere.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from datetime import date, datetime
from typing import TypeAlias

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SetError

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"
Document: TypeAlias = dict[str, Json]

CHECKSUM_ALGORITHM = "SHA-256 of the document without this entry, as JSON with sorted keys, no spaces, UTF-8"
LINE_LENGTH = 150
LONGEST_TEXT = 100_000


def plain(value: object, where: str) -> Json:
    """Return the value as JSON knows it: arrays as lists, dates as ISO 8601, a number that is not finite as null.

    Raises: SetError for a value that JSON has no form for.
    """
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return plain_text(value, where)
    if isinstance(value, Mapping):
        return {str(key): plain(inner, f"{where}.{key}") for key, inner in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(inner, where) for inner in value]
    if isinstance(value, datetime | date):
        return value.isoformat()
    if is_dataclass(value) and not isinstance(value, type):
        return plain({part.name: getattr(value, part.name) for part in fields(value)}, where)
    return plain_number(value, where)


def plain_text(value: str, where: str) -> str:
    """Return text of a bearable length that has a UTF-8 form and no NUL. Raises: SetError for any other."""
    if len(value) > LONGEST_TEXT:
        raise SetError(
            f"{where}: cannot be written into a coefficient set: got a text of {len(value)} characters, "
            f"allowed are {LONGEST_TEXT}; nothing was written"
        )
    if "\0" in value or any("\ud800" <= letter <= "\udfff" for letter in value):
        raise SetError(
            f"{where}: cannot be written into a coefficient set: got text with a NUL or no characters, {value!r}, "
            "allowed is Unicode text; nothing was written"
        )
    return value


def plain_number(value: object, where: str) -> Json:
    """Return a number as int, float or, where it is not finite, null. Raises: SetError for anything else."""
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    raise SetError(
        f"{where}: cannot be written into a coefficient set: got a {type(value).__name__}, allowed are "
        "numbers, text, dates, true, false, null and lists or tables of these; nothing was written"
    )


def table(value: Json) -> Document:
    """Return the value, known by the schema to be a table."""
    assert isinstance(value, dict), "the schema was checked"
    return value


def listed(value: Json) -> list[Json]:
    """Return the value, known by the schema to be a list or null; null is empty."""
    assert value is None or isinstance(value, list), "the schema was checked"
    return value or []


def number(value: Json) -> float:
    """Return the value, known by the schema to be a number."""
    assert isinstance(value, int | float), "the schema was checked"
    return float(value)


def matrix(value: Json) -> FloatArray:
    """Return rows of numbers as an array; what the set leaves out as null is 0."""
    return np.array([[0.0 if cell is None else number(cell) for cell in listed(row)] for row in listed(value)])


def canonical_bytes(value: Json) -> bytes:
    """Return the one form that checksums are taken of."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.encode("utf-8")


def checksum(document: Mapping[str, Json]) -> str:
    """Return the SHA-256 (hex) over everything in the document but its checksum."""
    return hashlib.sha256(canonical_bytes({k: v for k, v in document.items() if k != "checksum"})).hexdigest()


def with_checksum(document: Mapping[str, Json]) -> Document:
    """Return the document with its checksum as the last entry."""
    content: Document = {key: value for key, value in document.items() if key != "checksum"}
    content["checksum"] = {"algorithm": CHECKSUM_ALGORITHM, "sha256": checksum(content)}
    return content


def render(document: Mapping[str, Json]) -> bytes:
    """Return the document as the bytes of its file.

    Indented by two, whatever fits one line on one line, one newline last.
    """
    return (_rendered(dict(document), 0, 0) + "\n").encode("utf-8")


_ON_ONE_LINE = json.JSONEncoder(ensure_ascii=False, allow_nan=False)
"""Made once: a set has some thousand values, and making an encoder takes longer than writing a number."""


def _rendered(value: Json, indent: int, used: int) -> str:
    if indent > 0 or not isinstance(value, dict | list):
        flat = _ON_ONE_LINE.encode(value)
        if not isinstance(value, dict | list) or indent + used + len(flat) <= LINE_LENGTH:
            return flat
    if isinstance(value, dict):
        names = [_ON_ONE_LINE.encode(key) + ": " for key in value]
        lines = [
            name + _rendered(inner, indent + 2, len(name)) for name, inner in zip(names, value.values(), strict=True)
        ]
        opening, closing = "{", "}"
    else:
        lines = [_rendered(inner, indent + 2, 0) for inner in value]
        opening, closing = "[", "]"
    pad = "\n" + " " * (indent + 2)
    return opening + pad + ("," + pad).join(lines) + "\n" + " " * indent + closing
