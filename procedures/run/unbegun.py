"""Tell people of a run that its disk did not let begin, or go on: the engine, which tells all else, is not there yet.

Nothing has moved yet. Whoever started it may be a queue, a unit or a script that reads no screen.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from procedures.errors import StorageFailed
from procedures.journal.sidecar.last_words import STORAGE, LastWords, keep_last_words
from procedures.journal.storage import JOURNAL_FILE
from procedures.plan.plan import Plan
from procedures.records.progress import Progress, RunObserver
from procedures.records.states import State
from procedures.run.dwell.measure import OpenRig
from procedures.run.services import RunServices
from procedures.run.stop_page import explain
from procedures.run.watch.safe_state import known_rest_deg


@contextmanager
def telling_where_nothing_is_stored(
    run_dir: Path, plan: Plan, done: int, rig: OpenRig, observer: RunObserver | None, services: RunServices
) -> Iterator[None]:
    """Tell people first, then write the page and the last words where a disk takes them; the error goes on its way."""
    try:
        yield
    except StorageFailed as error:
        failure = error if (run_dir / JOURNAL_FILE).exists() else _without_a_run(run_dir, error)
        reason = str(failure)
        if observer is not None:
            with suppress(Exception):  # the rim, as of the engine: a screen that fails keeps nobody from the page
                observer.on_event(_interrupted(plan, done, reason))
        keep_last_words(run_dir, services.second_folder, LastWords(reason, rig.clock.now_utc()))
        explain(run_dir, reason, known_rest_deg(rig), services.second_folder, STORAGE)
        raise failure from error


def _without_a_run(run_dir: Path, error: StorageFailed) -> StorageFailed:
    return StorageFailed(
        f"{run_dir}: its journal cannot be made: {error.__cause__ or error}; there is no run yet, and nothing moved; "
        "make room or repair the disk, then begin it again"
    )


def _interrupted(plan: Plan, done: int, reason: str) -> Progress:
    return Progress(
        event="state",
        state=State.INTERRUPTED,
        dwells_done=done,
        dwells_planned=len(plan.design_dwells),
        replication=0,
        replications=plan.replications,
        rate_per_min=None,
        eta_utc=None,
        message=reason,
        cause=STORAGE,
    )
