"""The end of a run as it is left for people: last words where the journal did not take them, and the page."""

from dataclasses import replace
from pathlib import Path

from procedures.journal.sidecar.last_words import LastWords, keep_last_words
from procedures.journal.taken_away import TakenAway, keep_taken_away
from procedures.records.states import State
from procedures.run.ending import Outcome
from procedures.run.services import RunServices
from procedures.run.stop_page import ENDED_BY, UNASKED, explain
from rig.clock import Clock


def leave_last_page(outcome: Outcome, folder: Path, services: RunServices, clock: Clock) -> Outcome:
    """Leave the last words and the page of an ending that nobody asked for; the outcome says where, if elsewhere.

    Last words lie beside the journal that a resume takes up, the page where people look: in the folder of the run.
    """
    second_folder, is_on_record, stopped_utc = services.second_folder, True, None
    if outcome.state is State.INTERRUPTED:
        stopped_utc = clock.now_utc()
        words = LastWords(outcome.reason, stopped_utc, outcome.cause)
        is_on_record = keep_last_words(outcome.copy or folder, second_folder, words)
    if outcome.state in UNASKED or outcome.cause in ENDED_BY:
        page = explain(
            folder, outcome.reason, outcome.positions_deg, second_folder, outcome.cause, stopped_utc, outcome.copy
        )
        if outcome.is_journal_away:
            taken = TakenAway(outcome.reason, clock.now_utc(), outcome.copy, page)
            keep_taken_away(folder, second_folder, taken)
        if page is not None and page.parent != folder:
            outcome = replace(outcome, reason=f"{outcome.reason}; the page that tells of it is {page}")
    if is_on_record:
        services.ended()
    return outcome
