"""Begin a new run: its folder gets an owner, a journal and the plan as a file, then the engine works."""

from contextlib import suppress
from pathlib import Path

from ams.errors import WriteFailed
from procedures.errors import JournalError, StorageFailed
from procedures.journal.header import RunHeader
from procedures.journal.journal import Journal
from procedures.journal.plan_file import write_plan
from procedures.journal.requests.spool import Spool
from procedures.journal.sidecar.owner import owning
from procedures.journal.storage import JOURNAL_FILE
from procedures.plan.plan import Plan
from procedures.records.progress import RunObserver
from procedures.run.dwell.measure import OpenRig
from procedures.run.ending import Outcome
from procedures.run.engine import Start, run
from procedures.run.readiness import readiness
from procedures.run.services import RunServices, with_run_limits
from procedures.run.unbegun import telling_where_nothing_is_stored
from procedures.run.watch.disk_space import require_room
from rig.clock import Clock
from rig.crash_points import CrashPoint, crash_point
from rig.description.read import rig_from_json
from rig.local_time import local_day


def begin(
    run_dir: Path,
    header: RunHeader,
    plan: Plan,
    rig: OpenRig,
    observer: RunObserver | None = None,
    idle_clock: Clock | None = None,
    services: RunServices | None = None,
) -> Outcome:
    """Run ``plan`` on an open rig in a new folder.

    Raises: RequestError (also where the disk has no room or a standard is out of date), JournalError and
    StorageFailed before the first move; a defect of ours after the safe stop.
    """
    services = with_run_limits(services, header)
    ready = readiness(rig_from_json(header.rig_json), local_day(header.created_utc))
    if not header.is_simulated:
        ready.require(header.rig_path)
    require_room(run_dir, plan, services.free_bytes(run_dir), services.run_limits.min_free_mb)
    with owning(run_dir, idle_clock):
        with telling_where_nothing_is_stored(run_dir, plan, 0, rig, observer, services):
            journal = Journal.create(run_dir / JOURNAL_FILE, header, rig.clock)
            crash_point(CrashPoint.RUN_CREATED)
            try:
                journal.append_event("readiness", {"engineering": [*ready.missing, *ready.contradictions]}, rig.clock)
                _leave_plan(run_dir, header)
            except StorageFailed:
                with suppress(JournalError):  # its disk takes nothing; what is committed is in its log
                    journal.close()
                raise
        services.begun()
        return run(plan, rig, journal, Spool(run_dir), Start(header.operator), None, observer, idle_clock, services)


def _leave_plan(run_dir: Path, header: RunHeader) -> None:
    """Write the plan beside the journal, which holds it too: what is refused here costs no run."""
    try:
        write_plan(run_dir, header)
    except WriteFailed as error:
        raise StorageFailed(f"{error}; nothing moved; then calrig resume {run_dir}") from error
