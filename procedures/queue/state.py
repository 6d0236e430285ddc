"""The queue as its events tell it. Every rule of its table stands here and in :mod:`procedures.queue.runner`.

=====================  ==================================================================================
event                  what becomes of the queue
=====================  ==================================================================================
``add``, ``move``,     the order is another; by another person than who armed it, it is disarmed
``remove``
``checked``            an item that is refused stays with its sentences, until it is removed or added again
``arm``                what waits may start, until the time that was said, and until the next cold start
``attest``             a person says what is mounted; the check set of the run verifies it by measurement. By who may
                       not arm the queue, it is disarmed, as by ``add``, ``move`` and ``remove``
``used``               somebody had the rig outside the queue: it is disarmed; after all but a jog and a stop nobody
                       has said what is mounted
``unseen``             nobody could have left word of having the rig, as on a full disk: it is disarmed
``start``, ``resume``  an item has the rig
``began``              the run of the item is known
``unbegun``            no run began: it waits again where the rig was busy, else as ``ended``
``ended``              finished: what it needed is what is mounted. Anything else disarms the queue, and the
                       item stays in front until a person decides: resume, measure again, drop
``expired``            its window is over: it is never started late
=====================  ==================================================================================
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from enum import StrEnum
from typing import Any

from procedures.description.named_files import NamedFile
from procedures.records.states import State
from rig.local_time import at_both

Detail = Mapping[str, Any]


class ItemState(StrEnum):
    """Where an item stands."""

    WAITING = "waiting"
    REFUSED = "refused"
    STARTING = "starting"
    RUNNING = "running"
    UNDECIDED = "needs a decision"
    RESUMING = "to be resumed"
    FINISHED = "finished"
    EXPIRED = "expired"
    DROPPED = "dropped"
    REMOVED = "removed"


AT_WORK = (ItemState.STARTING, ItemState.RUNNING)
"""It has the rig."""
LETS_START: Mapping[str, str] = {
    "add": "added to",
    "move": "reordered",
    "remove": "taken an item out of",
    "attest": "said what is mounted for",
}
"""What people do that begins nothing, and lets an armed queue begin what it would not have begun, or not so soon; each
as it is told. Arming and deciding are the other two, and need the right to."""
OVER = (ItemState.FINISHED, ItemState.EXPIRED, ItemState.DROPPED, ItemState.REMOVED)


@dataclass(frozen=True, slots=True)
class Event:
    """One line of the queue's record."""

    sequence: int
    utc: datetime
    kind: str
    detail: Detail


@dataclass(frozen=True, slots=True)
class Source:
    """A file as it was when the item was added."""

    path: str
    text: str
    sha256: str


@dataclass(frozen=True, slots=True)
class Item:
    """One run that is to be."""

    number: int
    title: str
    procedure: Source
    rig: Source
    named_files: tuple[NamedFile, ...]
    """What the two files name; none of an item that was added before they were kept."""
    out: str
    needs: Mapping[str, str]
    """Sensors that must be mounted, each with its datum face, empty where the rig file names none."""
    added_by: str
    not_before_utc: datetime | None
    not_after_utc: datetime | None
    resumes_after_power_cut: bool
    ports: tuple[str, ...] = ()
    """Of the rig, as they were when it was added."""
    state: ItemState = ItemState.WAITING
    reasons: tuple[str, ...] = ()
    """Why it is refused, or what ended it."""
    run: str = ""
    """The folder of its run, once that is known."""
    boot: str = ""
    """Of the start of the machine in which it was started last."""
    started_utc: datetime | None = None
    starts: int = 0
    resumed_itself: int = 0
    """Times after a cold start; once at most."""
    reason: str = ""
    """Of the person who decided that it is to be resumed."""
    decided_by: str = ""

    @property
    def resources(self) -> tuple[str, ...]:
        """What its run locks: the rig file, and the ports of the rig."""
        return (self.rig.path, *self.ports)

    def is_late(self, now_utc: datetime) -> bool:
        return self.not_after_utc is not None and now_utc > self.not_after_utc

    def is_early(self, now_utc: datetime) -> bool:
        return self.not_before_utc is not None and now_utc < self.not_before_utc


@dataclass(frozen=True, slots=True)
class Arming:
    """A named act: what will run until when."""

    by: str
    until_utc: datetime
    boot: str


@dataclass(frozen=True, slots=True)
class Attestation:
    """What a person says is mounted, or what a finished run has shown."""

    by: str
    mounted: Mapping[str, str]
    said_utc: datetime


@dataclass(frozen=True, slots=True)
class Queue:
    """Where everything stands."""

    sequence: int = 0
    items: tuple[Item, ...] = ()
    """In the order in which they are to run; those that are over stand where they stood."""
    arming: Arming | None = None
    disarmed_because: str = "nobody has armed it"
    attestation: Attestation | None = None
    unsaid_because: str = "nobody has said what is mounted"
    uses: frozenset[str] = frozenset()
    """The marks of every use of the rig from outside that is on record here."""
    numbers: int = 0
    """The highest number that an item has had."""
    events: tuple[Event, ...] = field(default=(), repr=False)

    def is_armed(self, boot: str, now_utc: datetime) -> bool:
        """Return whether anything may start: armed since this start of the machine, and not beyond what was said."""
        return self.arming is not None and self.arming.boot == boot and now_utc <= self.arming.until_utc

    def why_not_armed(self, boot: str, now_utc: datetime) -> str:
        """Return why nothing may start; empty where something may."""
        if self.arming is None:
            return self.disarmed_because
        if self.arming.boot != boot:
            return "the machine was started anew since"
        return f"{self.arming.by} armed it until {at_both(self.arming.until_utc)}" * (now_utc > self.arming.until_utc)

    def last_line_utc(self) -> datetime | None:
        """Return the time of the latest line since it was armed last: a clock that is right is not before it."""
        since = next((n for n in range(len(self.events) - 1, -1, -1) if self.events[n].kind == "arm"), 0)
        return max((event.utc for event in self.events[since:]), default=None)

    def item(self, number: int) -> Item | None:
        return next((item for item in self.items if item.number == number), None)

    def in_state(self, *states: ItemState) -> tuple[Item, ...]:
        return tuple(item for item in self.items if item.state in states)

    def is_mounted(self, item: Item) -> bool:
        """Return whether what the item needs is what is said to be mounted."""
        return self.attestation is not None and dict(self.attestation.mounted) == dict(item.needs)


def folded(events: Iterable[Event], queue: Queue | None = None) -> Queue:
    """Return the queue after these events."""
    found = queue or Queue()
    for event in events:
        after = _disarmed_by_others(_after(found, event), event)
        found = replace(after, sequence=event.sequence, events=(*found.events, event))
    return found


def _disarmed_by_others(queue: Queue, event: Event) -> Queue:
    """Disarm where somebody has let something start who may not, or who has changed what another person armed.

    Who may arm it and says what is mounted has said what it was armed to wait for.
    """
    if queue.arming is None or event.kind not in LETS_START:
        return queue
    by = str(event.detail["by"])
    how = f"{by} has {LETS_START[event.kind]} what {queue.arming.by} armed"
    if not event.detail.get("may_arm", True):
        return _disarmed(queue, f"{how}, by a role or from a place that may not arm it")
    if event.kind != "attest" and queue.arming.by != by:
        return _disarmed(queue, how)
    return queue


def _after(queue: Queue, event: Event) -> Queue:
    detail = event.detail
    match event.kind:
        case "add":
            item = _item(detail)
            known = queue.uses.union(detail.get("uses", ()))
            return replace(queue, items=(*queue.items, item), numbers=item.number, uses=known)
        case "move":
            return _moved(queue, int(detail["item"]), int(detail["to"]))
        case "remove":
            return _with(queue, detail, state=ItemState.REMOVED)
        case "checked":
            refused = tuple(map(str, detail["refused"]))
            return _with(queue, detail, state=ItemState.REFUSED if refused else ItemState.WAITING, reasons=refused)
        case "arm":
            until = datetime.fromisoformat(str(detail["until_utc"]))
            return replace(queue, arming=Arming(str(detail["by"]), until, str(detail["boot"])), disarmed_because="")
        case "disarm":
            return _disarmed(queue, str(detail["reason"]))
        case "attest":
            return replace(queue, attestation=Attestation(str(detail["by"]), dict(detail["mounted"]), event.utc))
        case "used":
            return _used(queue, detail)
        case "unseen":
            return _disarmed(queue, str(detail["why"]))
        case "start" | "resume":
            return _started(queue, event)
        case "began":
            return _with(queue, detail, state=ItemState.RUNNING, run=str(detail["run"]))
        case "unbegun" if detail["busy"]:
            return _with(queue, detail, state=ItemState.WAITING, reasons=(str(detail["reason"]),))
        case "unbegun":
            reason = str(detail["reason"])
            return _disarmed(_with(queue, detail, state=ItemState.UNDECIDED, reasons=(reason,)), reason)
        case "ended":
            return _ended(queue, detail, event.utc)
        case "expired":
            return _with(queue, detail, state=ItemState.EXPIRED, reasons=("its window was over before it could start",))
        case "decide":
            return _decided(queue, detail)
    return queue


def _item(detail: Detail) -> Item:
    refused = tuple(map(str, detail["refused"]))
    return Item(
        number=int(detail["item"]),
        title=str(detail["title"]),
        procedure=Source(**detail["procedure"]),
        rig=Source(**detail["rig"]),
        named_files=tuple(NamedFile(**named) for named in detail.get("named_files", ())),
        out=str(detail["out"]),
        needs=dict(detail["needs"]),
        added_by=str(detail["by"]),
        not_before_utc=_moment(detail["not_before_utc"]),
        not_after_utc=_moment(detail["not_after_utc"]),
        resumes_after_power_cut=bool(detail["resumes_after_power_cut"]),
        ports=tuple(detail.get("ports", ())),
        state=ItemState.REFUSED if refused else ItemState.WAITING,
        reasons=refused,
    )


def _moment(text: object) -> datetime | None:
    return None if text is None else datetime.fromisoformat(str(text))


def _with(queue: Queue, detail: Detail, **changed: Any) -> Queue:
    number = int(detail["item"])
    return replace(
        queue, items=tuple(replace(item, **changed) if item.number == number else item for item in queue.items)
    )


def _disarmed(queue: Queue, reason: str) -> Queue:
    return replace(queue, arming=None, disarmed_because=reason)


def _used(queue: Queue, detail: Detail) -> Queue:
    queue = replace(queue, uses=queue.uses.union(detail["marks"]))
    if queue.arming is not None:
        queue = _disarmed(queue, f"the rig was used outside the queue, by {detail['who']}")
    if queue.attestation is None or not detail["may_be_remounted"]:
        return queue
    said = queue.attestation
    before = f"what {said.by} said at {at_both(said.said_utc)} is from before that"
    return replace(
        queue,
        attestation=None,
        unsaid_because=f"{detail['who']} has had the rig, with what nobody has said; {before}",
    )


def _moved(queue: Queue, number: int, to: int) -> Queue:
    others = [item for item in queue.items if item.number != number]
    (moved,) = [item for item in queue.items if item.number == number]
    index = next((n for n, other in enumerate(others) if other.number == to), len(others))
    return replace(queue, items=(*others[:index], moved, *others[index:]))


def _started(queue: Queue, event: Event) -> Queue:
    item = queue.item(int(event.detail["item"]))
    assert item is not None
    by_itself = int(bool(event.detail.get("by_itself", False)))
    return _with(
        queue,
        event.detail,
        state=ItemState.STARTING,
        reasons=(),
        boot=str(event.detail["boot"]),
        started_utc=event.utc,
        starts=item.starts + 1,
        resumed_itself=item.resumed_itself + by_itself,
    )


def _ended(queue: Queue, detail: Detail, utc: datetime) -> Queue:
    item = queue.item(int(detail["item"]))
    assert item is not None
    if detail["state"] == State.FINISHED:
        found = _with(queue, detail, state=ItemState.FINISHED, reasons=())
        said, began = queue.attestation, item.started_utc
        if said is not None and began is not None and said.said_utc >= began:
            return found  # somebody has said since what is mounted: that is newer than what the run has shown
        return replace(found, attestation=Attestation("the run that finished", item.needs, utc))
    message = f"{detail['state']}{f': {reason}' if (reason := detail['reason']) else ''}"
    return _disarmed(
        _with(queue, detail, state=ItemState.UNDECIDED, reasons=(message,)), f"item {item.number}: {message}"
    )


def _decided(queue: Queue, detail: Detail) -> Queue:
    by, reason = str(detail["by"]), str(detail["reason"])
    match detail["choice"]:
        case "resume":
            return _with(queue, detail, state=ItemState.RESUMING, reason=reason, decided_by=by)
        case "again":
            return _with(queue, detail, state=ItemState.WAITING, run="", reasons=(), resumed_itself=0)
    return _with(queue, detail, state=ItemState.DROPPED, reasons=(reason,))
