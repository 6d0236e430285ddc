"""The world of a runner: processes of ``calrig``, locks that they inherit, journals that they write.

A started process holds a lock on a file of its item, which it was handed open: the lock is there from before the
process began until it has ended, however that ends, and also for who looks after the runner was killed.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path

import psutil

from procedures.alerts.reader import read_by_us
from procedures.description.named_files import content_of
from procedures.errors import ProcedureError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.requests.spool import ask
from procedures.journal.sidecar.owner import is_owned, owned_since
from procedures.journal.status.announced_folder import announced_folder
from procedures.journal.status.run_list import RunList
from procedures.journal.status.standing import derived_state
from procedures.queue.runner import Look
from procedures.queue.state import Attestation, Item
from procedures.queue.words import mounted_words
from procedures.records.states import ACTIVE, State
from rig import file_lock
from rig.clock import Clock
from rig.description.read import read_rig
from rig.description.rig_file import RigDescription
from rig.errors import RigError
from rig.lines.lock import STARTED_BY, owner_of

BOOT_FILE = Path("/proc/sys/kernel/random/boot_id")
COMMAND = (sys.executable, "-m", "procedures.cli.main")
BUSY_WORDS = "in use by"
_CHECK_S = 600.0
_ATTEMPTS = 10
UNFINISHED = frozenset(State) - {*ACTIVE, State.FINISHED}
"""A run that ended so needs a decision, though its process may still deliver what there is and ring."""


@dataclass
class RigWorld:
    """Of one queue's folder."""

    folder: Path
    clock: Clock
    unguarded: Callable[[RigDescription], Sequence[str]]
    """What nobody stops when a process dies: sentences, none where every axis has a guard or a watchdog."""
    archive: str | None = None
    command: Sequence[str] = COMMAND
    _children: list[subprocess.Popen[bytes]] = field(default_factory=list)
    """Of this process: asked for their end, so that none stays behind as a zombie."""

    def boot(self) -> str:
        return boot()

    def check(self, item: Item) -> Sequence[str]:
        """Return what speaks against starting: files that are others now, or what ``calrig check`` says.

        The check takes its time, so the files are looked at once more behind it.
        """
        return (
            _changed(item)
            or checked(Path(item.procedure.path), Path(item.rig.path), Path(item.out), self.command)
            or _changed(item)
        )

    def busy(self, item: Item) -> str:
        """Return who has the rig, or that an earlier process of the item has not ended yet."""
        for resource in item.resources:
            if (owner := owner_of(resource)) is not None:
                return str(owner)
        return "an earlier process of the item, which has not ended yet" if self._is_locked(item) else ""

    def start(self, item: Item, by: str) -> None:
        """Start its run; what it says goes to the item's log."""
        words = ["run", item.procedure.path, "--rig", item.rig.path, "--out", item.out, "--operator", by]
        self._spawn(item, item.starts + 1, words, read_by_us())  # what refuses it is told by the runner

    def resume(self, item: Item, by: str, reason: str) -> None:
        self._spawn(item, item.starts + 1, ["resume", item.run, "--operator", by, "--reason", reason])

    def look(self, item: Item) -> Look:
        """Return what is seen of it: the lock first, then what its process wrote before it ended."""
        self._children = [child for child in self._children if child.poll() is None]
        is_alive = self._is_locked(item)
        log = self._log(item, item.starts)
        run = Path(item.run) if item.run else announced_folder(log) or self._run_of(item)
        if run is None:
            said = _last_words(log)
            return Look(is_alive, None, was_busy=BUSY_WORDS in said, said=said)
        is_owned_now = is_owned(run)
        with JournalReader.open(run) as reader:
            written, entered = reader.state(), reader.last_event("state")
            last_utc = None if item.boot == boot() else _last_utc(reader)
        detail = {} if entered is None else entered.detail
        state = derived_state(written, is_alive=is_owned_now)
        reason, by = str(detail.get("reason", "")), str(detail.get("by", ""))
        has_ended = not is_owned_now and written in UNFINISHED and _was_owned_since_its_start(item, run)
        return Look(is_alive or is_owned_now, run, state, reason, by, has_ended, last_utc=last_utc)

    def is_stopped_by_something(self, item: Item) -> bool:
        try:
            return not self.unguarded(read_rig(Path(item.rig.path)))
        except RigError:
            return False

    def note(self, run: Path, attestation: Attestation) -> None:
        """Write it once: the key is the attestation's own."""
        text, key = f"mounted: {mounted_words(attestation.mounted)}", f"mounted {run.name}"
        try:
            ask(run, "note", attestation.by, self.clock.now_utc(), text, via="queue", key=key)
        except ProcedureError:
            return  # it has ended already: the queue's record says who attested what

    def _spawn(self, item: Item, number: int, words: Sequence[str], variables: Mapping[str, str] | None = None) -> None:
        archive = [] if self.archive is None else ["--archive", self.archive]
        with self._lock_file(item).open("a+", encoding="utf-8") as lock, self._log(item, number).open("wb") as log:
            if not file_lock.take(lock, self.clock, _ATTEMPTS):
                return  # its process lives: there is nothing to start
            try:
                child = subprocess.Popen(  # noqa: S603  this very program
                    [*self.command, *words, *archive],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    env={**(os.environ if variables is None else variables), STARTED_BY: str(self.folder.resolve())},
                    start_new_session=True,
                    pass_fds=[lock.fileno()],
                )
            except OSError as error:
                log.write(f"cannot be started: {error}\n".encode())
                return
            self._children.append(child)

    def _is_locked(self, item: Item) -> bool:
        try:
            with self._lock_file(item).open(encoding="utf-8") as file:
                return file_lock.is_held(file)
        except FileNotFoundError:
            return False

    def _lock_file(self, item: Item) -> Path:
        return self.folder / f"item-{item.number}.lock"

    def _log(self, item: Item, number: int) -> Path:
        return self.folder / f"item-{item.number}-{number}.log"

    def _run_of(self, item: Item) -> Path | None:
        """Return the run that was begun since the start from the very same files: a power cut may take the log back."""
        if item.started_utc is None:
            return None
        for run in RunList(Path(item.out)).read():
            if run.started_utc is None or run.started_utc < item.started_utc - timedelta(seconds=1):
                continue
            with JournalReader.open(run.path) as reader:
                header = reader.header
            if (header.procedure_sha256, header.rig_sha256) == (item.procedure.sha256, item.rig.sha256):
                return run.path
        return None


def _changed(item: Item) -> list[str]:
    """Return a sentence for every file of an item that is not as it was when the item was added."""
    added = {source.path: (source.path, source.sha256) for source in (item.procedure, item.rig)}
    for named in item.named_files:
        added.setdefault(named.path, (f"{named.path} ({named.named_by}: {named.key})", named.sha256))
    messages = []
    for path, (label, sha256) in added.items():
        try:
            is_as_added = content_of(Path(path))[0] == sha256
        except OSError as error:
            messages.append(f"{label}: cannot be read: {error.strerror}; put it back, or add the item again")
            continue
        if not is_as_added:
            messages.append(f"{label}: was changed since the item was added; add it again")
    return messages


def _was_owned_since_its_start(item: Item, run: Path) -> bool:
    """Whether the process that was started last has had its run: what the journal tells is of that process then."""
    owned_utc = owned_since(run)
    return owned_utc is not None and item.started_utc is not None and owned_utc >= item.started_utc


def _last_utc(reader: JournalReader) -> datetime | None:
    """Return the latest time of a journal: of its events and its dwells."""
    ended = (dwell.ended_utc for dwell in reader.dwells(with_samples=False))
    return max((*(event.utc for event in reader.events()), *ended), default=None)


def boot() -> str:
    """Return what is another after every start of this machine: the kernel's number of it; elsewhere its moment."""
    try:
        return BOOT_FILE.read_text(encoding="ascii").strip()
    except OSError:
        return f"{psutil.boot_time():.0f}"


def checked(procedure: Path, rig: Path, out: Path, command: Sequence[str] = COMMAND) -> list[str]:
    """Return what ``calrig check`` says against a run: none where it may begin."""
    words = [*command, "check", str(procedure), "--rig", str(rig), "--out", str(out), "--json"]
    try:
        done = subprocess.run(words, capture_output=True, timeout=_CHECK_S, check=False)  # noqa: S603  this very program
    except (OSError, subprocess.TimeoutExpired) as error:
        return [f"calrig check gave no answer: {error}"]
    if done.returncode == 0:
        return []
    try:
        refusals = json.loads(done.stdout)["refusals"]
    except (ValueError, KeyError, TypeError):
        refusals = []
    said = done.stderr.decode("utf-8", errors="replace").strip().splitlines()
    return [str(refusal) for refusal in refusals] or said or [f"calrig check ended with status {done.returncode}"]


def _last_words(log: Path) -> str:
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    except OSError:
        return ""
    return "; ".join(lines[-3:])


def is_possible() -> bool:
    """Return whether this system hands an open lock to a process."""
    return os.name == "posix"
