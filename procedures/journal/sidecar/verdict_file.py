"""The verdict beside a journal, for screens that open no page: what ``calrig solve`` wrote of the run.

It has a checksum as a coefficient set has. Where that does not hold, what the file says now is told nowhere.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ams.sets.canonical import checksum, plain, with_checksum
from ams.whole_file import write_whole
from procedures.records.states import ACTIVE, State
from rig.plain_text import one_line

VERDICT_FILE = "verdict.json"
"""The verdict and a row a sensor."""
CHANGED: Mapping[str, object] = {
    "trust": "",
    "sentence": f"{VERDICT_FILE} is not as calrig wrote it: nothing of it is told; calrig solve writes it anew",
}
"""In place of a document that somebody changed."""


def write_verdict_file(folder: Path, document: Mapping[str, object]) -> None:
    """Write it with its checksum. Raises: WriteFailed."""
    content = {key: plain(value, f"{VERDICT_FILE}: {key}") for key, value in document.items()}
    text = json.dumps(with_checksum(content), ensure_ascii=False, indent=1)
    write_whole(folder / VERDICT_FILE, f"{text}\n".encode())


def read_verdict(folder: Path, state: State | None) -> Mapping[str, object] | None:
    """Return what the report says in one sentence; None where there is none, or while the run goes on.

    A report beside a run that was resumed is of the stop before, until the run has been solved again.
    """
    document = None if state in ACTIVE else _document(folder)
    return None if document is None or _is_of_a_stop_before(document, state) else document


def set_verdict_aside(folder: Path) -> None:
    """Write beside the verdict that the run goes on: it is of the stop before. Raises: WriteFailed."""
    document = _document(folder)
    if document is not None:
        write_verdict_file(folder, {**document, "state": "resumed"})


def has_earlier_verdict(folder: Path, state: State | None) -> bool:
    """Return whether what was judged last, and the report with it, is of a stop before the end."""
    document = _document(folder)
    return document is not None and _is_of_a_stop_before(document, state)


def _document(folder: Path) -> Mapping[str, object] | None:
    try:
        document = json.loads((folder / VERDICT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(document, dict):
        return None
    return document if _is_as_written(document) else CHANGED


def _is_as_written(document: Mapping[str, Any]) -> bool:
    """Return whether the checksum holds; earlier versions wrote none."""
    try:
        return "checksum" not in document or bool(document["checksum"]["sha256"] == checksum(document))
    except (KeyError, TypeError, ValueError):
        return False


def _is_of_a_stop_before(document: Mapping[str, object], state: State | None) -> bool:
    """Return whether a run that is finished was judged while it stood still; earlier versions did not write when."""
    return state is State.FINISHED and document.get("state", state) != state


def rows_in(verdict: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Return the rows of the sensors."""
    rows = verdict.get("sensors")
    return [row for row in rows if isinstance(row, Mapping)] if isinstance(rows, list) else []


def grounds_in(verdict: Mapping[str, object]) -> list[str]:
    """Return what stands behind the verdict, each with what can be done about it."""
    grounds = verdict.get("grounds")
    return [str(ground) for ground in grounds] if isinstance(grounds, list) else []


def hindered_in(verdict: Mapping[str, object]) -> str:
    """Say what of a run could not be solved or made and what to do: solving again as it was ends as it did."""
    about: dict[str, list[str]] = {}
    for row in rows_in(verdict):
        if row.get("failure"):
            about.setdefault(str(row["failure"]), []).append(str(row.get("sensor")))
    not_made = verdict.get("not_made")
    parts = not_made.items() if isinstance(not_made, Mapping) else ()
    said = [f"no result to use of {', '.join(names)}: {failure}" for failure, names in about.items()]
    return one_line("; ".join([*said, *(f"{part} could not be made: {sentence}" for part, sentence in parts)]))
