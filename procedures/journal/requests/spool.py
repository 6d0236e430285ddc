"""Requests from other processes: one small file each, renamed into place in a folder beside the journal.

The engine looks at every slice of every wait, so a look at a quiet folder is one ``stat``. Whatever is taken is
journalled before its file is removed.

Every request says in view of which state it was made: ``expects`` is the sequence number of the event of that state.
Where the run has gone to another state meanwhile the engine refuses it and says so in the journal, because who asked
did not know what he was asking. Only what makes the rig stand still (stop, abort) and a note are taken as they come.
"""

import json
import os
import platform
import re
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Literal, get_args

from ams.whole_file import FolderNotSynced, replace_file
from procedures.errors import RequestError, StorageFailed
from procedures.journal.journal_reader import JournalReader
from procedures.journal.sidecar.owner import is_owned
from procedures.journal.time_stamps import SETTLED_NS
from procedures.records.states import ACTIVE
from rig.clock import Clock, SystemClock
from rig.plain_text import LONGEST_NAME, LONGEST_TEXT, PARAGRAPHS, text_complaint

Kind = Literal["pause", "continue", "stop", "abort", "note", "ack"]
AS_THEY_COME: tuple[Kind, ...] = ("stop", "abort", "note")
"""Taken whatever the asker expects: two that make the rig stand still, and words."""
FOLDER = "requests"
_SUFFIX = ".json"
_MAX_BYTES = 65_536


@dataclass(frozen=True, slots=True)
class Request:
    """What somebody asks of a run."""

    kind: Kind
    by: str
    at_utc: str
    text: str = ""
    expects: int | None = None
    """Sequence number of the event of the state that the asker saw."""
    via: str = ""
    """By what it was asked: ``command``, ``attach``, ``console`` or a name of somebody else's program."""
    place: str = ""
    """From where: a machine or an address."""
    key: str = ""
    """Of the one act: a request that is sent again with the same key is taken once."""

    def complaint(self, state_sequence: int) -> str:
        """Say why a run that is in the state of this event does not take it; empty where it does."""
        if self.kind in AS_THEY_COME or self.expects == state_sequence:
            return ""
        if self.expects is None:
            return f"{self.kind} does not say in view of which state it was asked (expects); nothing was done"
        return (
            f"{self.kind} was asked in view of the state of event {self.expects}, the run has since gone to that of "
            f"event {state_sequence}; nothing was done; look again, then ask again"
        )

    def to_document(self) -> dict[str, object]:
        """Return what stands in its file and in the journal: fields that say nothing are left out."""
        always = ("kind", "by", "at_utc", "text")
        return {name: value for name, value in asdict(self).items() if name in always or value not in (None, "")}


@dataclass(frozen=True, slots=True)
class Taken:
    """A request with its file, or a file that is none."""

    file: str
    request: Request | None
    complaint: str = ""

    def detail(self) -> Mapping[str, object]:
        """Return what the journal keeps of it."""
        request_fields = {} if self.request is None else self.request.to_document()
        return {"file": self.file, **request_fields, **({"refused": self.complaint} if self.complaint else {})}


class Spool:
    """The folder of requests of one run."""

    def __init__(self, run_dir: Path, clock: Clock | None = None) -> None:
        self.folder = run_dir / FOLDER
        self._clock = clock or SystemClock()
        self._seen_ns = -1

    def submit(self, request: Request) -> Path:
        """Put a request where the engine will find it, whole. Raises: StorageFailed."""
        stamp = re.sub(r"[^0-9]", "", request.at_utc)[:20]
        target = self.folder / f"{stamp}-{secrets.token_hex(4)}-{request.kind}{_SUFFIX}"
        try:
            self.folder.mkdir(exist_ok=True)
            replace_file(target, json.dumps(request.to_document(), ensure_ascii=False).encode("utf-8"))
        except FolderNotSynced:
            pass  # the engine finds it there: only a power cut could take it back, and that ends the run as well
        except OSError as error:
            raise StorageFailed(
                f"{target}: cannot be written: {error.strerror}; the run was not told; check the folder and its rights"
            ) from error
        return target

    def take(self) -> list[Taken]:
        """Return the requests in the order in which they were made; :meth:`remove` each when it is journalled."""
        try:
            changed_ns = os.stat(self.folder).st_mtime_ns
        except FileNotFoundError:
            return []
        if changed_ns == self._seen_ns:
            return []
        names = sorted(name for name in os.listdir(self.folder) if name.endswith(_SUFFIX))
        age_ns = self._clock.now_utc().timestamp() * 1e9 - changed_ns
        self._seen_ns = changed_ns if age_ns > SETTLED_NS and not names else -1
        return [self._read(name) for name in names]

    def remove(self, taken: Taken) -> None:
        (self.folder / taken.file).unlink(missing_ok=True)

    def _read(self, name: str) -> Taken:
        try:
            with open(self.folder / name, "rb") as file:
                content = file.read(_MAX_BYTES + 1)
            if len(content) > _MAX_BYTES:
                raise ValueError(f"longer than {_MAX_BYTES} bytes")
            document = json.loads(content)
            if not isinstance(document, dict):
                raise ValueError("expected an object")
            expects = document.pop("expects", None)
            if expects is not None and (isinstance(expects, bool) or not isinstance(expects, int)):
                raise ValueError(f"expects: got {expects!r}, allowed is the number of an event")
            if not all(isinstance(value, str) for value in document.values()):
                raise ValueError("expected an object of texts, and expects as a number")
            if document.get("kind") not in get_args(Kind):
                raise ValueError(f"kind: got {document.get('kind')!r}, allowed {', '.join(get_args(Kind))}")
            if missing := {"by", "at_utc"} - document.keys():
                raise ValueError(f"{', '.join(sorted(missing))} is missing")
            optional = {name: document[name] for name in ("text", "via", "place", "key") if name in document}
            return Taken(
                name, Request(document["kind"], document["by"], document["at_utc"], expects=expects, **optional)
            )
        except (OSError, ValueError, RecursionError) as error:
            return Taken(name, None, f"not a request: {error}"[:300])


def words_complaint(by: str, text: str, address: str = "", kept: str = PARAGRAPHS) -> str:
    """Return what is wrong with who says something, with its text or with from where; empty where nothing is.

    ``kept``: hidden letters that the text may hold all the same; those of several lines where nothing else is said.
    """
    said = (("by", by, "", LONGEST_NAME), ("text", text, kept, LONGEST_TEXT), ("place", address, "", LONGEST_NAME))
    for name, words, allowed, longest in said:
        if complaint := text_complaint(words, allowed, longest):
            return f"{name}: {complaint}"
    return ""


def ask(
    run_dir: Path,
    kind: Kind,
    by: str,
    now: datetime,
    text: str = "",
    *,
    expects: int | None = None,
    via: str = "command",
    address: str = "",
    key: str = "",
) -> None:
    """Ask something of a run that another process runs.

    ``expects``: of the state that the asker saw; without it that of the state in which the run is now.
    Raises: RequestError where nobody would take the request, the run is in another state than the asker saw, or a text
    holds what nobody sees.
    """
    if complaint := words_complaint(by, text, address):
        raise RequestError(f"{run_dir}: {kind}: {complaint}; nothing was asked")
    with JournalReader.open(run_dir) as reader:
        state, entered = reader.state(), reader.last_event("state")
    if state not in ACTIVE or not is_owned(run_dir):
        reason = f"it is {state}" if state not in ACTIVE else "its process is gone; calrig resume continues it"
        raise RequestError(f"{run_dir}: cannot {kind}: no process runs this run: {reason}; nothing was asked")
    assert entered is not None  # it has a state
    seen = entered.sequence if expects is None else expects
    request = Request(kind, by, now.isoformat(), text, seen, via, address or platform.node(), key)
    if complaint := request.complaint(entered.sequence):
        raise RequestError(f"{run_dir}: was asked in view of another state: {complaint}; it is {state} now")
    Spool(run_dir).submit(request)
