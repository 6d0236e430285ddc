"""The verdict beside a journal, for screens that open no page: what ``calrig solve`` wrote of the run."""

import json
from collections.abc import Mapping
from pathlib import Path

from procedures.records.states import ACTIVE, State

VERDICT_FILE = "verdict.json"
"""The verdict and a row a sensor."""


def read_verdict(folder: Path, state: State | None) -> Mapping[str, object] | None:
    """Return what the report says in one sentence; None where there is none, or while the run goes on.

    A report beside a run that was resumed is of the stop before.
    """
    if state in ACTIVE:
        return None
    try:
        document = json.loads((folder / VERDICT_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return document if isinstance(document, dict) else None
