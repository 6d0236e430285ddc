"""What became of the messages that left when the journal was closed: kept beside it until a resume journals it."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from ams.errors import WriteFailed
from ams.whole_file import write_whole

EVENT = "alert"
FILE = "alerts-at-the-end.json"
FORMAT = "calrig alerts at the end 1"
Outcome = Mapping[str, object]
"""``what`` was told, and why it ``failed``; empty where it did not."""


def keep_outcomes(run_dir: Path, second_place: Path | None, outcomes: Sequence[Outcome]) -> None:
    """Add to what is kept where a disk takes it, the run's own first; standard error has told what no disk takes."""
    if not outcomes:
        return
    document = {"format": FORMAT, "outcomes": [*read_outcomes(run_dir, second_place), *outcomes]}
    for place in _places(run_dir, second_place):
        with suppress(WriteFailed, OSError):
            place.mkdir(parents=True, exist_ok=True)
            write_whole(place / FILE, json.dumps(document, ensure_ascii=False).encode("utf-8"))
            return


def read_outcomes(run_dir: Path, second_place: Path | None) -> tuple[Outcome, ...]:
    """Return what became of them since the run was last taken up, in the order in which it was known."""
    for place in _places(run_dir, second_place):
        with suppress(OSError, ValueError, KeyError, TypeError):
            document = json.loads((place / FILE).read_text(encoding="utf-8"))
            if document["format"] == FORMAT:
                return tuple({"what": str(one["what"]), "failed": str(one["failed"])} for one in document["outcomes"])
    return ()


def forget_outcomes(run_dir: Path, second_place: Path | None) -> None:
    """Remove them: they stand in the journal now."""
    for place in _places(run_dir, second_place):
        with suppress(OSError):
            (place / FILE).unlink()


def outcome_sentence(outcome: Outcome) -> str:
    """Return one as a sentence."""
    return f"{outcome['what']}: {f'not delivered: {failed}' if (failed := outcome['failed']) else 'delivered'}"


def _places(run_dir: Path, second_place: Path | None) -> list[Path]:
    return [run_dir] if second_place is None else [run_dir, second_place / run_dir.name]
