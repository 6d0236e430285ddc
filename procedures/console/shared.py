"""What the pages read and the acts need, shared by all requests of one console."""

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import TypeVar

from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection

from ams.archive.refusals import without_password
from ams.errors import ArchiveError
from procedures.console.acts import Answer
from procedures.console.gate import Site, token_of
from procedures.console.live_pages import LivePages
from procedures.console.sessions import Sessions, Visitor
from procedures.console.watched_run import RunPage, WatchedRun
from procedures.journal.journal_reader import JournalReader
from procedures.journal.status.run_list import ListedRun, RunList
from procedures.journal.storage import JOURNAL_FILE
from procedures.journal.taken_away import require_not_taken_away
from rig.clock import Clock
from rig.description.read import rig_from_json
from rig.description.rig_file import RigDescription

T = TypeVar("T")
ARCHIVE_S, BESIDE_S = 15.0, 3.0
"""So long a page of the archive waits for it, and a page that only has a word of it beside other things."""
MOST_WATCHED = 8
MOST_ANSWERS = 1000
Slot = tuple[str, str, str]
"""Of an answer: the session, the path that was asked, which says the act and its run, queue or rig, and the key."""


@dataclass
class Console:
    """Of one process."""

    runs: RunList
    archive_of_now: Callable[[], str]
    """Tells the URL of the archive that the pages show: the first run that finishes may make it."""
    clock: Clock
    sessions: Sessions
    site: Site
    queues: Path
    """The folder of queues."""
    files: Path
    """The folder whose procedure and rig files can be added to a queue."""
    entered: asyncio.Event = field(default_factory=asyncio.Event)
    """Set when somebody entered: the next link can be told."""
    logging_in: asyncio.Lock = field(default_factory=asyncio.Lock)
    """One guess at a time: each takes memory and time by intention."""
    hands: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(8, "acts"))
    """For acts alone, which wait for no page that is being read."""
    stops: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(8, "stops"))
    """For what stops, from its first line on: it waits for no other act, which may wait for a check or an archive."""
    readers: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(8, "archive"))
    """For what is read in the archive, whose server may never answer: what needs none waits for none."""
    live_pages: LivePages = field(default_factory=LivePages)
    _answers: OrderedDict[Slot, asyncio.Future[Answer]] = field(default_factory=OrderedDict)
    _watched: dict[str, WatchedRun] = field(default_factory=dict)
    _watching: Lock = field(default_factory=Lock)
    _listing: Lock = field(default_factory=Lock)
    """Held while journals are verified, which takes seconds of long ones: no live page waits for it."""

    @property
    def archive_url(self) -> str:
        return self.archive_of_now()

    def visitor(self, connection: HTTPConnection) -> Visitor:
        """Return who asks; the gate has let nobody else in. Raises: HTTPException where the session ended since."""
        found = self.sessions.visitor(token_of(connection.headers, self.site))
        if found is None:
            raise HTTPException(401, "the session has ended; enter again")
        return found

    def listed(self) -> tuple[ListedRun, ...]:
        with self._listing:
            return self.runs.read()

    def folder_of(self, name: str) -> Path:
        """Return the folder of a run by its name there: no link, no other folder. Raises: HTTPException."""
        path = self.runs.folder / name
        is_plain = name not in ("", ".", "..") and not {"/", "\\", "\0"} & set(name) and not name.startswith(".")
        if not is_plain or path.is_symlink():
            raise HTTPException(404, "there is no such run")
        require_not_taken_away(path)
        if not (path / JOURNAL_FILE).is_file():
            raise HTTPException(404, "there is no such run")
        return path

    def watched(self, name: str) -> WatchedRun:
        """Return the run of a name that stands in the folder of runs. Raises: HTTPException, JournalError."""
        with self._watching:
            path = self.folder_of(name)
            if name not in self._watched:
                while len(self._watched) >= MOST_WATCHED:
                    self._watched.pop(next(iter(self._watched))).close()
                self._watched[name] = WatchedRun(path, self.clock)
            return self._watched[name]

    def page(self, name: str) -> RunPage:
        return self.watched(name).page()

    def rig_of(self, folder: Path) -> RigDescription:
        """Return the rig file that a run was begun with. Raises: JournalError."""
        with JournalReader.open(folder) as reader:
            return rig_from_json(reader.header.rig_json)

    def first(self) -> str | None:
        """Return the run that is alive, else the latest that can be read."""
        readable = [run for run in self.listed() if not run.trouble]
        return next((run.path.name for run in (*(run for run in readable if run.is_alive), *readable)), None)

    async def of_archive(self, read: Callable[[], T], within_s: float) -> T:
        """Return what is read in the archive; nobody waits for longer. Raises: ArchiveError; what ``read`` raises."""
        reading = asyncio.get_running_loop().run_in_executor(self.readers, read)
        try:
            async with asyncio.timeout(within_s):
                return await reading
        except TimeoutError:
            raise ArchiveError(
                f"{without_password(self.archive_url)}: the archive gave no answer within {within_s:g} s; nothing is "
                "shown of it; see whether its server runs, then load the page again"
            ) from None

    async def once(self, slot: Slot, do: Callable[[], Answer], *, is_stop: bool) -> Answer:
        """Do an act in a thread; a page that heard nothing asks again with the same key, and the act counts once."""
        if not self.will_repeat(slot, is_stop=is_stop):
            threads = self.stops if is_stop else self.hands
            self._answers[slot] = asyncio.get_running_loop().run_in_executor(threads, do)
            while len(self._answers) > MOST_ANSWERS:
                self._answers.popitem(last=False)
        return await asyncio.shield(self._answers[slot])

    def will_repeat(self, slot: Slot, *, is_stop: bool) -> bool:
        """Return whether this act came before, so that its answer is told again.

        ``is_stop``: that of one that is under way; whatever became of it, the next is done anew: what moves now may
        have begun since.
        """
        before = self._answers.get(slot)
        return before is not None and not (is_stop and before.done())

    def close(self) -> None:
        for threads in (self.hands, self.stops, self.readers):
            threads.shutdown(wait=False, cancel_futures=True)
        for run in self._watched.values():
            run.close()
        self._watched.clear()
