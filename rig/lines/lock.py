"""Who owns a rig: one lock a real port and one a rig file, in the user's runtime folder.

The lock is the kernel's (flock), so it ends with its process however that ends, and a stale file blocks nobody.
The file's text says who holds it and is for people; the lock itself is the truth. It keeps a second calrig away, not
another program: nothing can.
"""

import fcntl
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

from rig.clock import Clock, SystemClock
from rig.errors import RigBusy

_ATTEMPTS, _BETWEEN_S = 5, 0.02
"""Somebody who only looks holds the lock for an instant: a refusal must outlast that."""


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
        for attempt in range(1, _ATTEMPTS + 1):
            if _try(file, fcntl.LOCK_EX):
                break
            if attempt == _ATTEMPTS:
                raise RigBusy(
                    f"{resource}: in use by {_owner(file) or 'another process'}; nothing was opened;"
                    " wait until it has finished, or stop it"
                )
            clock.sleep(_BETWEEN_S)
        _write(file, LockOwner(resource, os.getpid(), clock.now_utc().isoformat(timespec="seconds"), purpose))
        try:
            yield
        finally:
            _write(file, None)


def _try(file: IO[str], kind: int) -> bool:
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _holder(path: Path) -> LockOwner | None:
    with path.open("a+", encoding="utf-8") as file:
        return None if _try(file, fcntl.LOCK_SH) else _owner(file)


def _owner(file: IO[str]) -> LockOwner | None:
    """What the file says; None where it says nothing whole (its owner is just writing it)."""
    file.seek(0)
    try:
        return LockOwner(**json.loads(file.read()))
    except (ValueError, TypeError):
        return None


def _write(file: IO[str], owner: LockOwner | None) -> None:
    file.truncate(0)
    if owner is not None:
        file.write(json.dumps(asdict(owner)))
    file.flush()


def _file_of(resource: str, folder: Path) -> Path:
    slug = re.sub(r"[^A-Za-z0-9]+", "-", resource).strip("-")[-60:]
    return folder / f"{slug}-{blake2b(resource.encode(), digest_size=6).hexdigest()}.lock"
