"""Which run a command means: the one that it names, or, where it names none, the one that there is no doubt about.

What was chosen is told on standard error before anything is done to it.
"""

from collections.abc import Collection, Iterable
from pathlib import Path

from procedures.cli.locations import find_run
from procedures.cli.output import note
from procedures.errors import RequestError
from procedures.journal.status.run_list import RunList
from procedures.records.states import State

_MOST_NAMED = 5


def alive_or_latest(run: str | None, runs: Path) -> Path:
    """Return the run that is named, else the one that is alive, else the latest. Raises: RequestError."""
    if run is not None:
        return find_run(run, runs)
    listing = RunList(runs)
    alive = listing.alive()
    if len(alive) > 1:
        raise RequestError(f"{runs}: {len(alive)} runs are alive ({_names(alive)}); nothing was done; name one of them")
    if alive:
        note(f"{alive[0]}: the run that is alive")
        return alive[0]
    latest, left_out = listing.latest()
    for listed_run in left_out:
        note(f"{listed_run.path}: left out: {listed_run.trouble}")
    if latest is None:
        raise RequestError(
            f"{runs}: holds no run; nothing was done; name a run, or give the folder of runs (--out, --runs)"
        )
    note(f"{latest.path}: the latest run; none is alive")
    return latest.path


def run_in_state(run: str | None, runs: Path, states: Collection[State], what: str) -> Path:
    """Return the run that is named, else the only one in one of ``states`` that no process runs.

    ``what``: what is to be done to it, such as "resumed". Raises: RequestError where there is none, or a choice.
    """
    if run is not None:
        return find_run(run, runs)
    found = [run for run in RunList(runs).read() if run.state in states and not run.is_alive]
    if not found:
        raise RequestError(f"{runs}: holds no run that can be {what}; nothing was done; calrig status --all lists them")
    if len(found) > 1:
        names = _names(run.path for run in found)
        raise RequestError(f"{runs}: {len(found)} runs can be {what} ({names}); nothing was done; name one of them")
    note(f"{found[0].path}: {found[0].state}, the only run that can be {what}")
    return found[0].path


def _names(paths: Iterable[Path]) -> str:
    names = [path.name for path in paths]
    return ", ".join(names[:_MOST_NAMED]) + (" …" if len(names) > _MOST_NAMED else "")
