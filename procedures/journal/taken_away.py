"""What became of a journal that was taken away under its run: kept where the run was, for whoever looks there."""

import json
import shlex
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ams.errors import WriteFailed
from ams.whole_file import write_whole
from procedures.errors import JournalTakenAway
from procedures.journal.sidecar.second_folder import make_beside, second_folder
from procedures.journal.storage import JOURNAL_FILE
from rig.local_time import at_both

FILE = "taken-away.json"
_FORM = "calrig taken away 1"


@dataclass(frozen=True, slots=True)
class TakenAway:
    """Why what stands in the folder of a run, if anything, is not its journal, and where what was saved of it is."""

    reason: str
    stopped_utc: datetime
    copy: Path | None
    """The folder that holds what was saved; None where nothing was, or the journal is whole where somebody moved it."""
    page: Path | None
    """The page that tells of it; None where no disk took it."""


def keep_taken_away(run_dir: Path, second_folder: Path | None, found: TakenAway) -> None:
    """Leave word in the folder of the run, in the second one where that is gone; the page and the alert tell it too."""
    document = {
        "format": _FORM,
        "run": str(run_dir.absolute()),
        "reason": found.reason,
        "stopped_utc": found.stopped_utc.isoformat(),
        "copy": None if found.copy is None else str(found.copy.absolute()),
        "page": None if found.page is None else str(found.page.absolute()),
    }
    for path in (run_dir / FILE, *([] if second_folder is None else [_elsewhere(second_folder, run_dir)])):
        with suppress(WriteFailed, OSError):
            make_beside(path.parent, run_dir)
            write_whole(path, json.dumps(document, ensure_ascii=False).encode("utf-8"))
            return


def is_taken_away(run_dir: Path) -> bool:
    """Return whether something is told of the folder of a run, there or not, that lost its journal."""
    return _found(run_dir) is not None


def require_not_taken_away(run_dir: Path) -> None:
    """Refuse to take what stands in the folder of a run for its journal. Raises: JournalTakenAway."""
    if (found := _found(run_dir)) is None:
        return
    file, taken = found
    when = at_both(taken.stopped_utc)
    page = "no page could be written" if taken.page is None else f"the page that tells of it is {taken.page}"
    raise JournalTakenAway(
        f"{run_dir}: its journal was taken away under the run, which ended by that {when}; {taken.reason}; {page}; "
        f"{_way_out(run_dir, taken)}; to have what stands here read all the same, remove {file}",
        taken.stopped_utc,
    )


def _found(run_dir: Path) -> tuple[Path, TakenAway] | None:
    here = run_dir / FILE
    if (taken := _read(here, run_dir)) is not None:
        return here, taken
    elsewhere = _elsewhere(second_folder(), run_dir)
    taken = _read(elsewhere, run_dir, is_bound_to_path=True)
    # A folder that was moved and is put back has its journal.
    is_back = taken is not None and taken.copy is None and (run_dir / JOURNAL_FILE).exists()
    return None if taken is None or is_back else (elsewhere, taken)


def _read(file: Path, run_dir: Path, *, is_bound_to_path: bool = False) -> TakenAway | None:
    """``is_bound_to_path``: of several runs of one name, only that of this path is meant."""
    with suppress(OSError, ValueError, KeyError, TypeError):
        document = json.loads(file.read_text(encoding="utf-8"))
        if document["format"] != _FORM or (is_bound_to_path and document["run"] != str(run_dir.absolute())):
            return None
        copy, page = (None if (given := document[key]) is None else Path(given) for key in ("copy", "page"))
        return TakenAway(str(document["reason"]), datetime.fromisoformat(document["stopped_utc"]), copy, page)
    return None


def _way_out(run_dir: Path, taken: TakenAway) -> str:
    if taken.copy is None:
        return f"where the run is whole elsewhere, name that folder (calrig resume FOLDER), not {run_dir}"
    if (taken.copy / JOURNAL_FILE).exists():
        return f"name the copy: calrig resume {shlex.quote(str(taken.copy))}"
    return f"no journal is in {taken.copy} any more: name the folder that it was moved to"


def _elsewhere(second_folder: Path, run_dir: Path) -> Path:
    """Return the file beside the folder of the run's name there, which may hold the copy itself."""
    return second_folder / f"{run_dir.name}.{FILE}"
