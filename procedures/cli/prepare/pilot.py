"""The run that a forecast is to learn from, as an option names it."""

from pathlib import Path

from procedures.cli.locations import find_run
from procedures.delivery.deliver import solve_run
from procedures.solution.beliefs import Pilot
from procedures.solution.pilot import pilot_of
from rig.description.rig_file import RigDescription


def pilot_named(run: str | None, runs: Path, rig: RigDescription) -> Pilot | None:
    """Return what the run showed; None where none is named. Raises: RequestError, JournalError."""
    if run is None:
        return None
    solved = solve_run(find_run(run, runs))
    return pilot_of(solved.record, solved.sensors, rig)
