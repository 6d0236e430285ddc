"""A folder of files of sets that must not be used any more: one file beside them says by whom, when and why.

The files keep their sealed bytes; who reads one of them out of that folder is told. A copy elsewhere tells nothing.
"""

import json
from datetime import datetime
from pathlib import Path

from ams.errors import SetError
from ams.sets.stated_verdict import Withdrawal
from ams.whole_file import read_whole, write_whole

WITHDRAWN_FILE = "WITHDRAWN.json"


def mark_withdrawn(folder: Path, word: Withdrawal) -> None:
    """Write the file into a folder. Raises: WriteFailed."""
    document = {"withdrawn_by": word.name, "withdrawn_utc": word.withdrawn_utc.isoformat(), "reason": word.reason}
    text = json.dumps(document, ensure_ascii=False, indent=1) + "\n"
    write_whole(folder / WITHDRAWN_FILE, text.encode("utf-8"))


def withdrawn_beside(file: Path) -> Withdrawal | None:
    """Return what the folder of a file says of its sets; None where it says nothing. Raises: SetError."""
    path = file.parent / WITHDRAWN_FILE
    if not path.is_file():
        return None
    try:
        document = json.loads(read_whole(path))
        return Withdrawal(
            str(document["withdrawn_by"]), datetime.fromisoformat(document["withdrawn_utc"]), str(document["reason"])
        )
    except (ValueError, TypeError, KeyError) as error:
        raise SetError(
            f"{path}: says that the sets of this folder are withdrawn, and cannot be read: {error}; {file.name} is not "
            "used; export the set again from the archive"
        ) from error
