"""Who owns a rig: one lock a real port and one a rig file, in the user's runtime folder.

The lock is that of :mod:`rig.file_lock`; the file's text says who holds it. It keeps a second calrig away, not another
program: nothing can.
"""

import json
import os
import re
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from hashlib import blake2b
from pathlib import Path
from types import TracebackType
from typing import IO

import platformdirs

from rig import file_lock
from rig.clock import Clock, SystemClock
from rig.errors import RigBusy

_ATTEMPTS = 5


@dataclass(frozen=True, slots=True)
class LockOwner:
    """Who holds a lock."""

    resource: str
    """The port or the rig file."""
    pid: int
    since_utc: str
    purpose: str
    """What it holds it for: the command."""

    def __str__(self) -> str:
        return f"process {self.pid} ({self.purpose or 'calrig'}) since {self.since_utc}"


class RigLock:
    """Exclusive hold of several resources, taken all or none. A context manager."""

    def __init__(self, files: ExitStack, resources: tuple[str, ...]) -> None:
        self.resources = resources
        self._files = files

    def release(self) -> None:
        """Give all of them back; releasing twice is harmless."""
        self._files.close()

    def __enter__(self) -> "RigLock":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def acquire(
    resources: Sequence[str], purpose: str, *, folder: Path | None = None, clock: Clock | None = None
) -> RigLock:
    """Lock every resource (port addresses and rig file paths) for this process.

    Raises: RigBusy naming the owner of the first one that is held; then none is kept.
    """
    clock = clock or SystemClock()
    names = tuple(sorted({canonical(resource) for resource in resources}))
    with ExitStack() as held:
        for name in names:
            held.enter_context(_locked(_file_of(name, folder or lock_folder()), name, purpose, clock))
        return RigLock(held.pop_all(), names)


def owner_of(resource: str, *, folder: Path | None = None) -> LockOwner | None:
    """Who holds a resource now, or None."""
    path = _file_of(canonical(resource), folder or lock_folder())
    return _holder(path) if path.exists() else None


def owners(*, folder: Path | None = None) -> list[LockOwner]:
    """Everybody who holds something now."""
    found = (_holder(path) for path in sorted((folder or lock_folder()).glob("*.lock")))
    return [owner for owner in found if owner is not None]


def lock_folder() -> Path:
    """The user's runtime folder, or a private one in the temporary folder where the system has none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # it warns that it falls back: so do we, without alarm
        preferred = Path(platformdirs.user_runtime_dir("calrig"))
    for folder in (preferred, Path(tempfile.gettempdir()) / f"calrig-{os.getuid()}"):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    raise RigBusy(
        f"{preferred}: no folder for locks can be made; nothing was opened; set XDG_RUNTIME_DIR to a folder of yours"
    )


def canonical(resource: str) -> str:
    """One name for one thing: links to a device followed, host names in lower case, rig files as full paths."""
    scheme, mark, rest = resource.partition("://")
    return f"{scheme.lower()}{mark}{rest.lower()}" if mark else str(Path(resource).resolve())


@contextmanager
def _locked(path: Path, resource: str, purpose: str, clock: Clock) -> Iterator[None]:
    with path.open("a+", encoding="utf-8") as file:
        if not file_lock.take(file, clock, _ATTEMPTS):
            raise RigBusy(
                f"{resource}: in use by {_owner(file) or 'another process'}; nothing was opened;"
                " wait until it has finished, or stop it"
            )
        owner = LockOwner(resource, os.getpid(), clock.now_utc().isoformat(timespec="seconds"), purpose)
        file_lock.say(file, json.dumps(asdict(owner)))
        try:
            yield
        finally:
            file_lock.say(file, "")


def _holder(path: Path) -> LockOwner | None:
    with path.open("a+", encoding="utf-8") as file:
        return _owner(file) if file_lock.is_held(file) else None


def _owner(file: IO[str]) -> LockOwner | None:
    """What the file says; None where it says nothing whole (its owner is just writing it)."""
    file.seek(0)
    try:
        return LockOwner(**json.loads(file.read()))
    except (ValueError, TypeError):
        return None


def _file_of(resource: str, folder: Path) -> Path:
    slug = re.sub(r"[^A-Za-z0-9]+", "-", resource).strip("-")[-60:]
    return folder / f"{slug}-{blake2b(resource.encode(), digest_size=6).hexdigest()}.lock"
