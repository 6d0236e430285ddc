"""Requests from other processes: one small file each, renamed into place in a folder beside the journal.

The engine looks at every slice of every wait, so a look at a quiet folder is one ``stat``. Whatever is taken is
journalled before its file is removed.
"""

import json
import os
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
from procedures.journal.owner import is_owned
from procedures.records.states import ACTIVE
from rig.clock import Clock, SystemClock

Kind = Literal["pause", "continue", "stop", "abort", "note", "ack"]
FOLDER = "requests"
_SUFFIX = ".json"
_MAX_BYTES = 65_536
_SETTLED_NS = 200_000_000
"""A folder changed more recently than this is read again: two changes may share one time stamp."""


@dataclass(frozen=True, slots=True)
class Request:
    """What somebody asks of a run."""

    kind: Kind
    by: str
    at_utc: str
    text: str = ""


@dataclass(frozen=True, slots=True)
class Taken:
    """A request with its file, or a file that is none."""

    file: str
    request: Request | None
    complaint: str = ""

    def detail(self) -> Mapping[str, object]:
        """Return what the journal keeps of it."""
        request_fields = {} if self.request is None else asdict(self.request)
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
            replace_file(target, json.dumps(asdict(request), ensure_ascii=False).encode("utf-8"))
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
        self._seen_ns = changed_ns if age_ns > _SETTLED_NS and not names else -1
        return [self._read(name) for name in names]

    def remove(self, taken: Taken) -> None:
        (self.folder / taken.file).unlink(missing_ok=True)

    def _read(self, name: str) -> Taken:
        try:
            with open(self.folder / name, "rb") as file:
                content = file.read(_MAX_BYTES + 1)
            if len(content) > _MAX_BYTES:
                raise ValueError(f"longer than {_MAX_BYTES} bytes")
            return Taken(name, _request(json.loads(content)))
        except (OSError, ValueError, RecursionError) as error:
            return Taken(name, None, f"not a request: {error}"[:300])


def _request(document: object) -> Request:
    """Return a document as a request. Raises: ValueError for what is no request."""
    if not isinstance(document, dict) or not all(isinstance(value, str) for value in document.values()):
        raise ValueError("expected an object of texts")
    if document.get("kind") not in get_args(Kind):
        raise ValueError(f"kind: got {document.get('kind')!r}, allowed {', '.join(get_args(Kind))}")
    if missing := {"by", "at_utc"} - document.keys():
        raise ValueError(f"{', '.join(sorted(missing))} is missing")
    return Request(document["kind"], document["by"], document["at_utc"], document.get("text", ""))


def ask(run_dir: Path, kind: Kind, by: str, now: datetime, text: str = "") -> None:
    """Ask something of a run that another process runs. Raises: RequestError where nobody would take the request."""
    with JournalReader.open(run_dir) as reader:
        state = reader.state()
    if state not in ACTIVE or not is_owned(run_dir):
        reason = f"it is {state}" if state not in ACTIVE else "its process is gone; calrig resume continues it"
        raise RequestError(f"{run_dir}: cannot {kind}: no process runs this run: {reason}; nothing was asked")
    Spool(run_dir).submit(Request(kind, by, now.isoformat(), text))
