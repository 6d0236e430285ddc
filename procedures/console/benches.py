"""The benches that pages jog: each a process of its own, which keeps the leases; here its lines come and go.

Nothing here decides whether something moves. A bench hears what pages say, and stops where they, this server or the
lines between fall silent.
"""

import asyncio
import json
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from procedures.errors import ExitStatus

COMMAND = (sys.executable, "-m", "procedures.cli.main", "jog", "--served", "--rig")
LONGEST_LINE = 1 << 20
MOST_UNSENT = 65_536
"""Bytes that a bench has not taken: it hears nothing any more, and is given nothing more."""
SENTENCES = 4
Hear = Callable[[dict[str, Any]], None]


@dataclass
class Bench:
    """One rig that was opened for pages."""

    process: Process
    listeners: set[Hear]
    latest: dict[str, Any] = field(default_factory=dict)
    """What was last seen."""

    def send(self, client: str, name: str, address: str, order: dict[str, Any]) -> None:
        """Pass on what a page says; never waits."""
        line = self.process.stdin
        if line is None or line.is_closing() or line.transport.get_write_buffer_size() > MOST_UNSENT:
            return
        line.write(json.dumps({**order, "client": client, "name": name, "place": address}).encode() + b"\n")

    def has(self, client: str) -> bool:
        """Return whether a page has it, as far as was heard; the bench itself decides."""
        return str(self._holder.get("client")) == client

    @property
    def holder(self) -> str:
        """Who has it, by name."""
        return str(self._holder.get("name", ""))

    @property
    def _holder(self) -> dict[str, Any]:
        return self.latest.get("holder") or {}


@dataclass
class Benches:
    """Of one console, by rig file."""

    _open: dict[Path, Bench] = field(default_factory=dict)
    _listeners: dict[Path, set[Hear]] = field(default_factory=dict)
    _tasks: set[asyncio.Task[None]] = field(default_factory=set)
    _opening: asyncio.Lock = field(default_factory=asyncio.Lock)

    def find(self, rig: Path) -> Bench | None:
        return self._open.get(rig)

    def has(self, client: str) -> bool:
        """Return whether a page has one of them."""
        return any(bench.has(client) for bench in self._open.values())

    def listen(self, rig: Path, hear: Hear) -> None:
        """Have every line of the bench of a rig, whenever it is open."""
        self._listeners.setdefault(rig, set()).add(hear)

    def leave(self, rig: Path, hear: Hear) -> None:
        self._listeners.get(rig, set()).discard(hear)

    async def open(self, rig: Path) -> Bench:
        """Return the bench of a rig, begun where it is not open. Raises: OSError where no process can be begun."""
        async with self._opening:
            if (found := self._open.get(rig)) is not None:
                return found
            process = await asyncio.create_subprocess_exec(
                *COMMAND, str(rig), stdin=PIPE, stdout=PIPE, stderr=PIPE, limit=LONGEST_LINE, start_new_session=True
            )
            bench = self._open[rig] = Bench(process, self._listeners.setdefault(rig, set()))
        task = asyncio.create_task(self._pass_on(rig, bench))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return bench

    async def _pass_on(self, rig: Path, bench: Bench) -> None:
        """Hand every line to all who listen, and in the end why there are no more."""
        process = bench.process
        assert process.stdout is not None
        assert process.stderr is not None
        sentences = asyncio.create_task(_last_sentences(process.stderr))
        try:
            with suppress(ValueError):  # a line that is none: then it is no bench
                while line := await process.stdout.readline():
                    document = json.loads(line)
                    bench.latest = {**bench.latest, **document}
                    _tell(bench, document)
        finally:
            if process.stdin is not None:
                process.stdin.close()
            status = await process.wait()
            del self._open[rig]
            _tell(bench, {"closed": await sentences or _closed(status)})


def _closed(status: int) -> str:
    """Return what is known of the axes of a bench that ended without a word. A signal is a negative status."""
    if status == ExitStatus.DONE:
        return "the bench is closed, and every axis stands still"
    return (
        f"the bench ended by itself ({f'signal {-status}' if status < 0 else f'status {status}'}): its axes were told"
        " to stop, but nobody has seen them stand; look at the machine, then take the bench again"
    )


def _tell(bench: Bench, document: dict[str, Any]) -> None:
    for hear in list(bench.listeners):
        hear(document)


async def _last_sentences(errors: asyncio.StreamReader) -> str:
    kept: list[str] = []
    while line := await errors.readline():
        kept = [*kept, line.decode(errors="replace").strip()][-SENTENCES:]
    return " ".join(kept)
