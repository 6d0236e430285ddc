"""What a run left, moved aside where it must not be used any more: ``superseded-1``, ``superseded-2`` … in its folder.

Nothing is deleted and no sealed byte changes. A file beside the sets says by whom, when and why
(:mod:`ams.exports.withdrawn_folder`), and a page that says it stands in the place of the report.
"""

import json
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

from ams.exports import json_text
from ams.exports.formats import FORMATS
from ams.exports.withdrawn_folder import mark_withdrawn
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_verdict import Withdrawal
from ams.whole_file import read_whole
from procedures.journal.audit.taken_back import TakenBack, taken_back_since
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.unwritten import SETS_FOLDER
from procedures.journal.sidecar.verdict_file import VERDICT_FILE
from procedures.report.plain_page import PlainPage, write_plain
from procedures.report.write import DOCUMENTS_FOLDER, FIGURES_FOLDER, PAPER_FILE, REPORT_FILE

EXPORTS_FOLDER = "exports"
_OF_SETS = (SETS_FOLDER, EXPORTS_FOLDER)
_REPORTS = (DOCUMENTS_FOLDER, FIGURES_FOLDER, PAPER_FILE, REPORT_FILE, VERDICT_FILE)


def set_results_aside(run: Path) -> str:
    """Move sets, exports and report of a run aside that was taken back after they were made; return a sentence.

    Empty where the run has none. The dwells are in the journal, and stay there. Raises: WriteFailed, OSError,
    JournalError.
    """
    found = [name for name in (*_OF_SETS, *_REPORTS) if (run / name).exists()]
    taken_back = list(taken_back_since(run).values())
    if not taken_back or not {*_OF_SETS, PAPER_FILE}.intersection(found):
        return ""
    word = taken_back[-1]
    aside = _new_folder(run)
    for name in found:
        if name in _OF_SETS:
            mark_withdrawn(run / name, Withdrawal(word.by, word.utc, word.because))
        (run / name).rename(aside / name)
    _write_page(run, word, aside)
    return f"{aside}: holds the sets, exports and report of before, which must not be used any more"


def set_old_aside(run: Path, sets: Mapping[str, CoefficientSet], sensors: Iterable[str]) -> None:
    """Move aside what stands in the folder of a run that is solved again and is not written again.

    That is all of it where dwells were taken back since, else the files of sensors that have no set to use any more.
    ``sets``: those that were made now, withdrawn ones among them. Raises: WriteFailed, OSError, JournalError.
    """
    if not any((run / folder).is_dir() for folder in _OF_SETS):
        return
    if _rests_on_taken_back(run):
        set_results_aside(run)
    _set_sensors_aside(run, sets, sensors)


def _rests_on_taken_back(run: Path) -> bool:
    """Return whether any set of the folder was made of dwells that were taken back since."""
    gone = taken_back_since(run)
    return bool(gone) and any(
        _journal_of(path) in gone for path in (run / SETS_FOLDER).glob(f"*{json_text.FORMAT.ending}")
    )


def _journal_of(path: Path) -> str:
    """Return the content of the journal that a set names; empty where the file tells none."""
    try:
        return str(json.loads(read_whole(path))["provenance"]["journal_sha256"])
    except (ValueError, TypeError, KeyError):
        return ""


def _set_sensors_aside(run: Path, sets: Mapping[str, CoefficientSet], sensors: Iterable[str]) -> None:
    gone = {name: sets.get(name) for name in sensors if name not in sets or sets[name].withdrawal is not None}
    files = [
        (path, made)
        for name, made in gone.items()
        for folder in _OF_SETS
        for form in FORMATS.values()
        if (path := run / folder / form.file_name(name)).is_file()
    ]
    if not files:
        return
    aside = _new_folder(run)
    for path, made in files:
        target = aside / path.parent.name
        target.mkdir(exist_ok=True)
        if made is not None and made.withdrawal is not None:
            mark_withdrawn(target, made.withdrawal)
        path.rename(target / path.name)


def _new_folder(run: Path) -> Path:
    number = 1
    while (folder := run / f"superseded-{number}").exists():
        number += 1
    folder.mkdir()
    return folder


def _write_page(run: Path, word: TakenBack, aside: Path) -> None:
    with JournalReader.open(run) as reader:
        header, state = reader.header, str(reader.state())
    name = shlex.quote(str(run))
    why = (
        f"{word}. What was made of the run before lies in {aside.name} and must not be used any more. calrig resume "
        f"{name} measures again; calrig solve {name} makes a page of what is left"
    )
    page = PlainPage(header.title, header.run_id, state, why, header.is_simulated)
    write_plain(run, page, tuple(header.plan.sensors))
