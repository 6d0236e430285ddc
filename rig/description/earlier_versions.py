"""Rig descriptions that earlier versions stored in journals, as they are read now.

Keys that were dropped since are dropped from them, and what was believed without a key is written out.

Only what had no effect is ever dropped so; anything else is refused by the reader, with the version to use. A run keeps
the beliefs that it began with, so that it is solved to its own numbers.
"""

import json
from collections.abc import Mapping

DROPPED: Mapping[str, tuple[str, ...]] = {"readouts": ("settle_nplc",)}
"""Table of tables to keys. ``settle_nplc`` was read and never used: the procedure's ``[dwell]`` says it."""
BELIEVED: Mapping[str, Mapping[str, object]] = {"axes": {"index_errors": "independent"}}
"""Table of tables to what a missing key stood for when it was not there yet."""


def as_stored_now(text: str) -> str:
    """Return the same description in the keys of this version; text that is no JSON object is left to its reader."""
    try:
        document = json.loads(text)
    except ValueError:
        return text
    for table, keys in DROPPED.items():
        for settings in _tables(document, table):
            for key in keys:
                settings.pop(key, None)
    for table, beliefs in BELIEVED.items():
        for settings in _tables(document, table):
            settings.update({key: value for key, value in beliefs.items() if key not in settings})
    return json.dumps(document)


def _tables(document: object, name: str) -> list[dict[str, object]]:
    tables = document.get(name) if isinstance(document, dict) else None
    return [table for table in tables.values() if isinstance(table, dict)] if isinstance(tables, dict) else []
