"""What people say to the queue: each act is refused with a sentence, or is one event with a name.

``expects`` of an act is the sequence of the queue in view of which it was asked: it is refused for any other.
``may_arm`` says whether who asks may arm the queue: by who may not, whatever lets something start disarms it.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from shlex import shlex
from typing import Literal, get_args

from procedures.description.named_files import NamedFile
from procedures.errors import ProcedureError, RequestError
from procedures.journal.requests.corrections import acknowledge, is_acknowledged
from procedures.queue.hands import heed, in_use_by, past_marks_of, require_uses_to_be_seen
from procedures.queue.state import OVER, Item, ItemState, Queue, Source
from procedures.queue.store import Change, QueueStore
from rig.assembly.open_rig import real_ports
from rig.description.rig_file import RigDescription
from rig.local_time import at_both
from rig.plain_text import LONGEST_NAME, one_line, text_complaint

Choice = Literal["resume", "again", "drop"]
Check = Callable[[Path, Path, Path], Sequence[str]]
"""Procedure, rig file and folder of runs to what speaks against starting; empty where nothing does."""
MOVABLE = (ItemState.WAITING, ItemState.REFUSED)
REMOVABLE = (ItemState.WAITING, ItemState.REFUSED, ItemState.RESUMING)


def source_of(path: Path) -> Source:
    """Return a file as it is now. Raises: RequestError."""
    try:
        content = path.read_bytes()
        return Source(str(path.resolve()), content.decode("utf-8"), hashlib.sha256(content).hexdigest())
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(f"{path}: cannot be read: {error}; nothing was added") from error


def needs_of(rig: RigDescription) -> dict[str, str]:
    """Return the sensors that must be mounted, each with its datum face; a check sensor stays where it is."""
    return {name: sensor.mount.datum for name, sensor in rig.sensors.items() if not sensor.check_sensor}


def add(
    store: QueueStore,
    procedure: Path,
    rig_file: Path,
    rig: RigDescription,
    out: Path,
    by: str,
    *,
    title: str,
    named_files: Sequence[NamedFile],
    not_before_utc: datetime | None,
    not_after_utc: datetime | None,
    refused: Sequence[str],
    may_arm: bool = True,
) -> Item:
    """Add an item at the end, with what its check said; ``named_files``: of procedure and rig. Raises: RequestError."""
    _require_name("add", by)
    if not_before_utc is not None and not_after_utc is not None and not_before_utc >= not_after_utc:
        raise RequestError("queue add: --not-before is not before --not-after; nothing was added")
    ports = real_ports(rig)
    resources = [str(rig_file.resolve()), *ports]
    sources = {"procedure": asdict(source_of(procedure)), "rig": asdict(source_of(rig_file))}

    def decide(queue: Queue) -> Change:
        return "add", {
            "item": queue.numbers + 1,
            "by": by,
            "may_arm": may_arm,
            "title": title,
            **sources,
            "named_files": [asdict(named) for named in named_files],
            "out": str(out.resolve()),
            "needs": needs_of(rig),
            "not_before_utc": _text(not_before_utc),
            "not_after_utc": _text(not_after_utc),
            "resumes_after_power_cut": rig.rig.resume_after_power_cut,
            "ports": ports,
            "uses": past_marks_of(store.folder, resources),
            "refused": list(refused),
        }

    return store.change(decide).items[-1]


def move(
    store: QueueStore, number: int, to: int, by: str, *, may_arm: bool = True, expects: int | None = None
) -> Queue:
    """Put an item before another, or at the end (``to`` 0). Raises: RequestError."""
    _require_name("move", by)

    def decide(queue: Queue) -> Change:
        _require(queue, number, MOVABLE, "move")
        if to != 0 and (to == number or queue.item(to) is None):
            raise RequestError(
                f"queue move: there is no other item {to} to put item {number} before; nothing was changed; "
                "calrig queue list"
            )
        return "move", {"item": number, "to": to, "by": by, "may_arm": may_arm}

    return store.change(_in_view("move", expects, decide))


def remove(store: QueueStore, number: int, by: str, *, may_arm: bool = True, expects: int | None = None) -> Queue:
    """Take an item out that has not begun. Raises: RequestError."""
    _require_name("remove", by)

    def decide(queue: Queue) -> Change:
        _require(queue, number, REMOVABLE, "remove")
        return "remove", {"item": number, "by": by, "may_arm": may_arm}

    return store.change(_in_view("remove", expects, decide))


def arm(
    store: QueueStore, by: str, until_utc: datetime, boot: str, now_utc: datetime, *, expects: int | None = None
) -> Queue:
    """Let what waits start until a time. Raises: RequestError."""
    _require_name("arm", by)
    if until_utc <= now_utc:
        raise RequestError(f"queue arm: got a time that is over ({at_both(until_utc)}); nothing was armed")

    def decide(queue: Queue) -> Change:
        if owner := in_use_by(store.folder, queue):
            raise RequestError(
                f"queue arm: the rig is in use by {owner}; nothing was armed; what is armed is meant for the rig as it "
                "stands: when that has ended look at the rig, then arm"
            )
        if undecided := queue.in_state(ItemState.UNDECIDED):
            raise RequestError(
                f"queue arm: item {undecided[0].number} needs a decision first ({'; '.join(undecided[0].reasons)}); "
                "nothing was armed; calrig queue decide"
            )
        waiting = [item.number for item in queue.items if item.state not in (*OVER, ItemState.REFUSED)]
        if not waiting:
            raise RequestError("queue arm: nothing waits; nothing was armed; calrig queue add")
        return "arm", {"by": by, "until_utc": until_utc.isoformat(), "boot": boot, "items": waiting}

    require_uses_to_be_seen()
    heed(store)
    return store.change(_in_view("arm", expects, decide))


def disarm(store: QueueStore, by: str) -> Queue:
    """Let nothing more start; what runs goes on. Raises: RequestError."""
    _require_name("disarm", by)
    return store.change(lambda _queue: ("disarm", {"by": by, "reason": f"{by} disarmed it"}))


def mounted_in(words: Iterable[str]) -> dict[str, str]:
    """Return what a person says is mounted, sensor to datum face, from words such as SN1047 and SN1047=A.

    Raises: RequestError for a word without a sensor or with what nobody sees, and for a sensor that is named twice.
    """
    mounted: dict[str, str] = {}
    for word in words:
        name, datum = (part.strip() for part in word.partition("=")[::2])
        complaint = text_complaint(word, longest=LONGEST_NAME) or (
            "" if name else "names no sensor; write SN1047 or SN1047=A"
        )
        if complaint or name in mounted:
            complaint = complaint or "names a sensor a second time; name each once"
            raise RequestError(f"queue attest: {one_line(word)[:80]}: {complaint}; nothing was attested")
        mounted[name] = datum
    return mounted


def typed_words(mounted: Mapping[str, str]) -> str:
    """Return sensors with their datum faces as they are typed into one line: ``SN1047="face A" SN1052``."""
    return " ".join(_marked(name) + (f"={_marked(datum)}" if datum else "") for name, datum in mounted.items())


def _marked(word: str) -> str:
    """Return a word in quotation marks where a line would part it."""
    if not any(character.isspace() or character in ',"\\' for character in word):
        return word
    return '"' + word.replace("\\", "\\\\").replace('"', '\\"') + '"'


def words_typed(line: str) -> list[str]:
    """Return the words of a line, apart by spaces or commas, what stands in quotation marks in one.

    Raises: RequestError for a quotation mark without a second.
    """
    words = shlex(line, posix=True)
    words.whitespace += ","
    words.whitespace_split, words.commenters, words.quotes = True, "", '"'
    try:
        return list(words)
    except ValueError:
        raise RequestError(
            f"queue attest: {one_line(line)[:80]}: a quotation mark lacks its second; nothing was attested; write "
            'SN1047="face A"'
        ) from None


def attest(
    store: QueueStore, by: str, mounted: Mapping[str, str], *, may_arm: bool = True, expects: int | None = None
) -> Queue:
    """Say what is mounted: sensor to datum face. Raises: RequestError."""
    _require_name("attest", by)
    if not mounted:
        raise RequestError("queue attest: needed is what is mounted, such as SN1047 or SN1047=A; nothing was attested")
    heed(store)
    said = {"by": by, "mounted": dict(mounted), "may_arm": may_arm}
    return store.change(_in_view("attest", expects, lambda _queue: ("attest", said)))


def decide(store: QueueStore, number: int, choice: str, reason: str, by: str, *, expects: int | None = None) -> Queue:
    """Say what becomes of an item that was not finished; then somebody knows of its alarm. Raises: RequestError."""
    _require_name("decide", by)
    if choice not in get_args(Choice):
        raise RequestError(f"queue decide: got {choice!r}, allowed are {', '.join(get_args(Choice))}")
    if not reason.strip():
        raise RequestError("queue decide: needs a reason; nothing was decided; give --reason")

    run = ""

    def decided(queue: Queue) -> Change:
        nonlocal run
        item = _require(queue, number, (ItemState.UNDECIDED,), "decide")
        if choice == "resume" and not item.run:
            raise RequestError(f"queue decide: item {number} has no run that could be resumed; take again, or drop")
        run = item.run
        return "decide", {"item": number, "choice": choice, "reason": reason, "by": by}

    queue = store.change(_in_view("decide", expects, decided))
    if run:
        _end_alarm(Path(run), by, f"decided in the queue: {choice}, {reason}")
    return queue


def _in_view(act: str, expects: int | None, decide: Callable[[Queue], Change]) -> Callable[[Queue], Change]:
    """Return what refuses an act that was asked in view of another queue than the one that it would change."""

    def seen(queue: Queue) -> Change:
        if expects is not None and expects != queue.sequence:
            raise RequestError(
                f"{act} was asked in view of another queue (expects {expects}, it is {queue.sequence}); "
                "nothing was changed; look again, then ask again"
            )
        return decide(queue)

    return seen


def _end_alarm(run: Path, by: str, text: str) -> None:
    """Acknowledge how a run ended: whoever decides what becomes of it knows.

    Where its journal takes nothing its process tells people until others were told, and the queue waits and says so.
    """
    with suppress(ProcedureError):
        if not is_acknowledged(run):
            acknowledge(run, by, text, via="queue")


def _require(queue: Queue, number: int, states: Sequence[ItemState], act: str) -> Item:
    item = queue.item(number)
    if item is None:
        raise RequestError(f"queue {act}: there is no item {number}; nothing was changed; calrig queue list")
    if item.state not in states:
        raise RequestError(
            f"queue {act}: item {number} is {item.state}, needed is {' or '.join(states)}; nothing was changed"
        )
    return item


def _require_name(act: str, by: str) -> None:
    if not by.strip():
        raise RequestError(f"queue {act}: needs a name; nothing was changed; give --operator")


def _text(moment: datetime | None) -> str | None:
    return None if moment is None else moment.isoformat()
