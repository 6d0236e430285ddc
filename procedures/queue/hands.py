"""Who had the rig outside the queue. What was armed, and what was said to be mounted, was so for the rig before that.

Every use of a rig leaves a mark on this machine (:mod:`rig.lines.lock`), whoever's it is and however it ends. A mark
that the queue's record does not know becomes an event of it, ``used``, by whoever looks first: the command that has
the rig, a page, or the runner, also one that comes later.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from procedures.errors import ProcedureError, RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.queue.state import Queue
from procedures.queue.store import FILE, Change, QueueStore
from procedures.queue.words import armed_until
from rig.assembly.open_rig import real_ports
from rig.clock import Clock
from rig.description.read import read_rig, rig_from_json
from rig.errors import RigError
from rig.lines.lock import LockOwner, leave_use, owner_of, uses

ABORT, STOP, JOG_STOP, REMOUNTED, RESUME = "abort", "stop", "jog --stop", "package remounted", "calrig resume"
"""What is done to a rig without holding it, or before it is held."""
LEAVES_MOUNTED = frozenset({ABORT, STOP, JOG_STOP, "jog", "devices", "attitude"})
"""What a rig is held for while nobody puts other sensors on it. A run by hand may be of others, and so may the rest."""


def heed(store: QueueStore) -> Queue:
    """Return the queue, once every use of its rig from outside is in its record. Raises: ProcedureError."""
    queue = store.read()
    if not unknown_uses(store.folder, queue):
        return queue

    def recorded(now: Queue) -> Change | None:
        found = unknown_uses(store.folder, now)
        return _used(now, found) if found else None

    return store.change(recorded)


def heed_all(queues: Path, clock: Clock, left: Sequence[str] | None = None) -> list[str]:
    """Have every queue of a folder heed the uses of its rig; returns a sentence for each that is disarmed by this one.

    ``left``: the marks of what was done; None where this process holds the rig. A runner may have heeded it before.
    """
    try:
        folders = sorted(path.parent for path in queues.glob(f"*/{FILE}"))
    except OSError as error:
        return [f"{queues}: cannot be looked at: {error.strerror}; the runner of a queue there sees it by itself"]
    sentences = []
    for folder in folders:
        try:
            queue = heed(QueueStore(folder, clock))
            marks = _marks_of_this_process(queue) if left is None else left
        except ProcedureError as error:
            sentences.append(f"queue {folder.name}: cannot be told that the rig is used; its runner looks: {error}")
            continue
        used = [event.detail for event in queue.events if event.kind == "used" and event.detail["disarms"]]
        if queue.arming is None and used and not set(marks).isdisjoint(used[-1]["marks"]):
            sentences.append(
                f"queue {folder.name}: waits for this rig, {used[-1]['disarms']}: it is disarmed by this, and starts "
                "nothing until somebody has looked at the rig and armed it again (calrig queue arm)"
            )
    return sentences


def _marks_of_this_process(queue: Queue) -> list[str]:
    with _as_request():
        return [owner.mark for owner in uses(resources_of(queue)) if owner.is_of_this_process]


def unknown_uses(folder: Path, queue: Queue) -> list[LockOwner]:
    """Return the uses of the rig from outside of which the queue's record does not know. Raises: RequestError."""
    with _as_request():
        found = uses(resources_of(queue))
    return [owner for owner in found if owner.queue != str(folder.resolve()) and owner.mark not in queue.uses]


def past_marks_of(folder: Path, resources: Sequence[str]) -> list[str]:
    """Return the marks of what happened to resources outside a queue and is over. Raises: RequestError."""
    with _as_request():
        lasting = {owner.mark for resource in resources if (owner := owner_of(resource)) is not None}
        found = uses(resources)
    return [owner.mark for owner in found if owner.queue != str(folder.resolve()) and owner.mark not in lasting]


def in_use_by(folder: Path, queue: Queue) -> str:
    """Return who outside the queue has its rig now; empty where nobody has. Raises: RequestError."""
    with _as_request():
        found = [owner for resource in resources_of(queue) if (owner := owner_of(resource)) is not None]
    return next((str(owner) for owner in found if owner.queue != str(folder.resolve())), "")


def resources_of(queue: Queue) -> list[str]:
    """Return what is locked where a run of the queue has its rig: rig files and ports."""
    return sorted({resource for item in queue.items for resource in item.resources})


def disarm_by_stop_of_run(queues: Path, run: Path, what: str, clock: Clock) -> list[str]:
    """Leave on record what is done to the rig of a run from elsewhere, and have the queues heed it; their sentences.

    A run that is a rehearsal has no rig. What cannot be left is a sentence too: a stop has been sent by then.
    """

    def leave() -> list[str]:
        with JournalReader.open(run) as reader:
            header = reader.header
        if header.is_rehearsal:
            return []
        return leave_use([header.rig_path, *real_ports(rig_from_json(header.rig_json))], what)

    return _disarmed_by_what_is_left(leave, queues, clock)


def disarm_by_stop_of_rig(queues: Path, rig_file: Path, what: str, clock: Clock) -> list[str]:
    """Leave on record what is done to a rig from elsewhere, and have the queues heed it; their sentences.

    The ports are left out where the rig file cannot be read, as that of another account.
    """

    def leave() -> list[str]:
        left = leave_use([str(rig_file)], what)
        with suppress(RigError):
            left += leave_use(real_ports(read_rig(rig_file)), what)
        return left

    return _disarmed_by_what_is_left(leave, queues, clock)


def _disarmed_by_what_is_left(leave: Callable[[], list[str]], queues: Path, clock: Clock) -> list[str]:
    try:
        left = leave()
    except (ProcedureError, RigError) as error:
        return [f"no queue was told: {error}", *heed_all(queues, clock, [])]
    return heed_all(queues, clock, left)


def _used(queue: Queue, found: list[LockOwner]) -> Change:
    return "used", {
        "who": str(found[-1]),
        "marks": [owner.mark for owner in found],
        "may_be_remounted": any(owner.purpose not in LEAVES_MOUNTED for owner in found),
        "disarms": "" if queue.arming is None else armed_until(queue.arming),
    }


@contextmanager
def _as_request() -> Iterator[None]:
    try:
        yield
    except RigError as error:
        raise RequestError(f"queue: who uses the rig cannot be seen: {error}") from error
