"""When a run loses its disk or the files of its journal: everything provable is copied to a second place.

It is taken out of the files as the process has them open, with the dwell that found no room beside it.
"""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import apsw

from ams.whole_file import FolderNotSynced, replace_file
from procedures.errors import ProcedureError
from procedures.journal.encoding import compact_json, encode_dwell
from procedures.journal.journal import Journal
from procedures.journal.salvage import Salvaged
from procedures.journal.sidecar.last_words import MOVED, STORAGE
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.dwells import DwellRecord
from rig.clock import Clock

UNSAVED_FILE = "unsaved-dwell.json"


@dataclass(frozen=True, slots=True)
class EmergencyCopy:
    """What became of it."""

    words: str = ""
    """That follow the sentence of what happened."""
    folder: Path | None = None
    """Which holds the journal now; None where that of the run does, or nothing was copied."""


def emergency_copy(
    journal: Journal, second_folder: Path, cause: str, unsaved: DwellRecord | None, clock: Clock
) -> EmergencyCopy:
    """Copy, and tell where; never raises for a disk. A journal that was moved away is whole where it is.

    Files that end with this process are copied beside the run where the second folder takes nothing.
    """
    ends_with_process = cause != STORAGE and journal.is_lost_with_process()
    is_elsewhere = cause == MOVED and not ends_with_process
    refusals = []
    for folder in (second_folder, *([journal.path.parent.parent] if ends_with_process else [])):
        target = _free_folder(folder, journal.path.parent.name)
        try:
            found = None if is_elsewhere else journal.salvage_into(target, clock)
            is_kept = unsaved is not None and not journal.has_dwell(unsaved) and _keep_unsaved(unsaved, target)
        except (ProcedureError, OSError, apsw.Error) as error:
            refusals.append(f"; no copy could be made in {folder}: {error}")
            continue
        if found is None:
            return EmergencyCopy(f"; the dwell in progress is kept in {target}" if is_kept else "")
        return EmergencyCopy(f"; copied to {target} ({_counts(found)})", None if cause == STORAGE else target)
    return EmergencyCopy("".join(refusals))


def _free_folder(folder: Path, run_name: str) -> Path:
    """Return one in which no file of a journal stands: SQLite would take a log that is left for that of the copy."""
    target, number = folder / run_name, 2
    while any(target.glob(f"{JOURNAL_FILE}*")):
        target, number = folder / f"{run_name}-{number}", number + 1
    return target


def _keep_unsaved(dwell: DwellRecord, target: Path) -> bool:
    """Write it for a person: a dwell that was measured and not committed is no part of the run. Raises: OSError."""
    target.mkdir(parents=True, exist_ok=True)
    with suppress(FolderNotSynced):  # it is there
        text, _ = encode_dwell(dwell)
        samples = {name: [repr(float(value)) for value in reading.samples] for name, reading in dwell.readings.items()}
        replace_file(target / UNSAVED_FILE, compact_json({"record": text, "samples_v": samples}).encode("utf-8"))
    return True


def _counts(found: Salvaged) -> str:
    lost = f", {len(found.quarantined)} dwells lost" if found.quarantined else ""
    return f"{found.dwells} dwells, {found.events} events{lost}"
