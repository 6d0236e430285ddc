"""A run resumed as `calrig resume` resumes it, on a rig that the test has opened."""

from pathlib import Path

from procedures.records.progress import RunObserver
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import Outcome
from procedures.run.resume import ResumeAuthorisation, go_on, taken_over
from procedures.run.services import RunServices
from rig.clock import Clock


def resume_on(
    run_dir: Path,
    rig: OpenRig,
    operator: str,
    reason: str = "",
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    services: RunServices | None = None,
    *,
    accepts_changes: bool = False,
) -> Outcome:
    """Take the run over and go on with it."""
    authorisation = ResumeAuthorisation(operator, reason, accepts_changes)
    with taken_over(run_dir, authorisation, idle_clock) as found:
        return go_on(run_dir, found, rig, authorisation, observer, idle_clock, services)
