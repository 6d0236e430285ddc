"""``calrig status``, ``pause``, ``continue``, ``stop``, ``abort``: look at or steer a run in another process."""

from datetime import UTC, datetime
from typing import Annotated, Literal

from cyclopts import Parameter

from procedures.cli.output import print_json, say
from procedures.cli.places import find_run, login_name
from procedures.journal.spool import ask
from procedures.journal.status import status as look

Json = Annotated[bool, Parameter(negative=(), help="Print one JSON document.")]
Run = Annotated[
    str, Parameter(help="A run folder, its journal, its name under ./runs, or a folder that holds exactly one run.")
]
Operator = Annotated[str | None, Parameter(help="Who asks; by default the login name.")]


def status(run: Run, /, *, json: Json = False) -> None:
    """Look at a run: state, dwells done, when it should end."""
    found = look(find_run(run))
    if json:
        print_json(found.to_document())
        return
    say(f"{found.run}: {found.state}, {found.dwells_done} of {found.dwells_planned} dwells")
    if found.eta_utc is not None:
        say(f"should end {found.eta_utc:%Y-%m-%d %H:%M} UTC")
    if found.held_by is not None:
        say(f"held by: {found.held_by}")
    for name, line in found.lines.items():
        say(f"line of {name}: {line.told()}")


def pause(run: Run, /, *, operator: Operator = None) -> None:
    """Pause a run after the dwell in progress; `calrig continue` goes on."""
    _ask(run, "pause", operator)


def continue_(run: Run, /, *, operator: Operator = None) -> None:
    """Continue a paused or held run."""
    _ask(run, "continue", operator)


def stop(run: Run, /, *, operator: Operator = None) -> None:
    """Stop a run after the dwell in progress; `calrig resume` goes on later."""
    _ask(run, "stop", operator)


def abort(run: Run, /, *, operator: Operator = None) -> None:
    """Abort a run: axes stop now, the run has ended."""
    _ask(run, "abort", operator)


def _ask(run: str, kind: Literal["pause", "continue", "stop", "abort"], operator: str | None) -> None:
    folder = find_run(run)
    ask(folder, kind, operator or login_name(), datetime.now(UTC))
    say(f"{folder}: asked to {kind}; `calrig status {folder}` shows when it did")
