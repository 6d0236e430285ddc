"""Why a run stopped, where its journal does not say it: kept beside it or elsewhere until a resume journals it.

Either the disk refused the engine's last line, or the process died and its stop guard had people told.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from procedures.errors import JournalReplaced
from procedures.journal.sidecar.kept_beside import KeptBeside
from rig.local_time import at_both

_KEPT = KeptBeside("last-words.json", "calrig last words 1")
STORAGE = "storage"
"""The cause of an ending that the disk forced."""
MOVED = "moved"
"""The cause where the disk is well, and somebody took the folder of the run away."""
REPLACED = "replaced"
"""The cause where somebody removed, replaced or changed a file of the journal under the run."""
TAKES_NOTHING = (STORAGE, MOVED, REPLACED)
"""Causes of an ending of which the journal may know nothing."""


@dataclass(frozen=True, slots=True)
class LastWords:
    """What was said last, and people were told."""

    reason: str
    stopped_utc: datetime
    cause: str = STORAGE

    def __str__(self) -> str:
        if self.cause != STORAGE:
            return self.reason
        return (
            f"{self.reason}; at {at_both(self.stopped_utc, to_the_second=True)}, and the journal did not take it then"
        )


def refusal(run_dir: Path, error: Exception) -> tuple[str, str]:
    """Return what is to be said where a run could not be written to, and the cause: it may be no disk at all."""
    if run_dir.is_dir():
        return str(error), REPLACED if isinstance(error, JournalReplaced) else STORAGE
    return (
        f"{run_dir}: the folder of the run is not there any more: it was moved, renamed or removed while the run went "
        "on; where it was moved, all that was committed is in its journal: put the folder back, or take the run up "
        "where it is now (calrig resume)",
        MOVED,
    )


def keep_last_words(run_dir: Path, second_folder: Path | None, words: LastWords) -> bool:
    """Write them where a disk takes them, the run's own first; False where none does: the alert has told them."""
    moment = words.stopped_utc.isoformat()
    return _KEPT.keep(run_dir, second_folder, {"reason": words.reason, "stopped_utc": moment, "cause": words.cause})


def read_last_words(run_dir: Path, second_folder: Path | None) -> LastWords | None:
    """Return what was said since the run was last taken up; None where nothing was."""
    return _KEPT.read(run_dir, second_folder, _words)


def forget_last_words(run_dir: Path, second_folder: Path | None) -> None:
    """Remove them: they stand in the journal now."""
    _KEPT.forget(run_dir, second_folder)


def _words(document: Mapping[str, object]) -> LastWords:
    moment = datetime.fromisoformat(str(document["stopped_utc"]))
    return LastWords(str(document["reason"]), moment, str(document.get("cause", STORAGE)))
