"""``calrig ring``: what the stop guard of a run starts when the run's process has ended without a word."""

import json
import signal
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from procedures.alerts.dispatcher import AlertDispatcher
from procedures.alerts.settings import AlertSettings, chosen_alerts
from procedures.cli.options import Alerts
from procedures.cli.run.attend import ring_out
from procedures.errors import ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.guard_record import guard_sentence
from procedures.journal.sidecar.last_words import LastWords, keep_last_words
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.status.standing import progress_of
from procedures.journal.status.status import status
from procedures.journal.status.stop_advice import advice_of
from procedures.records.progress import Progress, SilentObserver
from procedures.records.states import ACTIVE, State
from procedures.run.ending import DIED
from procedures.run.stop_page import explain
from rig.clock import SystemClock
from rig.errors import DescriptionError
from rig.system_parts import present

DEAF = present("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP")
"""What a guard ignores, and whoever it starts is born deaf to."""


def ring(run: Path, /, *, record: str, alerts: Alerts = None) -> None:
    """Tell people that the process of a run has ended without a word, and ring on until somebody knows.

    Parameters
    ----------
    record
        What its stop guard knows, as JSON.
    """
    for number in DEAF:
        signal.signal(number, signal.SIG_DFL)
    guarded, folder = json.loads(record), second_folder()
    sentence, stopped_utc = guard_sentence(guarded), datetime.fromisoformat(guarded["stopped_utc"])
    title, rig, last_progress = _last_progress(run, sentence)
    settings: AlertSettings | None = None
    try:
        settings = chosen_alerts(alerts)
    finally:  # the page also where the file of alerts is wrong; people first, then the disk
        words = (title, SystemClock(), SilentObserver(), str(run), str(folder / run.name), rig, advice_of(str(run)))
        dispatcher = AlertDispatcher(settings or AlertSettings(), *words)
        if last_progress.state is State.FINISHED:
            dispatcher.tell_end("finished, and nothing delivered", f"{sentence}\ncalrig solve {run} delivers it.")
        else:
            dispatcher.on_event(last_progress)
            if last_progress.state is State.INTERRUPTED:  # the next resume journals it, and need not tell it again
                keep_last_words(run, folder, LastWords(sentence, stopped_utc, DIED))
            explain(run, sentence, {}, folder, DIED, stopped_utc)
    ring_out(run, dispatcher)


def _last_progress(run: Path, sentence: str) -> tuple[str, str, Progress]:
    """Return title, rig and where the journal has the run stand: what goes on there was interrupted."""
    try:
        stands = status(run)
        with JournalReader.open(run) as reader:
            title, rig = reader.header.title, reader.rig.rig.name
    except (ProcedureError, DescriptionError):
        return run.name, "", Progress("state", State.INTERRUPTED, 0, 0, 0, 0, None, None, sentence, cause=DIED)
    state = State.INTERRUPTED if stands.state in ACTIVE else stands.state
    cause = DIED if state is State.INTERRUPTED else ""
    return title, rig, replace(progress_of("state", stands, sentence), state=state, cause=cause)
