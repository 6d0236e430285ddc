"""The queues as their page shows them, and what is said to them there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path

from anyio.to_thread import run_sync
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from procedures.console.acting import Acting, new_key
from procedures.console.acts import ACCEPTED, REFUSED, WRONG, Action, Answer, whole_number
from procedures.console.additions import offered
from procedures.console.rights import Act
from procedures.console.shared import Console
from procedures.console.templates_of import Pages
from procedures.errors import ProcedureError, RequestError
from procedures.queue import people
from procedures.queue.hands import heed
from procedures.queue.moments import moment
from procedures.queue.state import Item, ItemState, Queue
from procedures.queue.store import FILE, QueueStore
from procedures.queue.words import (
    armed_sentence,
    awaited_sentence,
    disarming_sentence,
    item_document,
    mounted_sentence,
    mounted_words,
)
from procedures.queue.world import boot
from rig.clock import Clock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError

ACTS: tuple[Act, ...] = ("arm", "disarm", "move", "remove", "attest", "decide")
GONE = (ItemState.REMOVED, ItemState.DROPPED)


@dataclass(frozen=True)
class ShownQueue:
    """One queue."""

    name: str
    queue: Queue
    is_armed: bool
    armed: str
    mounted: str
    needed: str
    """What the next item needs, as it is typed: ``SN1047="face A" SN1052``."""
    items: tuple[Item, ...]
    trouble: str = ""
    awaited: str = ""
    """Which attestation the next item waits for; empty where it waits for none."""


def shown_queues(folder: Path, clock: Clock) -> list[ShownQueue]:
    """Return every queue of the folder, one that cannot be read with its sentence."""
    return [_shown(path.parent, clock) for path in sorted(folder.glob(f"*/{FILE}"))]


def _shown(folder: Path, clock: Clock) -> ShownQueue:
    try:
        queue = heed(QueueStore(folder, clock))
    except ProcedureError as error:
        return ShownQueue(folder.name, Queue(), False, "", "", "", (), str(error))
    now = clock.now_utc()
    waiting = queue.in_state(ItemState.WAITING)
    needs = waiting[0].needs if waiting else {}
    return ShownQueue(
        folder.name,
        queue,
        queue.is_armed(boot(), now),
        armed_sentence(queue, boot(), now),
        mounted_sentence(queue),
        people.typed_words(needs),
        tuple(item for item in queue.items if item.state not in GONE),
        awaited=awaited_sentence(queue, waiting[0]) if waiting else "",
    )


def undecided_items(folder: Path, clock: Clock) -> Mapping[Path, int]:
    """Return the number of each item whose run waits for a decision, by the run's folder."""
    return {
        Path(item.run).resolve(): item.number
        for shown in shown_queues(folder, clock)
        for item in shown.items
        if item.state is ItemState.UNDECIDED and item.run
    }


class QueuePages:
    """One method a route."""

    def __init__(self, console: Console, pages: Pages, acting: Acting) -> None:
        self._console = console
        self._pages = pages
        self._acting = acting

    async def page(self, request: Request) -> Response:
        queues = await run_sync(shown_queues, self._console.queues, self._console.clock)
        files = await run_sync(offered, self._console.files)
        visitor, is_elsewhere = self._console.visitor(request), self._console.site.is_elsewhere(request.scope)
        return self._pages.shown(
            "queue.html.j2",
            here="queue",
            queues=queues,
            visitor=visitor,
            key=new_key(),
            words=mounted_words,
            files=files,
            folder=self._console.files,
            runs=self._console.runs.folder,
            disarms=visitor.role != "move" or (is_elsewhere and not visitor.may_move),
        )

    async def api(self, request: Request) -> Response:
        queues = await run_sync(shown_queues, self._console.queues, self._console.clock)
        documents = [
            {
                "queue": queue.name,
                "sequence": queue.queue.sequence,
                "armed": queue.is_armed,
                "told": queue.armed,
                "mounted": queue.mounted,
                "items": [item_document(item) for item in queue.items],
                "trouble": queue.trouble or None,
            }
            for queue in queues
        ]
        return JSONResponse({"queues": documents})

    async def act(self, request: Request) -> Response:
        """Arm, disarm, move, remove, attest or decide."""
        act = next((known for known in ACTS if known == request.path_params["act"]), None)
        name = request.path_params["name"]
        folder = next(
            (path.parent for path in self._console.queues.glob(f"*/{FILE}") if path.parent.name == name), None
        )
        if act is None or folder is None or folder.is_symlink():
            raise HTTPException(404, "there is no such queue, or no such act")
        store = QueueStore(folder, self._console.clock)
        do: Callable[[Action], Answer] = partial(_perform, store, self._console.clock)
        return await self._acting.answer(request, act, partial(_rig_of, store), do, "/queue")


def _rig_of(store: QueueStore, _action: Action) -> RigDescription | None:
    """Return which rig file of what could run allows least; None where one cannot be read: then nothing is allowed."""
    items = store.read().in_state(ItemState.RESUMING, ItemState.UNDECIDED, ItemState.WAITING)
    try:
        rigs = [read_rig(Path(path)) for path in sorted({item.rig.path for item in items})]
    except RigError:
        return None
    return min(rigs, key=lambda rig: rig.console.motion_from_elsewhere, default=None)


def _perform(store: QueueStore, clock: Clock, action: Action) -> Answer:
    try:
        if action.act != "disarm" and action.expects is None:
            raise RequestError(
                f"{action.act} does not say in view of which queue it was asked (expects); nothing was changed; "
                "look again, then ask again"
            )
        queue = _say(store, action, clock.now_utc())
    except ProcedureError as error:
        return Answer(REFUSED, str(error))
    except (KeyError, TypeError):
        return Answer(WRONG, f"{action.act}: something that it needs is missing; nothing was changed")
    return Answer(ACCEPTED, "; ".join(filter(None, (f"{action.act}: done", disarming_sentence(queue)))))


def _say(store: QueueStore, action: Action, now_utc: datetime) -> Queue:
    number, seen, may_arm = action.number or 0, action.expects, action.may_arm
    match action.act:
        case "arm":
            until_utc = moment(action.fields["until"], "until", now_utc)
            return people.arm(store, action.by, until_utc, boot(), now_utc, expects=seen)
        case "move":
            to = whole_number(action.act, "to", action.fields) or 0
            return people.move(store, number, to, action.by, may_arm=may_arm, expects=seen)
        case "remove":
            return people.remove(store, number, action.by, may_arm=may_arm, expects=seen)
        case "attest":
            mounted = people.mounted_in(people.words_typed(action.fields["mounted"]))
            return people.attest(store, action.by, mounted, may_arm=may_arm, expects=seen)
        case "decide":
            return people.decide(store, number, action.fields["choice"], action.text, action.by, expects=seen)
    return people.disarm(store, action.by)  # taken as it comes
