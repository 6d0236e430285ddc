"""A run from its command to its first journal line: what refuses it there is told to people where nobody reads it.

From then on the engine tells. A unit, a queue and a script read no screen, and whoever started them may have left.
"""

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from procedures.alerts.dispatcher import tell_people
from procedures.alerts.reader import is_read
from procedures.alerts.settings import chosen_alerts
from procedures.cli.failure import sentence_of
from procedures.cli.locations import JOURNAL
from procedures.cli.output import note
from procedures.errors import ProcedureError
from procedures.journal.sidecar.alert_record import outcome_sentence
from procedures.journal.status.status import status
from procedures.records.states import RESUMABLE
from rig.clock import SystemClock
from rig.errors import DescriptionError, WaitEnded


@dataclass
class Opening:
    """What is known by and by of a run that is to begin."""

    title: str
    run: Path | None = None
    """None before it has a folder."""
    is_virtual: bool = False
    """In virtual time nobody is told."""
    is_over: bool = False
    """The engine tells, or has told."""
    rig: str = ""
    """Its name; empty before the rig file was read."""


@contextmanager
def opening(title: str, alerts: Path | None, run: Path | None = None, *, is_virtual: bool = False) -> Iterator[Opening]:
    """Inside, a run begins; an error that nobody reads is told to people, then goes on its way."""
    begins = Opening(title, run, is_virtual)
    try:
        yield begins
    except Exception as error:  # also a defect of ours: the night does not happen either way
        is_known = begins.is_over or isinstance(error, WaitEnded) or is_read()
        if not (is_known or begins.is_virtual) and _is_left_standing(begins.run):
            _tell(begins, alerts, error)
        raise


def _tell(begins: Opening, alerts: Path | None, error: Exception) -> None:
    is_begun = begins.run is not None and (begins.run / JOURNAL).exists()
    run = (
        f"The run is {begins.run}, and as it was; calrig handover {shlex.quote(str(begins.run))} says what comes next."
        if is_begun
        else "There is no run yet, and nothing moved. Mend what is named above, then begin it again."
    )
    text = f"{sentence_of(error)}\n{run} Nobody was at a terminal to read this."
    tell_whom_it_concerns(begins.title, "not begun", text, alerts, begins.rig)


def tell_whom_it_concerns(title: str, word: str, text: str, alerts: Path | None = None, rig: str = "") -> None:
    """Tell the people of a file of alerts, or of the user's own; whom it did not reach is told here."""
    try:
        settings = chosen_alerts(alerts)
    except DescriptionError as wrong:
        note(f"nobody was told: {wrong}")
        return
    if settings is not None:
        for outcome in tell_people(settings, SystemClock(), title, word, text, rig):
            if outcome["failed"]:
                note(outcome_sentence(outcome))


def _is_left_standing(run: Path | None) -> bool:
    """Return whether a run that was refused waits for somebody: not one that has ended or that another process runs."""
    if run is None or not (run / JOURNAL).exists():
        return True
    try:
        return status(run).state in RESUMABLE
    except ProcedureError:
        return True
