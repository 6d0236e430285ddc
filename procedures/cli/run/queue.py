"""``calrig queue``: what runs tonight on a rig, and the runner that starts what is due."""

import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from procedures.cli.locations import login_name, person_named, queues_of_here
from procedures.cli.options import RUNS, Archive, Json, NeededReason, Operator, Rig, RunsFolder
from procedures.cli.output import note, print_json, say
from procedures.cli.run.opening import tell_whom_it_concerns
from procedures.errors import ExitStatus, ProcedureError, RequestError
from procedures.kinds.read import read_procedure
from procedures.queue import people
from procedures.queue.adding import add_run
from procedures.queue.hands import heed
from procedures.queue.moments import moment
from procedures.queue.people import Choice
from procedures.queue.runner import Runner
from procedures.queue.state import Item, ItemState, Queue
from procedures.queue.store import FILE, QueueStore, folder_of_rig
from procedures.queue.words import armed_sentence, item_document, mounted_sentence, queue_lines
from procedures.queue.world import RigWorld, boot, is_possible
from rig import file_lock
from rig.assembly.unguarded import unguarded_sentences
from rig.clock import SystemClock
from rig.description.read import read_rig

app = App(name="queue", help="What runs tonight on a rig, one run after the other.", group_commands="Commands")
LOOK_S = 1.0
OfRig = Annotated[
    Path | None, Parameter(name="--rig", help="A rig file of the rig; not needed where there is one queue.")
]
Number = Annotated[int, Parameter(help="The number of the item, as calrig queue list tells it.")]


@app.command
def add(
    procedure: Path,
    /,
    *,
    rig: Rig,
    out: RunsFolder = RUNS,
    operator: Operator = None,
    not_before: str = "",
    not_after: str = "",
    json: Json = False,
) -> int:
    """Add a run at the end of the queue of its rig, and check it at once; it is checked again before it starts.

    Parameters
    ----------
    not_before
        A time such as 22:00 or 2026-03-01T22:00, here.
    not_after
        The time after which it is not started any more: it expires.
    """
    item = add_run(
        queues_of_here(),
        SystemClock(),
        read_procedure(procedure),
        rig,
        out,
        person_named(operator),
        not_before=not_before,
        not_after=not_after,
    )
    if json:
        print_json(item_document(item))
    else:
        say(f"item {item.number}: {item.title}: {item.state}")
        for sentence in item.reasons:
            say(f"it would be refused: {sentence}")
    return ExitStatus.WRONG_REQUEST if item.state is ItemState.REFUSED else ExitStatus.DONE


@app.command(name="list")
def list_(*, rig: OfRig = None, json: Json = False) -> None:
    """Show the queue: whether it is armed, what is mounted, and every item with what it waits for."""
    _tell(heed(_store(rig)), json=json)


@app.command
def move(item: Number, /, *, before: int = 0, rig: OfRig = None, operator: Operator = None) -> None:
    """Put an item before another, or at the end.

    Parameters
    ----------
    before
        The item that comes after it; without it, it is put at the end.
    """
    _tell(people.move(_store(rig), item, before, person_named(operator)))


@app.command
def remove(item: Number, /, *, rig: OfRig = None, operator: Operator = None) -> None:
    """Take out an item that has not begun."""
    _tell(people.remove(_store(rig), item, person_named(operator)))


@app.command
def arm(*, until: str, expects: int | None = None, rig: OfRig = None, operator: Operator = None) -> None:
    """Let what waits start, until a time, in the name of the operator; told is what will run, and what is mounted.

    It holds for the rig as it stands: whoever has the rig outside the queue after it disarms the queue.

    Parameters
    ----------
    until
        Nothing starts after it: a time such as 06:00 or 2026-03-02T06:00, here.
    expects
        The sequence of the queue that was seen (list --json): refused where it is another by now.
    """
    clock = SystemClock()
    now = clock.now_utc()
    until_utc = moment(until, "--until", now)
    store = _store(rig)
    seen = heed(store).sequence if expects is None else expects
    _tell(people.arm(store, person_named(operator), until_utc, boot(), now, expects=seen))


@app.command
def disarm(*, rig: OfRig = None, operator: Operator = None) -> None:
    """Let nothing more start. What runs goes on: calrig stop, or abort, ends it."""
    _tell(people.disarm(_store(rig), operator or login_name()))


@app.command
def attest(
    *mounted: Annotated[str, Parameter(help="Each sensor that is mounted, with its datum face: SN1047 or SN1047=A.")],
    rig: OfRig = None,
    operator: Operator = None,
) -> None:
    """Say, by name, what is mounted now; the check set of the next run verifies it by measurement."""
    _tell(people.attest(_store(rig), person_named(operator), people.mounted_in(mounted)))


@app.command
def decide(
    item: Number, choice: Choice, /, *, reason: NeededReason, rig: OfRig = None, operator: Operator = None
) -> None:
    """Say what becomes of a run that tripped, failed, was stopped or aborted; then arm the queue again.

    Parameters
    ----------
    choice
        resume goes on with its run, again measures it from the start, drop leaves it.
    """
    _tell(people.decide(_store(rig), item, choice, reason, person_named(operator)))


@app.command
def run(*, rig: OfRig = None, archive: Archive = None) -> int:
    """Start what is due, until Ctrl-C. It holds no device: what it has started goes on without it.

    One runner a queue; `calrig service --queue RIG` writes its unit. What does not begin is told to the people of
    alerts.toml.
    """
    if not is_possible():
        raise RequestError("queue run: this system hands no lock to another process; nothing was started")
    clock, store = SystemClock(), _store(rig)
    store.folder.mkdir(parents=True, exist_ok=True)
    with (store.folder / "runner.lock").open("a+", encoding="utf-8") as file:
        if not file_lock.take(file, clock, 5):
            raise RequestError(f"{store.folder}: another runner has this queue; nothing was started")
        world = RigWorld(store.folder, clock, unguarded_sentences, archive)
        runner = Runner(store, world, clock, note, tell_whom_it_concerns)
        note(f"queue {store.folder.name}: what is due starts; Ctrl-C ends this, and no run notices")
        signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(ExitStatus.DONE))  # noqa: ARG005
        _run(runner, clock)
    return ExitStatus.DONE


def _run(runner: Runner, clock: SystemClock) -> None:
    printed = ""
    while True:
        try:
            runner.step()
            printed = ""
        except KeyboardInterrupt:
            return
        except ProcedureError as error:
            if str(error) != printed:  # once, however long it lasts
                printed = str(error)
                note(printed)
        try:
            clock.sleep(LOOK_S)
        except KeyboardInterrupt:
            return


def _store(rig: Path | None) -> QueueStore:
    """Return the queue of a rig, or the only one. Raises: RequestError."""
    queues, clock = queues_of_here(), SystemClock()
    if rig is not None:
        return QueueStore(folder_of_rig(queues, read_rig(rig).rig.name), clock)
    found = sorted(path.parent for path in queues.glob(f"*/{FILE}"))
    if len(found) != 1:
        count_text = f"there are {len(found)} queues" if found else "there is no queue"
        raise RequestError(f"queue: {count_text} in {queues}; nothing was done; give --rig with a rig file of the rig")
    return QueueStore(found[0], clock)


def _tell(queue: Queue, *, json: bool = False) -> None:
    now = SystemClock().now_utc()
    if json:
        items: Sequence[Item] = [item for item in queue.items if item.state is not ItemState.REMOVED]
        armed = queue.is_armed(boot(), now)
        sentences = {"told": armed_sentence(queue, boot(), now), "mounted": mounted_sentence(queue)}
        documents = [item_document(item) for item in items]
        print_json({"armed": armed, "sequence": queue.sequence, **sentences, "items": documents})
        return
    for line in queue_lines(queue, boot(), now):
        say(line)
