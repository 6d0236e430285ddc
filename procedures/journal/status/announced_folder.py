"""The run that a started command told of: the first line of its words that is a run's folder."""

from pathlib import Path

from procedures.journal.storage import JOURNAL_FILE


def announced_folder(log: Path) -> Path | None:
    """Return the first whole line that is the folder of a run; None where there is none yet."""
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
    except FileNotFoundError:
        return None
    folders = (Path(line.rstrip("\n")) for line in lines if line.endswith("\n"))
    return next((folder for folder in folders if (folder / JOURNAL_FILE).exists()), None)
