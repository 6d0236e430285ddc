"""A finished run into the archive, out of its journal alone."""

import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ams.archive.runs import Override, PublishedRun
from ams.sets.sensed_quantity import FIELDS
from procedures.delivery.deliver import SolvedRun, sets_of, solve_run
from procedures.delivery.kept_sets import kept_sets
from procedures.delivery.lessons import teach
from procedures.delivery.parts import Parts
from procedures.delivery.publish import publish_solved
from procedures.delivery.taken_back_sets import withdraw_taken_back
from procedures.errors import RequestError


@dataclass(frozen=True)
class PublishedFolder:
    """Where a run was published, and what is there now."""

    archive_url: str
    run: PublishedRun
    untaught: str | None
    """Why the archive does not hold what the run teaches of the next; None where it does."""


def publish_folder(
    folder: Path,
    archive_of: Callable[[bool], str],
    override: Override | None = None,
    supersede: Override | None = None,
) -> PublishedFolder:
    """Solve a finished run out of its journal again and publish it; then keep what it teaches.

    Raises: RequestError where the run did not finish or has nothing to publish; ams.errors.ArchiveError.
    """
    run = solve_run(folder)
    if not run.is_finished:
        raise RequestError(
            f"{folder}: the run is {run.record.state}, only a finished one has sets; nothing was published; "
            f"calrig handover {folder} says what comes next"
        )
    sets = sets_of(run)
    if not sets:
        raise RequestError(f"{folder}: no sensor has a set: {'; '.join(_without_set(run))}; nothing was published")
    url = archive_of(run.record.is_simulated)
    withdraw_taken_back(url, folder)
    sets |= kept_sets(url, sets)
    standing = {name: made for name, made in sets.items() if made.withdrawal is None}
    published = publish_solved(url, folder, run.record, run.sensors, standing or sets, override, supersede)
    parts = Parts(shlex.quote(str(folder)))
    parts.made("lessons", lambda: teach(url, run.record, run.sensors))
    return PublishedFolder(url, published, parts.failure_of("lessons"))


def _without_set(run: SolvedRun) -> Iterator[str]:
    """Yield why a sensor has no set, one sentence for each."""
    for name, solved in run.sensors.items():
        if solved.failure is not None:
            yield f"{name}: {solved.failure}"
        elif solved.static:
            yield f"{name}: was measured at rest, which determines no coefficients"
        elif solved.calibration is not None and solved.calibration.model not in FIELDS:
            yield (
                f"{name}: was solved by the model {solved.calibration.model}, of which there is no coefficient set: "
                "its results stand in the report and in the document of calrig solve --json"
            )
