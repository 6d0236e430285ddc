"""What became of the messages that left when the journal was closed: kept beside it until a resume journals it."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from ams.whole_file import write_whole
from procedures.journal.sidecar.kept_beside import KeptBeside
from procedures.journal.sidecar.second_folder import second_folder

EVENT = "alert"
FILE = "alerts-at-the-end.json"
_KEPT = KeptBeside(FILE, "calrig alerts at the end 1")
KNOWN_FILE = "acknowledged.json"
"""Beside the last words of a run whose folder is not where it began: who rings for it finds no journal there."""
Outcome = Mapping[str, object]
"""``what`` was told, and why it ``failed``; empty where it did not."""


def keep_outcomes(run_dir: Path, second_folder: Path | None, outcomes: Sequence[Outcome]) -> None:
    """Add to what is kept where a disk takes it, the run's own first; standard error has told what no disk takes."""
    if outcomes:
        every = [*read_outcomes(run_dir, second_folder), *outcomes]
        _KEPT.keep(run_dir, second_folder, {"outcomes": every})


def read_outcomes(run_dir: Path, second_folder: Path | None) -> tuple[Outcome, ...]:
    """Return what became of them since the run was last taken up, in the order in which it was known."""
    return _KEPT.read(run_dir, second_folder, _outcomes) or ()


def forget_outcomes(run_dir: Path, second_folder: Path | None) -> None:
    """Remove them: they stand in the journal now."""
    _KEPT.forget(run_dir, second_folder)


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


def _outcomes(document: Mapping[str, Any]) -> tuple[Outcome, ...]:
    return tuple({"what": str(outcome["what"]), "failed": str(outcome["failed"])} for outcome in document["outcomes"])
