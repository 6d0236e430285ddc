"""What a user sees when something went wrong: a sentence and an exit status, never a traceback."""

import os
import sys
import traceback
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeGuard

from platformdirs import user_state_path

from ams.errors import AmsError, ArchiveError, ArchiveForbids, ArchiveUnknown, SolveError, VectorsDisagree, WriteFailed
from ams.exports.optional_libraries import EXTRA_OF, missing_sentence
from procedures.cli.program_log import tell as log
from procedures.cli.standard_streams import let_go_of
from procedures.errors import ExitStatus, ProcedureError
from rig.defects import defect_text, is_ours
from rig.errors import DescriptionError, RequestRefused, RigError, WaitEnded
from rig.plain_text import one_line

WRONG_REQUEST = (DescriptionError, RequestRefused, ArchiveUnknown, ArchiveForbids)
LISTED = "  - "
"""How a line of a sentence begins that is one of a list."""
FAILED = (SolveError, VectorsDisagree, ArchiveError, WriteFailed)
"""Of the mathematics; every other error of it is a wrong request."""


def status_of(error: BaseException) -> ExitStatus:
    """Return the exit status of an error, by the table of ``procedures.errors``."""
    if isinstance(error, ProcedureError):
        return error.exit_status
    if isinstance(error, KeyboardInterrupt | WaitEnded):
        return ExitStatus.ABORTED
    if isinstance(error, WRONG_REQUEST) or _misses_an_extra(error):
        return ExitStatus.WRONG_REQUEST
    if isinstance(error, AmsError) and not isinstance(error, FAILED):
        return ExitStatus.WRONG_REQUEST
    return ExitStatus.FAILED


def tell(error: BaseException) -> None:
    """Print the sentence of an error on standard error; a defect of ours also leaves a report file."""
    if isinstance(error, SystemExit):
        return
    if isinstance(error, BrokenPipeError):
        let_go_of(sys.stdout)  # `calrig … | head` ends quietly
        return
    sentence = sentence_of(error)
    log("error", sentence, "error")
    with suppress(OSError):  # nobody reads it where the terminal is gone; the status is told all the same
        for line in sentence.splitlines():
            leads = "" if line.startswith(LISTED) else "calrig: "
            print(f"{leads}{one_line(line)}", file=sys.stderr, flush=True)  # noqa: T201


def sentence_of(error: BaseException) -> str:
    """Return what a person reads of an error; a defect of ours also leaves a report file."""
    if isinstance(error, RigError | ProcedureError | AmsError):
        return str(error)
    if isinstance(error, KeyboardInterrupt):
        return f"stopped by {error}" if error.args else "interrupted from the keyboard"
    if _misses_an_extra(error):
        return missing_sentence(str(error.name), "nothing was done")
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, OSError) and error.strerror:
        return f"the system refused: {error.strerror}"
    if isinstance(error, MemoryError):
        return f"{error or 'no memory is left'}; end other programs, or raise what this account or unit may have"
    whom = "" if is_ours(error) else " to whoever made it"
    return f"this is {defect_text(error)}; please send {_write_report(error)}{whom}"


def _misses_an_extra(error: BaseException) -> TypeGuard[ModuleNotFoundError]:
    return isinstance(error, ModuleNotFoundError) and str(error.name).partition(".")[0] in EXTRA_OF


def _write_report(error: BaseException) -> Path:
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    folder = user_state_path("calrig")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"defect-{stamp}-{os.getpid()}.txt"
        path.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
    except OSError:
        traceback.print_exception(error)
        return Path("the lines above")
    return path
