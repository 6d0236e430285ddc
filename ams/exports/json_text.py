"""JSON: the set itself, and the only format that others are made from.

The file is exactly the rendered document: a file that differs in one byte is not the file that was written, also
where its values happen to read the same.
"""

import json
import math
from collections.abc import Iterator

from ams.errors import SetError
from ams.exports.format import Format
from ams.sets.canonical import Json, canonical_bytes
from ams.sets.coefficients import CoefficientSet, from_document

LINE_FEED = b"\n"
LONGEST_SHOWN = 40
"""Letters of a number that is refused."""
INTACT = "the set is not used; take an intact copy, or export the set again from the archive"


def to_json(coefficients: CoefficientSet) -> bytes:
    """Return a set as the bytes of a JSON file. Raises: SetError where its shape is none that the schema allows."""
    return coefficients.rendered


def from_json(content: bytes, where: str) -> CoefficientSet:
    """Return the set in the bytes of a file.

    Raises: SetError that tells truncated, not JSON, not a set, newer, changed and misshapen apart.
    """
    coefficients = from_document(parsed(content, where), where)
    written = coefficients.rendered
    if written != content:
        raise SetError(_difference(written, content, where))
    return coefficients


def parsed(content: bytes, where: str) -> Json:
    """Return the value in the bytes.

    Raises: SetError where it is empty, no text, truncated or not JSON, and naming the key of a number that no double
    holds.
    """
    if not content.strip():
        raise SetError(f"{where}: is empty: got {len(content)} bytes; {INTACT}")
    try:
        text = content.decode("utf-8")
        value: Json = json.loads(text, parse_constant=_NoDouble, parse_float=_number, parse_int=_whole_number)
        refused = next(_no_doubles(value, ()), None)
        if refused is None:
            canonical_bytes(value)
    except UnicodeDecodeError as error:
        raise SetError(
            f"{where}: is no text in UTF-8: byte {error.start} is 0x{content[error.start]:02x}; it is damaged or "
            f"no JSON file; {INTACT}"
        ) from error
    except (ValueError, RecursionError) as error:
        if content.lstrip().startswith(b"{") and not content.endswith(b"}\n"):
            raise SetError(f"{where}: is truncated: it breaks off after {len(content)} bytes; {INTACT}") from error
        raise SetError(f"{where}: is not JSON: {error}; it is damaged or another kind of file; {INTACT}") from error
    if refused is not None:
        raise SetError(
            f"{where}: {refused[0]}: got {refused[1]}, allowed is a number of at most ±1.797e308, or null where there "
            f"is none; changed, or written by another program than calrig; {INTACT}"
        )
    return value


def _difference(written: bytes, content: bytes, where: str) -> str:
    if written.startswith(content):
        return f"{where}: is truncated: it breaks off after {len(content)} of {len(written)} bytes; {INTACT}"
    position = next(
        (i for i, pair in enumerate(zip(written, content, strict=False)) if pair[0] != pair[1]), len(written)
    )
    return (
        f"{where}:{written[:position].count(LINE_FEED) + 1}: is not byte for byte what was written, though its values "
        f"read the same: reformatted, saved again by another program, or damaged; {INTACT}"
    )


class _NoDouble(str):
    """What stands where a number should: NaN, an infinity, or digits for more than the largest double."""

    __slots__ = ()


def _number(text: str) -> Json:
    number = float(text)
    return number if math.isfinite(number) else _NoDouble(text)


def _whole_number(text: str) -> Json:
    return int(text) if math.isfinite(float(text)) else _NoDouble(text)


def _no_doubles(value: Json, path: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield the key of each and what stands there."""
    if isinstance(value, _NoDouble):
        yield "/".join(path) or "document", value if len(value) <= LONGEST_SHOWN else f"{value[:LONGEST_SHOWN]}…"
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _no_doubles(inner, (*path, key))
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _no_doubles(inner, (*path, str(number)))


FORMAT = Format("json", ".json", to_json, from_json)
