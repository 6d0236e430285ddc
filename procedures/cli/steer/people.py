"""``calrig note``, ``ack``, ``void``, ``redo``, ``handover``, ``salvage``: what people do beside steering a run."""

import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from procedures.cli.locations import find_run, person_named
from procedures.cli.options import (
    RUNS,
    AnyRun,
    NamedOperator,
    NamedRun,
    NeededReason,
    OnlyRun,
    Operator,
    RunsFolder,
)
from procedures.cli.output import note as tell
from procedures.cli.output import say
from procedures.cli.queues_disarmed import disarmed_by
from procedures.cli.steer.archive_url import url_of_run
from procedures.cli.steer.choose_run import alive_or_latest, run_in_state
from procedures.cli.steer.dropped import tell_dropped
from procedures.delivery.ended_results import end_results
from procedures.errors import ExitStatus, JournalTakenAway, RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.corrections import (
    TAKES_BACK,
    Authorisation,
    acknowledge,
    add_note,
    measured_from,
    measured_of,
    void_from,
)
from procedures.journal.requests.corrections import redo as redo_replication
from procedures.journal.requests.spool import ask
from procedures.journal.salvage import salvage as rescue
from procedures.journal.sidecar.alert_record import is_known_elsewhere, keep_acknowledgement
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.sidecar.second_folder import second_folder
from procedures.journal.taken_away import require_not_taken_away
from procedures.queue.hands import REMOUNTED
from procedures.records.dwells import DwellRecord
from procedures.run.handover import handover as page

Remounted = Annotated[
    bool,
    Parameter(
        negative=(),
        help="The package was moved: it gets a coning angle and azimuth of its own from here on.",
    ),
]


def note(
    run: Annotated[str, Parameter(help="As for the other commands; with one word alone, that is TEXT.")],
    text: Annotated[str | None, Parameter(help="What to write down.")] = None,
    /,
    *,
    out: RunsFolder = RUNS,
    operator: Operator = None,
) -> None:
    """Write a note into the journal of a run, whether it runs or not: `calrig note [RUN] TEXT`.

    Without RUN it is the run that is alive, else the latest.
    """
    named, words = (None, run) if text is None else (run, text)
    if not words.strip() or (named is None and _is_run(words, out)):
        raise RequestError(f"note: got {words!r}, needed is what to write down; nothing was noted")
    folder, by = alive_or_latest(named, out), person_named(operator)
    if is_owned(folder):
        ask(folder, "note", by, datetime.now(UTC), words)
    else:
        add_note(folder, by, words)
    say(f"{folder}: noted")


def ack(
    run: AnyRun = None,
    text: Annotated[str, Parameter(help="What is being done about it.")] = "",
    /,
    *,
    out: RunsFolder = RUNS,
    operator: Operator = None,
) -> None:
    """Acknowledge the alarm of a run: repeats and escalation end; the run stays as it is."""
    by = person_named(operator)
    try:
        folder = alive_or_latest(run, out)
        require_not_taken_away(folder)
    except (RequestError, JournalTakenAway):
        if run is None or not is_known_elsewhere(name := Path(run).name):
            raise
        keep_acknowledgement(name, by, text, datetime.now(UTC))
        say(f"{run}: acknowledged; the run is not there any more, what is known of it is in {second_folder() / name}")
        return
    if is_owned(folder):
        ask(folder, "ack", by, datetime.now(UTC), text)
    else:
        acknowledge(folder, by, text)
    say(f"{folder}: acknowledged")


def void(
    run: OnlyRun = None,
    /,
    *,
    from_: Annotated[int, Parameter(name="--from")],
    reason: NeededReason,
    operator: NamedOperator,
    remounted: Remounted = False,
    out: RunsFolder = RUNS,
) -> None:
    """Take back a dwell and everything measured after it; `calrig resume` measures it again.

    Nothing is deleted: the journal keeps the dwells and says who took them back and why. No process may run the run.
    How many it takes back is said before; at a terminal, those of more than one replication only after a yes.

    Parameters
    ----------
    from_
        Step of the first dwell that counts no more, as the report and `calrig handover` name it.
    """
    folder = run_in_state(run, out, TAKES_BACK, "taken back from")
    _require_leave(folder, measured_from(folder, from_))
    count = void_from(folder, from_, Authorisation(person_named(operator), reason, remounted))
    say(f"{folder}: {count} dwells taken back; calrig resume {folder} measures them again")
    _end_results(folder)
    tell_dropped(folder)
    _tell_queues(folder, is_remounted=remounted)


def redo(
    run: OnlyRun = None,
    /,
    *,
    replication: int,
    reason: NeededReason,
    operator: NamedOperator,
    remounted: Remounted = False,
    out: RunsFolder = RUNS,
) -> None:
    """Take back one replication; `calrig resume` measures it again. No process may run the run.

    How many dwells it takes back is said before.

    Parameters
    ----------
    replication
        Number of the replication, from 1.
    """
    folder = run_in_state(run, out, TAKES_BACK, "taken back from")
    _require_leave(folder, measured_of(folder, replication))
    count = redo_replication(folder, replication, Authorisation(person_named(operator), reason, remounted))
    say(f"{folder}: {count} dwells of replication {replication} taken back; calrig resume {folder} measures them again")
    _end_results(folder)
    tell_dropped(folder)
    _tell_queues(folder, is_remounted=remounted)


def _tell_queues(folder: Path, *, is_remounted: bool) -> None:
    """Where the package was moved, nobody has said for a queue what is mounted now."""
    for sentence in disarmed_by(REMOUNTED, run=folder) if is_remounted else ():
        say(sentence)


def handover(run: AnyRun = None, /, *, out: RunsFolder = RUNS) -> int:
    """Print the whole state of a run on one page, for whoever takes over."""
    folder = alive_or_latest(run, out)
    say(page(folder, second_folder()).rstrip("\n"))
    with JournalReader.open(folder) as reader:
        return ExitStatus.WRONG_REQUEST if reader.damage().names else ExitStatus.DONE


def salvage(run: NamedRun, /, *, to: Path | None = None, out: RunsFolder = RUNS) -> None:
    """Take what is intact out of a damaged journal, into a new folder; the old one is left as it is.

    Parameters
    ----------
    to
        The new folder; by default beside the run, its name with -salvaged.
    """
    folder = find_run(run, out)
    found = rescue(folder, to or folder.with_name(f"{folder.name}-salvaged"))
    say(f"{found.path.parent}: {found.dwells} dwells and {found.events} events are intact")
    for event in found.lost:
        say(f"lost: event {event}")
    if found.behind:
        say(f"lost: {found.behind} events that were committed behind the last that can be read; nobody can tell which")
    for name in found.quarantined:
        say(f"damaged, to be measured again: {name}")
    for name in found.taken_back:
        say(f"stays taken back, as a damaged event says: {name}")
    if found.lost or found.behind:
        say("not usable: what is lost may have taken back dwells that count in the new run, and its verdict says so;")
        say("a person answers for it by name and reason (calrig archive release, calrig archive accept)")


def _end_results(folder: Path) -> None:
    """End what rested on the dwells that were taken back, in the folder and in the archive of the run; say both."""
    with JournalReader.open(folder) as reader:
        is_simulated = reader.header.is_simulated
    ended = end_results(folder, url_of_run(folder, None, is_simulated=is_simulated))
    for sentence in ended.done:
        say(sentence)
    for sentence in ended.remains:
        tell(sentence)


def _require_leave(folder: Path, dwells: Sequence[DwellRecord]) -> None:
    """Say what is about to be taken back; at a terminal ask where it is more than one replication.

    Raises: RequestError where the answer is not yes.
    """
    design = [dwell for dwell in dwells if dwell.purpose == "design"]
    touched = sorted({dwell.replication for dwell in design})
    of = f"replication{'' if len(touched) == 1 else 's'} {', '.join(map(str, touched))}"
    whose = f", {len(design)} of the design in {of}" if design else ", none of the design"
    tell(f"{folder}: takes back {len(dwells)} dwell{'' if len(dwells) == 1 else 's'}{whose}")
    if len(touched) <= 1 or not sys.stdin.isatty():
        return
    tell("Type yes to take them back:")
    if sys.stdin.readline().strip().lower() != "yes":
        raise RequestError(f"{folder}: not confirmed; nothing was taken back")


def _is_run(word: str, runs: Path) -> bool:
    """Return True where the one word that was given names a run, so that the text is missing."""
    try:
        find_run(word, runs)
    except RequestError:
        return False
    return True
