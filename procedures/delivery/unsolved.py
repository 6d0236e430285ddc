"""What a defect kept from being solved or shown: a page all the same, and the tracebacks beside the journal."""

import shlex
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from ams.errors import AmsError, WriteFailed
from ams.whole_file import write_whole
from procedures.errors import NotSolved, ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.report.plain_page import PlainPage, write_plain
from rig.defects import defect_text
from rig.errors import RigError

DEFECTS_FILE: Final = "defects.txt"
"""In the run's folder, which is what is sent."""


def keep_tracebacks(folder: Path, tracebacks: Mapping[str, str]) -> None:
    """Write the tracebacks, by what each is of, or take away those of a delivery before; what fails is left."""
    path = folder / DEFECTS_FILE
    with suppress(WriteFailed, OSError):
        if tracebacks:
            write_whole(path, "\n".join(f"{name}:\n{text}" for name, text in tracebacks.items()).encode("utf-8"))
        else:
            path.unlink(missing_ok=True)


@contextmanager
def page_of_unsolved(folder: Path) -> Iterator[None]:
    """Leave page, verdict and traceback of a run whose solving ends in a defect; what is refused goes on its way.

    Raises: NotSolved.
    """
    try:
        yield
    except (AmsError, ProcedureError, RigError, OSError):
        raise
    except Exception as error:
        why = (
            f"{defect_text(error)}; every dwell of the run is kept in its journal: send the run's folder; calrig solve "
            f"{shlex.quote(str(folder))} with a newer version of calrig does it"
        )
        with suppress(Exception):  # the rim: the sentence is told on the screen all the same
            with JournalReader.open(folder) as reader:
                header, state = reader.header, str(reader.state())
            write_plain(folder, PlainPage(header.title, header.run_id, state, why), tuple(header.plan.sensors))
        keep_tracebacks(folder, {"the run": "".join(traceback.format_exception(error))})
        raise NotSolved(f"{folder}: it could not be solved: {why}") from error
