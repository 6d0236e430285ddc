"""What became of the messages that left when the journal was closed: kept beside it until a resume journals it."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from ams.errors import WriteFailed
from ams.whole_file import write_whole
from procedures.journal.second_folder import make_beside, second_folder

EVENT = "alert"
FILE = "alerts-at-the-end.json"
FORMAT = "calrig alerts at the end 1"
KNOWN_FILE = "acknowledged.json"
"""Beside the last words of a run whose folder is not where it began: who rings for it finds no journal there."""
Outcome = Mapping[str, object]
"""``what`` was told, and why it ``failed``; empty where it did not."""


def keep_outcomes(run_dir: Path, second_folder: Path | None, outcomes: Sequence[Outcome]) -> None:
    """Add to what is kept where a disk takes it, the run's own first; standard error has told what no disk takes."""
    if not outcomes:
        return
    document = {"format": FORMAT, "outcomes": [*read_outcomes(run_dir, second_folder), *outcomes]}
    for folder in _folders(run_dir, second_folder):
        with suppress(WriteFailed, OSError):
            make_beside(folder, run_dir)
            write_whole(folder / FILE, json.dumps(document, ensure_ascii=False).encode("utf-8"))
            return


def read_outcomes(run_dir: Path, second_folder: Path | None) -> tuple[Outcome, ...]:
    """Return what became of them since the run was last taken up, in the order in which it was known."""
    for folder in _folders(run_dir, second_folder):
        with suppress(OSError, ValueError, KeyError, TypeError):
            document = json.loads((folder / FILE).read_text(encoding="utf-8"))
            if document["format"] == FORMAT:
                return tuple(
                    {"what": str(outcome["what"]), "failed": str(outcome["failed"])} for outcome in document["outcomes"]
                )
    return ()


def forget_outcomes(run_dir: Path, second_folder: Path | None) -> None:
    """Remove them: they stand in the journal now."""
    for folder in _folders(run_dir, second_folder):
        with suppress(OSError):
            (folder / FILE).unlink()


def is_known_elsewhere(run_name: str) -> bool:
    """Return whether something is told of a run in the second folder."""
    return (second_folder() / run_name).is_dir()


def keep_acknowledgement(run_name: str, by: str, text: str, at_utc: datetime) -> None:
    """Leave word for who rings for a run of which something is told in the second folder. Raises: WriteFailed."""
    if is_known_elsewhere(run_name):
        document = {"by": by, "text": text, "at_utc": at_utc.isoformat()}
        write_whole(second_folder() / run_name / KNOWN_FILE, json.dumps(document, ensure_ascii=False).encode("utf-8"))


def is_acknowledged_elsewhere(run_name: str) -> bool:
    """Return whether somebody left word since the run was last taken up."""
    return (second_folder() / run_name / KNOWN_FILE).is_file()


def forget_acknowledgement(run_name: str) -> None:
    """Remove it: what is told from now on is another alarm."""
    with suppress(OSError):
        (second_folder() / run_name / KNOWN_FILE).unlink()


def outcome_sentence(outcome: Outcome) -> str:
    """Return one as a sentence."""
    return f"{outcome['what']}: {f'not delivered: {failed}' if (failed := outcome['failed']) else 'delivered'}"


def _folders(run_dir: Path, second_folder: Path | None) -> list[Path]:
    return [run_dir] if second_folder is None else [run_dir, second_folder / run_dir.name]
