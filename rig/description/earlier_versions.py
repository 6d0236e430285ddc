"""Rig descriptions that earlier versions stored in journals, as they are read now.

Keys that were dropped since are dropped from them, and what was believed without a key is written out.

Only what had no effect is ever dropped so; anything else is refused by the reader, with the version to use. A run keeps
the beliefs that it began with, so that it is solved to its own numbers.
"""

import json
from collections.abc import Iterator, Mapping, Sequence

DROPPED: tuple[tuple[str, ...], ...] = (
    ("readouts", "*", "settle_nplc"),
    ("streams", "*", "count", "unit_s"),
    ("standards", "*", "correction_file"),
)
"""Keys by their path, ``*`` for any name. ``settle_nplc`` was read and never used: the procedure's ``[dwell]`` says it.
A count has no seconds: ``unit_s`` belongs to ``time``. No version ever opened a ``correction_file``."""
BELIEVED: Mapping[tuple[str, ...], object] = {("axes", "*", "index_errors"): "independent"}
"""Keys by their path to what they stood for when they were not there yet."""


def as_stored_now(text: str) -> str:
    """Return the same description in the keys of this version; text that is no JSON object is left to its reader."""
    try:
        document = json.loads(text)
    except ValueError:
        return text
    for *tables, key in DROPPED:
        for table in _found(document, tables):
            table.pop(key, None)
    for (*tables, key), belief in BELIEVED.items():
        for table in _found(document, tables):
            table.setdefault(key, belief)
    return json.dumps(document)


def _found(document: object, path: Sequence[str]) -> Iterator[dict[str, object]]:
    """Yield the tables at a path, those that are there."""
    found = [document]
    for name in path:
        found = [inner for table in found if isinstance(table, dict) for inner in _below(table, name)]
    yield from (table for table in found if isinstance(table, dict))


def _below(table: Mapping[str, object], name: str) -> list[object]:
    return list(table.values()) if name == "*" else [table[name]] if name in table else []
