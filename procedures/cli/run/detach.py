"""``--detach`` of ``run`` and ``resume``: the same command in a process of its own, without a terminal.

The shell comes back, and what it would have said goes to a file in the run's folder. It is waited for until the run is
in the hands of that process, by its journal: a refusal is told here, and who asks for its state next is told that of
the run that goes on.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import count
from pathlib import Path

from procedures.alerts.reader import is_read, read_by_us
from procedures.cli.output import note, print_json, say
from procedures.errors import ExitStatus, RequestError
from procedures.journal.journal_reader import JournalReader
from procedures.journal.status.announced_folder import announced_folder
from procedures.journal.storage import JOURNAL_FILE
from rig.clock import Clock, SystemClock

LOG_FILE = "terminal.log"
_LOOK_S = 0.05
_AWAY_FROM_CONSOLE: int = getattr(subprocess, "DETACHED_PROCESS", 0) | getattr(
    subprocess, "CREATE_NEW_PROCESS_GROUP", 0
)
"""Of Windows, what a new session is elsewhere."""


def detached(
    name: str,
    arguments: Sequence[str],
    options: Mapping[str, object],
    flags: Mapping[str, bool],
    out: Path,
    *,
    json: bool = False,
    clock: Clock | None = None,
) -> int:
    """Start the command and come back when its run has begun, or with its refusal. Raises: RequestError.

    ``options`` without a value and ``flags`` that are not set are left out. ``out``: the folder of runs, or the
    run's own.
    """
    clock = clock or SystemClock()
    given = [word for option, value in options.items() if value is not None for word in (option, str(value))]
    command = [sys.executable, "-m", "procedures.cli.main", name, *arguments, *given]
    command += [flag for flag, is_set in flags.items() if is_set]
    opened_before, _ = _last_opening(out)
    log = _log_in(out)
    with log.open("wb") as output:
        child = subprocess.Popen(  # noqa: S603  this very program
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env=read_by_us() if is_read() else None,
            start_new_session=True,
            creationflags=_AWAY_FROM_CONSOLE,
        )
    folder = None
    while (folder := announced_folder(log)) is None or not _is_taken_up(folder, opened_before):
        if child.poll() is not None:
            break
        clock.sleep(_LOOK_S)
    if folder is None or not _is_taken_up(folder, opened_before):
        said = log.read_text(encoding="utf-8", errors="replace").strip()
        log.unlink()
        for line in said.splitlines():
            note(line)
        return child.returncode or ExitStatus.FAILED
    kept = _free_name(folder)
    with suppress(PermissionError):  # Windows renames no file that is being written
        os.replace(log, kept)
    child.returncode = 0  # it lives on, and nobody waits for it
    if json:
        print_json({"run": str(folder), "pid": child.pid})
    else:
        say(
            f"{folder}: runs as process {child.pid}; calrig attach {folder} shows it, {kept.name} there keeps its words"
        )
    return ExitStatus.DONE


def _last_opening(folder: Path) -> tuple[int, int]:
    """Return where in its journal a process opened the run last, and its state came last; 0 where neither is.

    A folder of runs has none.
    """
    if not (folder / JOURNAL_FILE).exists():
        return 0, 0
    with JournalReader.open(folder) as reader:
        found = [reader.last_event(kind) for kind in ("opened", "state")]
    opened, entered = (0 if event is None else event.sequence for event in found)
    return opened, entered


def _is_taken_up(folder: Path, opened_before: int) -> bool:
    """Return whether a process opened the run after that, and has entered a state since."""
    opened, entered = _last_opening(folder)
    return opened_before < opened < entered


def _free_name(folder: Path) -> Path:
    """Return where the words are kept: those of the process before, which a run was begun by, are kept as well."""
    names = (LOG_FILE if number == 1 else f"terminal-{number}.log" for number in count(1))
    return next(folder / name for name in names if not (folder / name).exists())


def _log_in(out: Path) -> Path:
    """Return a file beside the runs, or in the folder of one, so that it can be renamed in there."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=".begins-", suffix=".log", dir=out)
    except OSError as error:
        raise RequestError(
            f"{out}: cannot hold runs: {error.strerror}; nothing was begun; give another --out"
        ) from error
    os.close(handle)
    return Path(name)
