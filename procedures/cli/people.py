"""``calrig note``, ``ack``, ``void``, ``redo``, ``handover``, ``salvage``: what people do beside steering a run."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from procedures.cli.output import say
from procedures.cli.places import find_run, login_name
from procedures.errors import RequestError
from procedures.journal.corrections import Word, acknowledge, add_note, void_from
from procedures.journal.corrections import redo as take_back
from procedures.journal.owner import is_owned
from procedures.journal.salvage import salvage as rescue
from procedures.journal.spool import ask
from procedures.run.handover import handover as page

Flag = Annotated[bool, Parameter(negative=())]


def note(run: str, text: str, /, *, operator: str | None = None) -> None:
    """Write a note into the journal of a run, whether it runs or not.

    Parameters
    ----------
    run
        The run.
    text
        What to write down.
    operator
        Who writes; by default the login name.
    """
    if not text.strip():
        raise RequestError(f"note: got {text!r}, needed is what to write down; nothing was noted")
    folder, by = find_run(run), operator or login_name()
    if is_owned(folder):
        ask(folder, "note", by, datetime.now(UTC), text)
    else:
        add_note(folder, by, text)
    say(f"{folder}: noted")


def ack(run: str, text: str = "", /, *, operator: str | None = None) -> None:
    """Acknowledge the alarm of a run: repeats and escalation end; the run stays as it is.

    Parameters
    ----------
    run
        The run.
    text
        What is being done about it.
    operator
        Who knows of it; by default the login name.
    """
    folder, by = find_run(run), operator or login_name()
    if is_owned(folder):
        ask(folder, "ack", by, datetime.now(UTC), text)
    else:
        acknowledge(folder, by, text)
    say(f"{folder}: acknowledged")


def void(
    run: str, /, *, from_: Annotated[int, Parameter(name="--from")], reason: str, operator: str, remounted: Flag = False
) -> None:
    """Take back a dwell and everything measured after it; `calrig resume` measures it again.

    Nothing is deleted: the journal keeps the dwells and says who took them back and why.

    Parameters
    ----------
    run
        The run; no process may run it.
    from_
        Step of the first dwell that counts no more, as the report and `calrig handover` name it.
    reason
        Why.
    operator
        Who decides.
    remounted
        The package was moved: it gets a coning angle and azimuth of its own from here on.
    """
    folder = find_run(run)
    count = void_from(folder, from_, Word(operator, reason, remounted))
    say(f"{folder}: {count} dwells taken back; calrig resume {folder} measures them again")


def redo(run: str, /, *, replication: int, reason: str, operator: str, remounted: Flag = False) -> None:
    """Take back one replication; `calrig resume` measures it again.

    Parameters
    ----------
    run
        The run; no process may run it.
    replication
        Number of the replication, from 1.
    reason
        Why.
    operator
        Who decides.
    remounted
        The package was moved: it gets a coning angle and azimuth of its own from here on.
    """
    folder = find_run(run)
    count = take_back(folder, replication, Word(operator, reason, remounted))
    say(f"{folder}: {count} dwells of replication {replication} taken back; calrig resume {folder} measures them again")


def handover(run: str, /) -> None:
    """The whole state of a run on one page, for whoever takes over.

    Parameters
    ----------
    run
        The run.
    """
    say(page(find_run(run)).rstrip("\n"))


def salvage(run: str, /, *, to: Path | None = None) -> None:
    """Take what is intact out of a damaged journal, into a new folder; the old one is left as it is.

    Parameters
    ----------
    run
        The run, or its damaged journal.
    to
        The new folder; by default beside the run, its name with -salvaged.
    """
    folder = find_run(run)
    found = rescue(folder, to or folder.with_name(f"{folder.name}-salvaged"))
    say(f"{found.path.parent}: {found.dwells} dwells and {found.events} events are intact")
    if found.events_promised > found.events:
        say(f"lost: {found.events_promised - found.events} events that were committed")
    for name in found.quarantined:
        say(f"damaged, to be measured again: {name}")
