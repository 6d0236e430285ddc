"""A conversation on a line, kept as text and played back.

One JSON object a line: a header, then every write, read and discard in order, bytes as Latin-1 text. A recorder
wraps any stream. A player is a stream that answers as recorded and refuses, with the line number, as soon as the
driver says something else: a device's behaviour can be shown and tested without the device.
"""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rig.clock import Clock
from rig.errors import DescriptionError, DeviceNonsense, LinkClosed
from rig.link.byte_stream import ByteStream

VERSION = 1

Operation = Literal["write", "read", "discard"]


@dataclass(frozen=True, slots=True)
class Entry:
    """One step of a conversation; a ``read`` without data is a deadline that passed in silence."""

    line: int
    at_s: float
    operation: Operation
    data: bytes


class Recorder:
    """A stream that hands every step, as a line of text without its end, to ``keep``."""

    def __init__(self, stream: ByteStream, keep: Callable[[str], object]) -> None:
        self.name = stream.name
        self.clock = stream.clock
        self._stream = stream
        self._keep = keep
        keep(json.dumps({"transcript": VERSION, "port": stream.name}))

    def write(self, data: bytes) -> None:
        self._note("write", data)
        self._stream.write(data)

    def read(self, deadline_s: float) -> bytes:
        data = self._stream.read(deadline_s)
        self._note("read", data)
        return data

    def discard_input(self) -> bytes:
        if data := self._stream.discard_input():
            self._note("discard", data)
        return data

    def close(self) -> None:
        self._stream.close()

    def _note(self, operation: Operation, data: bytes) -> None:
        at_s = round(self.clock.monotonic_s(), 6)
        self._keep(json.dumps({"at_s": at_s, "operation": operation, "data": data.decode("latin-1")}))


class Player:
    """A stream that answers as recorded. Silence lasts until the deadline; recorded times are not waited for."""

    def __init__(self, entries: Iterable[Entry], clock: Clock, name: str) -> None:
        self.name = name
        self.clock = clock
        self._entries = list(entries)
        self._position = 0
        self._is_closed = False

    def write(self, data: bytes) -> None:
        entry = self._next("write", data)
        if entry.data != data:
            raise self._departure(entry, f"writes {data!r}")

    def read(self, deadline_s: float) -> bytes:
        data = self._next("read", b"").data
        if not data:
            self.clock.sleep(deadline_s - self.clock.monotonic_s())
        return data

    def discard_input(self) -> bytes:
        self._require_open()
        if self.is_finished or self._entries[self._position].operation != "discard":
            return b""
        return self._next("discard", b"").data

    def close(self) -> None:
        self._is_closed = True

    @property
    def is_finished(self) -> bool:
        """Whether the whole conversation took place."""
        return self._position == len(self._entries)

    def _next(self, operation: Operation, data: bytes) -> Entry:
        self._require_open()
        if self.is_finished:
            raise DeviceNonsense(
                f"{self.name}: the transcript ends after {self._position} steps, but the driver goes on with"
                f" {operation} {data!r}; record a longer one"
            )
        entry = self._entries[self._position]
        if entry.operation != operation:
            raise self._departure(entry, f"goes on with {operation} {data!r}")
        self._position += 1
        return entry

    def _departure(self, entry: Entry, what: str) -> DeviceNonsense:
        return DeviceNonsense(
            f"{self.name}: transcript line {entry.line}: the conversation departs: the driver {what},"
            f" recorded was {entry.operation} {entry.data!r}; record again or find what changed in the driver"
        )

    def _require_open(self) -> None:
        if self._is_closed:
            raise LinkClosed(f"{self.name}: used after it was closed; nothing was sent; open it again")


def read_transcript(path: Path) -> list[Entry]:
    """Read the steps kept in a file. Raises: DescriptionError with file and line."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: no transcript can be read: {error}; check the path") from error
    if not lines or _object(path, 1, lines[0]).get("transcript") != VERSION:
        raise DescriptionError(f"{path}:1: not a transcript of version {VERSION}; record one with this version")
    return [_entry(path, number, text) for number, text in enumerate(lines[1:], start=2)]


def _entry(path: Path, number: int, text: str) -> Entry:
    fields = _object(path, number, text)
    at_s, operation, data = fields.get("at_s"), fields.get("operation"), fields.get("data")
    if isinstance(at_s, int | float) and isinstance(data, str) and all(ord(character) < 256 for character in data):
        for known in ("write", "read", "discard"):
            if operation == known:
                return Entry(number, float(at_s), known, data.encode("latin-1"))
    raise DescriptionError(
        f"{path}:{number}: not a step of a transcript (allowed: at_s, operation, data); got {text!r}"
    )


def _object(path: Path, number: int, text: str) -> dict[str, object]:
    try:
        fields = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DescriptionError(f"{path}:{number}: not JSON: {error}; the file is damaged or no transcript") from error
    return fields if isinstance(fields, dict) else {}
