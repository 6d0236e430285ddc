"""The form that adds a run to a queue: files of one folder by their plain names, and one addition at a time.

A browser names no path: it may choose among the procedure and rig files of the folder that the console was given. The
check of an item takes seconds of a hand that a stop could need, so a second addition is refused while one is made.
"""

from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

from starlette.requests import Request
from starlette.responses import Response

from procedures.console.acting import Acting
from procedures.console.acts import ACCEPTED, REFUSED, WRONG, Action, Answer
from procedures.console.shared import Console
from procedures.errors import ProcedureError
from procedures.kinds.read import read_procedure
from procedures.queue.adding import add_run
from procedures.queue.state import ItemState
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError
from rig.toml_file import values_in

LONGEST_FILE = 1_000_000
"""Bytes; what is longer is no file that a person wrote."""


@dataclass(frozen=True)
class Offered:
    """Names of files that can be chosen."""

    procedures: tuple[str, ...]
    rigs: tuple[str, ...]


def offered(folder: Path) -> Offered:
    """Return the procedure and rig files of a folder: plain files, no links, by the table that each must have."""
    tables = {path.name: _tables(path) for path in sorted(folder.glob("*.toml"))}
    return Offered(
        tuple(name for name, found in tables.items() if "procedure" in found),
        tuple(name for name, found in tables.items() if "rig" in found),
    )


def is_rig_file(folder: Path, name: str) -> bool:
    """Return whether a name is that of an offered rig file: of what stops, which reads no other file for it."""
    return Path(name).name == name and name.endswith(".toml") and "rig" in _tables(folder / name)


def _tables(path: Path) -> frozenset[str]:
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > LONGEST_FILE:
            return frozenset()
        return frozenset(values_in(path.read_bytes().decode("utf-8")))
    except (OSError, ValueError, RecursionError):
        return frozenset()


@dataclass
class Additions:
    """Of one console."""

    console: Console
    acting: Acting
    _busy: Lock = field(default_factory=Lock)

    async def act(self, request: Request) -> Response:
        """Add an item. It begins nothing: by another person than armed the queue, or who may not, that is disarmed."""
        return await self.acting.answer(request, "add", self._rig_of, self._perform, "/queue")

    def _rig_of(self, action: Action) -> RigDescription | None:
        """Return the rig file that is added; None where it cannot be read: then nothing is allowed by it."""
        name = action.fields.get("rig", "")
        try:
            return read_rig(self.console.files / name) if is_rig_file(self.console.files, name) else None
        except RigError:
            return None

    def _perform(self, action: Action) -> Answer:
        if not self._busy.acquire(blocking=False):
            return Answer(REFUSED, "add: another item is being checked; nothing was added; ask again in a minute")
        try:
            return self._add(action)
        finally:
            self._busy.release()

    def _add(self, action: Action) -> Answer:
        known = offered(self.console.files)
        for name, choice in (("procedure", known.procedures), ("rig", known.rigs)):
            if action.fields.get(name, "") not in choice:
                allowed = ", ".join(choice) or f"none: {self.console.files} has no such file"
                return Answer(WRONG, f"add: {name}: allowed are {allowed}; nothing was added")
        folder, times = self.console.files, action.fields
        try:
            item = add_run(
                self.console.queues,
                self.console.clock,
                read_procedure(folder / action.fields["procedure"]),
                folder / action.fields["rig"],
                self.console.runs.folder,
                action.by,
                not_before=times.get("not_before", "").strip(),
                not_after=times.get("not_after", "").strip(),
                may_arm=action.may_arm,
            )
        except (ProcedureError, RigError) as error:
            return Answer(REFUSED, f"add: {error}")
        refused = "; ".join(item.reasons) if item.state is ItemState.REFUSED else ""
        would = f"; it would be refused: {refused}" if refused else "; its check speaks against nothing"
        return Answer(ACCEPTED, f"item {item.number}: {item.title}: {item.state}{would}")
