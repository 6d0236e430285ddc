"""Who had the rig outside the queue. What was armed, and what was said to be mounted, was so for the rig before that.

Every use of a rig leaves a mark on this machine (:mod:`rig.lines.lock`), whoever's it is and however it ends. A mark
that the queue's record does not know becomes an event of it, ``used``, by whoever looks first: the command that has
the rig, a page, or the runner, also one that comes later. A stop from elsewhere goes into the record of this account's
queues also where the disk takes no mark; while it takes none no runner starts anything.
"""

from collections.abc import Iterator, Sequence
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
from rig.lines.lock import LeftUse, LockOwner, identity_of, leave_use, owner_of, require_marks, uses

ABORT, STOP, JOG_STOP, REMOUNTED, RESUME = "abort", "stop", "jog --stop", "package remounted", "calrig resume"
TAKEN_BACK = "dwells taken back"
"""What is done to a rig without holding it, or before it is held."""
LEAVES_MOUNTED = frozenset({ABORT, STOP, JOG_STOP, TAKEN_BACK, "jog", "devices", "attitude"})
"""What a rig is held for while nobody puts other sensors on it. A run by hand may be of others, and so may the rest."""


def heed(store: QueueStore, done: Sequence[LockOwner] = ()) -> Queue:
    """Return the queue, once every use of its rig from outside is in its record. Raises: ProcedureError.

    ``done``: what was done to rigs from elsewhere, of which there may be no mark.
    """
    queue = store.read()
    if not _to_record(store.folder, queue, done):
        return queue

    def recorded(now: Queue) -> Change | None:
        found = _to_record(store.folder, now, done)
        return _used(now, found) if found else None

    return store.change(recorded)


def heed_all(queues: Path, clock: Clock, left: LeftUse | None = None) -> list[str]:
    """Have every queue of a folder heed the uses of its rig; returns a sentence for each that is disarmed by this one.

    ``left``: what was done from elsewhere; None where this process holds the rig, which nothing does without a mark. A
    runner may have heeded it before. Where neither the queue's record nor a mark could be written, it is armed still,
    and the sentence says so.
    """
    try:
        folders = _folders_in(queues)
    except OSError as error:
        return [f"{queues}: cannot be looked at: {error.strerror}; the runner of a queue there sees it by itself"]
    sentences = []
    for folder in folders:
        store = QueueStore(folder, clock)
        try:
            queue = heed(store, () if left is None else left.owners)
            marks = _marks_of_this_process(queue) if left is None else [owner.mark for owner in left.owners]
        except ProcedureError as error:
            sentences += _untold(store, left, error)
            continue
        used = [event.detail for event in queue.events if event.kind == "used" and event.detail["disarms"]]
        if queue.arming is None and used and not set(marks).isdisjoint(used[-1]["marks"]):
            sentences.append(
                f"queue {folder.name}: waits for this rig, {used[-1]['disarms']}: it is disarmed by this, and starts "
                "nothing until somebody has looked at the rig and armed it again (calrig queue arm)"
            )
    if left is not None and left.unmarked:
        sentences.append(
            f"{left.unmarked}: no queue of another account is told of this: whoever has one for this rig disarms it "
            "(calrig queue disarm)"
        )
    return sentences


def _folders_in(queues: Path) -> list[Path]:
    return sorted(path.parent for path in queues.glob(f"*/{FILE}"))


def _untold(store: QueueStore, left: LeftUse | None, error: ProcedureError) -> list[str]:
    """Return what to say of a queue whose record does not take what was done, where it may wait for that rig."""
    if left is None or not left.unmarked:
        return [
            f"queue {store.folder.name}: its record does not take this: {error}; where it waits for this rig its "
            "runner finds the mark of this before it starts anything"
        ]
    with suppress(ProcedureError):
        queue = store.read()
        if queue.arming is None or not _of_its_rig(queue, left.owners):
            return []
    return [_still_armed(store.folder, str(error))]


def _still_armed(folder: Path, why: str) -> str:
    return (
        f"queue {folder.name}: IS STILL ARMED, if it was, and may move this rig: {why}; before hands go in end its "
        "runner (calrig queue run: Ctrl-C, or systemctl stop), make room, then calrig queue disarm"
    )


def _to_record(folder: Path, queue: Queue, done: Sequence[LockOwner]) -> list[LockOwner]:
    """Return the uses of which the queue's record does not know, by marks and ``done``. Raises: RequestError."""
    of_here = [owner for owner in _of_its_rig(queue, done) if owner.mark not in queue.uses]
    try:
        marked = unknown_uses(folder, queue)
    except RequestError:
        if not of_here:
            raise
        marked = []
    return list({owner.mark: owner for owner in (*marked, *of_here)}.values())


def _of_its_rig(queue: Queue, done: Sequence[LockOwner]) -> list[LockOwner]:
    rig = {identity_of(resource) for resource in resources_of(queue)} if done else set()
    return [owner for owner in done if identity_of(owner.resource) in rig]


def _marks_of_this_process(queue: Queue) -> list[str]:
    with _as_request():
        return [owner.mark for owner in uses(resources_of(queue)) if owner.is_of_this_process]


def unknown_uses(folder: Path, queue: Queue) -> list[LockOwner]:
    """Return the uses of the rig from outside of which the queue's record does not know. Raises: RequestError."""
    with _as_request():
        found = uses(resources_of(queue))
    return [owner for owner in found if owner.queue != str(folder.resolve()) and owner.mark not in queue.uses]


def require_uses_to_be_seen() -> None:
    """See that who uses a rig can leave a mark. Raises: RequestError."""
    with _as_request():
        require_marks()


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
    try:
        with JournalReader.open(run) as reader:
            header = reader.header
        rig = [] if header.is_rehearsal else [header.rig_path, *real_ports(rig_from_json(header.rig_json))]
    except (ProcedureError, RigError) as error:
        return [f"whose rig this is cannot be told: {error}", *_armed_ones(queues, clock)]
    return heed_all(queues, clock, leave_use(rig, what))


def disarm_by_stop_of_rig(queues: Path, rig_file: Path, what: str, clock: Clock) -> list[str]:
    """Leave on record what is done to a rig from elsewhere, and have the queues heed it; their sentences.

    The ports are left out where the rig file cannot be read, as that of another account.
    """
    rig = [str(rig_file)]
    with suppress(RigError):
        rig += real_ports(read_rig(rig_file))
    return heed_all(queues, clock, leave_use(rig, what))


def _armed_ones(queues: Path, clock: Clock) -> list[str]:
    """Return a sentence for each queue that was not told of something, and is armed or does not say."""
    sentences = []
    for store in (QueueStore(folder, clock) for folder in _folders_in(queues)):
        try:
            is_armed = store.read().arming is not None
        except ProcedureError:
            is_armed = True
        if is_armed:
            sentences.append(_still_armed(store.folder, "it was not told of this"))
    return sentences


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
