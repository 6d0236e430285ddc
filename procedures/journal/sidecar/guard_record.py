"""What the stop guard of a run did when the engine could not: read by status, journalled by the next resume."""

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from rig.guard.ask import FORMAT
from rig.guard.outcomes import STOOD, STOP_SENT
from rig.guard.stop_guard import RECORD
from rig.local_time import text_at_both

EVENT = "stop_guard"
AIMED = f"{STOP_SENT} at "


def read_guard_record(run_dir: Path) -> Mapping[str, Any] | None:
    """Return what it wrote since the run was last taken up, or None."""
    try:
        document = json.loads((run_dir / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return document if isinstance(document, dict) and document.get("format") == FORMAT else None


def forget_guard_record(run_dir: Path) -> None:
    """Remove the record: it stands in the journal now."""
    with suppress(OSError):
        (run_dir / RECORD).unlink()


def guard_sentence(document: Mapping[str, Any]) -> str:
    """Return it as a sentence."""
    axes: Mapping[str, str] = document.get("axes", {})
    missed = [f"{name}: {outcome}" for name, outcome in sorted(axes.items()) if outcome.startswith("NOT")]
    moving = f"{' and '.join(document['moving'])} could move" if document["moving"] else "every axis stood"
    text = f"stop guard, {text_at_both(str(document.get('stopped_utc')))}: {document.get('why')} while {moving}"
    which = "every axis that could move" if STOOD in axes.values() else "every axis"
    text += f"; {which} was told to stop"
    if aimed := [f"{name}: {outcome}" for name, outcome in sorted(axes.items()) if outcome.startswith(AIMED)]:
        text += f" ({'; '.join(aimed)})"
    return f"{text}, but {'; '.join(missed)}; use the stop button at the machine" if missed else text
