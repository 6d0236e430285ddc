"""What is not as it was when a run began: rig file, procedure file, software, told field by field.

A resume over a change is refused unless somebody answers for it with a name and a reason, which the journal keeps with
the differences. Even then the run goes on with its own plan and its own rig; of the rig file only ports and interlocks
are taken over, because an adapter may have been replaced and a band been too narrow. A changed comment is no change.
"""

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from procedures.errors import RequestError
from procedures.journal.header import RunHeader, calrig_version
from rig.description.read import read_rig

KIND = "override"
"""Of the event."""
PORT = re.compile(
    r"^rig file: (axes|readouts|environment|streams|field)\.[^.]+\.(port|resource|scanner_resource|baud_rate)$"
)
_INTERLOCKS = "rig file: interlocks."
_ABSENT = "absent"


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
    ]
    began, now = header.software.get("calrig"), calrig_version()
    return (*found, *([] if began == now else [Change("software: calrig", began, now)]))


def require_unchanged(
    run_dir: Path, changes: Sequence[Change], known: Iterable[str], *, is_accepted: bool, operator: str, reason: str
) -> None:
    """``known``: differences that somebody has answered for already. Raises: RequestError with every new one."""
    new = [str(change) for change in changes if str(change) not in set(known)]
    if not new:
        return
    listed = "\n  ".join(new)
    if not is_accepted:
        raise RequestError(
            f"{run_dir}: not what the run began with; nothing was changed; put it back, begin a new run, or answer for "
            f"it: --accept-changes --operator NAME --reason TEXT (the run keeps its own plan):\n  {listed}"
        )
    if not (operator and reason.strip()):
        raise RequestError(
            f"{run_dir}: --accept-changes needs a name and a reason: operator got {operator!r}, reason got {reason!r}; "
            f"nothing was changed; give --operator and --reason:\n  {listed}"
        )


def with_what_may_change(rig_json: str, rig_file: Path, changes: Sequence[Change]) -> str:
    """Return the run's own rig at the ports and under the interlocks of the file as it is now.

    Raises: DescriptionError.
    """
    document = json.loads(rig_json)
    if any(change.where.startswith(_INTERLOCKS) for change in changes):
        document["interlocks"] = json.loads(read_rig(rig_file).interlocks.model_dump_json())
    for change in changes:
        if PORT.match(change.where) and change.found != _ABSENT:
            table, name, key = change.where.removeprefix("rig file: ").split(".")
            document[table][name][key] = change.found
    return json.dumps(document)


def _in_file(name: str, text: str, path: Path) -> Iterator[Change]:
    now = _text_of(path)
    if now is None or now == text:
        return
    was = dict(_flattened("", tomllib.loads(text)))
    try:
        found = dict(_flattened("", tomllib.loads(now)))
    except tomllib.TOMLDecodeError as error:
        yield Change(f"{name}: {path}", "readable", f"no TOML ({error})")
        return
    for key in dict.fromkeys((*was, *found)):
        if was.get(key, _ABSENT) != found.get(key, _ABSENT):
            yield Change(f"{name}: {key}", was.get(key, _ABSENT), found.get(key, _ABSENT))


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
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(
            f"{path}: cannot be read: {error}; nothing was changed; resume needs to compare it"
        ) from None
