"""Rig descriptions that earlier versions stored in journals: keys that were dropped since are dropped from them.

Only what had no effect is ever dropped so; anything else is refused by the reader, with the version to use.
"""

import json
from collections.abc import Mapping

DROPPED: tuple[tuple[str, ...], ...] = (
    ("readouts", "*", "settle_nplc"),
    ("streams", "*", "count", "unit_s"),
)
"""Keys by their path, ``*`` for any name. ``settle_nplc`` was read and never used: the procedure's ``[dwell]`` says it.
A count has no seconds: ``unit_s`` belongs to ``time``."""


def as_stored_now(text: str) -> str:
    """Return the same description in the keys of this version; text that is no JSON object is left to its reader."""
    try:
        document = json.loads(text)
    except ValueError:
        return text
    for *tables, key in DROPPED:
        found = [document]
        for name in tables:
            found = [inner for table in found if isinstance(table, dict) for inner in _below(table, name)]
        for table in found:
            if isinstance(table, dict):
                table.pop(key, None)
    return json.dumps(document)


def _below(table: Mapping[str, object], name: str) -> list[object]:
    return list(table.values()) if name == "*" else [table[name]] if name in table else []
