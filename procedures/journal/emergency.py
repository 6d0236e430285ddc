"""When the disk of a run fails: everything provable is copied to a second place, with the dwell that found no room."""

from contextlib import suppress
from pathlib import Path

import apsw

from ams.whole_file import FolderNotSynced, replace_file
from procedures.errors import ProcedureError
from procedures.journal.encoding import compact_json, encode_dwell
from procedures.journal.salvage import salvage
from procedures.journal.storage import JOURNAL_FILE
from procedures.records.dwells import DwellRecord

UNSAVED_FILE = "unsaved-dwell.json"


def emergency_copy(run_dir: Path, folder: Path, unsaved: DwellRecord | None) -> str:
    """Copy, and tell where in words that follow the disk's own sentence; never raises for a disk."""
    target = folder / run_dir.name
    try:
        number = 2
        while (target / "journal.sqlite").exists():
            target, number = folder / f"{run_dir.name}-{number}", number + 1
        found = salvage(run_dir, target) if (run_dir / JOURNAL_FILE).exists() else None
        if unsaved is not None:
            target.mkdir(parents=True, exist_ok=True)
            with suppress(FolderNotSynced):  # it is there
                # For a person: a dwell that was measured and not committed is no part of the run.
                text, _ = encode_dwell(unsaved)
                samples = {
                    name: [repr(float(value)) for value in reading.samples]
                    for name, reading in unsaved.readings.items()
                }
                replace_file(
                    target / UNSAVED_FILE, compact_json({"record": text, "samples_v": samples}).encode("utf-8")
                )
    except (ProcedureError, OSError, apsw.Error) as error:
        return f"; no copy could be made in {folder}: {error}"
    if found is None:  # the journal was moved away, and is whole where it is
        return "" if unsaved is None else f"; the dwell in progress is kept in {target}"
    return f"; copied to {target} ({found.dwells} dwells, {found.events} events)"
