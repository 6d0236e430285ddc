"""A run is added to the queue of its rig, as the command and the page do it: read, checked, and put at the end."""

from pathlib import Path

from procedures.description.named_files import files_named_by
from procedures.description.procedure_file import ProcedureDescription
from procedures.queue import people
from procedures.queue.moments import moment
from procedures.queue.state import Item
from procedures.queue.store import QueueStore, folder_of_rig
from procedures.queue.world import checked
from rig.clock import Clock
from rig.description.read import read_rig


def add_run(
    queues: Path,
    clock: Clock,
    procedure: ProcedureDescription,
    rig: Path,
    out: Path,
    by: str,
    *,
    not_before: str,
    not_after: str,
    may_arm: bool = True,
) -> Item:
    """Add a run at the end of the queue of its rig and check it at once; a refused item stays with its sentences.

    Args:
        queues: the folder of queues.
        procedure: as the caller has read it: what cannot be read is refused before.
        not_before: a time as people say it, such as 22:00; empty for none. So ``not_after``.

        may_arm: whether who adds it may arm that queue: by who may not, it is disarmed.

    Raises: RequestError, rig.errors.RigError.
    """
    described, now = read_rig(rig), clock.now_utc()
    return people.add(
        QueueStore(folder_of_rig(queues, described.rig.name), clock),
        procedure.path,
        rig,
        described,
        out,
        by,
        title=procedure.procedure.title,
        named_files=files_named_by(described, rig, procedure),
        not_before_utc=moment(not_before, "--not-before", now) if not_before else None,
        not_after_utc=moment(not_after, "--not-after", now) if not_after else None,
        refused=checked(procedure.path, rig, out),
        may_arm=may_arm,
    )
