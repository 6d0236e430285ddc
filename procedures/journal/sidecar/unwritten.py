"""What of a finished run's results does not stand beside its journal, as on a disk that was full, and the way out."""

import shlex
from pathlib import Path

from procedures.journal.sidecar.delivering import delivered_by
from procedures.journal.sidecar.verdict_file import hindered_in, read_verdict
from procedures.records.states import State

SETS_FOLDER = "coefficients"


def unwritten_sentence(folder: Path, state: State) -> str:
    """Say what is not there and the command that makes it; empty where it is there, or still on its way."""
    if state is not State.FINISHED or delivered_by(folder):
        return ""
    if (verdict := read_verdict(folder, state)) is not None:
        return hindered_in(verdict)
    no_set = "" if any((folder / SETS_FOLDER).glob("*")) else ", no coefficient file"
    return f"no verdict{no_set} of this end is written; calrig solve {shlex.quote(str(folder))} makes what is missing"
