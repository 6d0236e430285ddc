"""What is not as it was when a run began: rig file, procedure file, the files that they name, software; told field by
field, and of files that are no TOML line by line.

A resume over a change is refused unless somebody answers for it with a name and a reason, which the journal keeps with
the differences. Even then the run goes on with its own plan and its own rig: of the rig file ports, the twins' control
address and interlocks are taken over, because an adapter may have been replaced and a band been too narrow, and every
other key that changed refuses the resume by its name, since the run would keep the old value. A changed comment is no
change.
"""

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from procedures.description.named_files import NamedFile, content_of
from procedures.errors import RequestError
from procedures.journal.header import RunHeader, calrig_version
from rig.description.read import read_rig
from rig.plain_text import BYTE_ORDER_MARK
from rig.toml_file import values_in

KIND = "override"
"""Of the event."""
PORT = re.compile(
    r"^rig file: (axes|readouts|environment|streams|field)\.[^.]+\.(port|resource|scanner_resource|baud_rate)$"
)
_INTERLOCKS = "rig file: interlocks."
_CONTROL = "rig file: twin.control"
_TWIN = "twin"
_OF_NO_FILE = ("software", "run folder")
_ABSENT = "absent"
_MOST_LINES = 5
"""Of a file that are shown; the others are counted."""


@dataclass(frozen=True, slots=True)
class Change:
    """One field."""

    where: str
    """Such as ``rig file: axes.pitch.speed_dps``."""
    was: object
    found: object

    def __str__(self) -> str:
        return f"{self.where}: was {_shown(self.was)}, is {_shown(self.found)}"


def changes_since(header: RunHeader) -> tuple[Change, ...]:
    """Return every difference between the header and the files and software of now. Raises: RequestError.

    A file that is gone contradicts nothing: the journal holds its text.
    """
    found = [
        *_in_file("rig file", header.rig_text, Path(header.rig_path)),
        *_in_file("procedure file", header.procedure_text, Path(header.procedure_path)),
        *chain.from_iterable(map(_in_named_file, header.named_files)),
    ]
    began, now = header.software.get("calrig"), calrig_version()
    return (*found, *([] if began == now else [Change("software: calrig", began, now)]))


def require_unchanged(
    run_dir: Path,
    changes: Sequence[Change],
    known: Iterable[str],
    *,
    is_accepted: bool,
    operator: str,
    reason: str,
    is_rehearsal: bool = False,
) -> None:
    """``known``: differences that somebody has answered for already. Raises: RequestError with every new one.

    Who accepts needs a name and a reason where no file changed as well: a device may be another one.
    """
    answered = set(known)
    new = [change for change in changes if str(change) not in answered]
    if not (new or is_accepted):
        return
    kept = [change for change in new if not may_be_answered_for(change, is_rehearsal=is_rehearsal)]
    listed = _listed(new)
    if not is_accepted:
        unless = f" (not for {', '.join(change.where for change in kept)}, which the run keeps)" if kept else ""
        raise RequestError(
            f"{run_dir}: not what the run began with; nothing was changed; put it back, begin a new run, or answer for "
            f"it: --accept-changes --operator NAME --reason TEXT (the run keeps its own plan){unless}:{listed}"
        )
    if not (operator and reason.strip()):
        raise RequestError(
            f"{run_dir}: --accept-changes needs a name and a reason: operator got {operator!r}, reason got {reason!r}; "
            f"nothing was changed; give --operator and --reason{':' if listed else ''}{listed}"
        )
    if kept:
        raise RequestError(
            f"{run_dir}: a run keeps what it began with, so these changes would be without effect; nothing was changed;"
            " put them back, or name the changed file otherwise and begin a new run with it (this run goes on without"
            f" its files, which its journal holds):{_listed(kept)}"
        )


def _listed(changes: Iterable[Change]) -> str:
    return "".join(f"\n  {change}" for change in changes)


def may_be_answered_for(change: Change, *, is_rehearsal: bool) -> bool:
    """Return whether a resume may go on over a change: it is taken over, or none of a key of a file.

    A rehearsal has no ports, and no other change makes a device of a twin or a twin of a device.
    """
    if change.where.startswith(_INTERLOCKS) or change.where.partition(":")[0].startswith(_OF_NO_FILE):
        return True
    is_address = PORT.match(change.where) is not None or change.where == _CONTROL
    is_moved = _ABSENT not in (change.was, change.found) and _TWIN not in (change.was, change.found)
    return is_address and is_moved and not is_rehearsal


def with_what_may_change(
    rig_json: str, rig_file: Path, changes: Sequence[Change], *, is_rehearsal: bool = False
) -> str:
    """Return the run's own rig at the addresses and under the interlocks of the file as it is now.

    Raises: DescriptionError.
    """
    document = json.loads(rig_json)
    if any(change.where.startswith(_INTERLOCKS) for change in changes):
        document["interlocks"] = json.loads(read_rig(rig_file).interlocks.model_dump_json())
    for change in changes:
        if change.where.startswith("rig file: ") and may_be_answered_for(change, is_rehearsal=is_rehearsal):
            *tables, key = change.where.removeprefix("rig file: ").split(".")
            if tables[0] != "interlocks":
                table = document
                for name in tables:
                    table = table[name]
                table[key] = change.found
    return json.dumps(document)


def _in_file(name: str, text: str, path: Path) -> Iterator[Change]:
    now = _text_of(path)
    if now is None or now == text:
        return
    was = dict(_flattened("", values_in(text)))
    try:
        found = dict(_flattened("", values_in(now)))
    except tomllib.TOMLDecodeError as error:
        yield Change(f"{name}: {path}", "readable", f"no TOML ({error})")
        return
    for key in dict.fromkeys((*was, *found)):
        if was.get(key, _ABSENT) != found.get(key, _ABSENT):
            yield Change(f"{name}: {key}", was.get(key, _ABSENT), found.get(key, _ABSENT))


def _in_named_file(named: NamedFile) -> Iterator[Change]:
    try:
        sha256, now = content_of(Path(named.path))
    except FileNotFoundError:
        return
    except OSError as error:
        raise RequestError(
            f"{named.path}: cannot be read: {error}; nothing was changed; resume needs to compare it"
        ) from None
    if sha256 == named.sha256:
        return
    if named.text is None or now is None:
        yield Change(f"{named.label}: sha256", named.sha256, sha256)
    elif _is_toml(named.text):
        yield from _in_file(named.label, named.text, Path(named.path))
    else:
        was, found = (text.removeprefix(BYTE_ORDER_MARK).splitlines() for text in (named.text, now))
        yield from _in_lines(named.label, was, found)


def _is_toml(text: str) -> bool:
    try:
        values_in(text)
    except tomllib.TOMLDecodeError:
        return False
    return True


def _in_lines(label: str, was: Sequence[str], found: Sequence[str]) -> Iterator[Change]:
    pairs = enumerate(zip_longest(was, found, fillvalue=_ABSENT), start=1)
    different = [(number, before, now) for number, (before, now) in pairs if before != now]
    for number, before, now in different[:_MOST_LINES]:
        yield Change(f"{label}: line {number}", before, now)
    if len(different) > _MOST_LINES:
        yield Change(f"{label}: further lines", "as the run has them", f"{len(different) - _MOST_LINES} differ")


def _flattened(prefix: str, value: Mapping[str, Any]) -> Iterator[tuple[str, object]]:
    for key, item in value.items():
        where = f"{prefix}.{key}" if prefix else key
        if isinstance(item, dict) and item:
            yield from _flattened(where, item)
        else:
            yield where, item


def _shown(value: object) -> str:
    return value if value == _ABSENT else str(json.dumps(value, ensure_ascii=False, default=str))


def _text_of(path: Path) -> str | None:
    try:
        return path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(
            f"{path}: cannot be read: {error}; nothing was changed; resume needs to compare it"
        ) from None
