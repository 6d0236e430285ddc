"""Who owns a rig: one lock a real port, one a device that tells its serial number and one a rig file, machine-wide.

The lock is that of :mod:`rig.file_lock`, on a file in one folder for all accounts (:mod:`rig.machine_folder`); a file
beside it, each account's own, says who holds it. It keeps a second calrig on this machine away, whatever name it has
for the port, not another program and not another machine: nothing here can (:mod:`procedures.lease` can, by a database
that both know). Another file stays when the lock is given back: who used it last, which ends what a queue had armed.
Where that file cannot be written nothing is locked, but for a stop, which nothing keeps from being sent.
"""

import json
import os
import re
import socket
import stat
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass
from functools import lru_cache
from hashlib import blake2b
from ipaddress import ip_address
from pathlib import Path
from types import TracebackType
from typing import IO

from psutil import pid_exists

from rig import file_lock
from rig.clock import Clock, SystemClock
from rig.errors import RigBusy
from rig.link.port_address import canonical_port
from rig.local_time import text_at_both
from rig.machine_folder import OVERRIDE, machine_folder
from rig.machine_room import WHAT_TO_DO, no_room_sentence, require_room, write_whole
from rig.system_parts import module_here

FOLDER = "locks"
DEVICE = "device "
"""Of a resource that is a device by its own serial number."""
STARTED_BY = "CALRIG_STARTED_BY"
"""Environment variable of a process that a queue started: the folder of that queue."""
_ATTEMPTS = 5
_HERE = "this machine"
_READABLE = 0o644
_BOARD = re.compile(r"GPIB(?P<number>\d*)", re.IGNORECASE)
_NETWORK = re.compile(r"(?P<scheme>[A-Za-z0-9+.-]+)://(?:[^@/]*@)?(?P<host>\[[^\]]*\]|[^:/#]+):(?P<port>\d+)")


@dataclass(frozen=True, slots=True)
class LockOwner:
    """Who holds a lock."""

    resource: str
    """The port, the device or the rig file."""
    pid: int
    since_utc: str
    purpose: str
    """What it holds it for: the command."""
    account: str = ""
    queue: str = ""
    """The folder of the queue whose process it is; empty where people began it."""

    @property
    def mark(self) -> str:
        """What tells this use from every other."""
        return f"{self.account} {self.pid} {self.since_utc}"

    @property
    def is_of_this_process(self) -> bool:
        return (self.account, self.pid) == (account(), os.getpid())

    def __str__(self) -> str:
        whose = f" of {self.account}" if self.account not in ("", account()) else ""
        return f"process {self.pid} ({self.purpose or 'calrig'}){whose} since {text_at_both(self.since_utc)}"


@dataclass(frozen=True, slots=True)
class LeftUse:
    """What was done to resources without holding them."""

    owners: tuple[LockOwner, ...]
    """It, by resource."""
    unmarked: str = ""
    """Why others do not see it: a mark of it could not be left; empty where all were."""


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
    resources: Sequence[str],
    purpose: str,
    *,
    folder: Path | None = None,
    clock: Clock | None = None,
    for_stop: bool = False,
) -> RigLock:
    """Lock every resource (port addresses, devices, rig file paths) for this process.

    ``for_stop``: nothing will move, and axes are to be stopped: a folder that takes no file keeps nobody from that.

    Raises: RigBusy naming the owner of the first one that is held, or the folder that takes no mark of this; then none
    is kept.
    """
    clock = clock or SystemClock()
    # Of several names of one port the first by alphabet is told, in whatever order they come: later ones replace.
    names = {identity_of(resource): canonical(resource) for resource in sorted(resources, reverse=True)}
    try:
        where = folder or lock_folder()
    except RigBusy:
        if not for_stop:
            raise
        return RigLock(ExitStack(), ())
    with ExitStack() as held:
        for identity, name in sorted(names.items()):
            owner = _this_process(name, purpose, clock)
            held.enter_context(_locked(_file_of(identity, where), owner, clock, for_stop=for_stop))
        return RigLock(held.pop_all(), tuple(sorted(names.values())))


def leave_use(
    resources: Iterable[str], purpose: str, *, folder: Path | None = None, clock: Clock | None = None
) -> LeftUse:
    """Leave on record that something was done to resources without holding them, as a stop from elsewhere."""
    owners = [_this_process(canonical(resource), purpose, clock or SystemClock()) for resource in resources]
    unmarked = ""
    try:
        where = folder or (lock_folder() if owners else Path())
        for owner in owners:
            _leave(_file_of(identity_of(owner.resource), where), owner)
    except RigBusy as error:
        unmarked = str(error)
    except OSError as error:
        unmarked = no_room_sentence(error, where)
    return LeftUse(tuple(owners), unmarked)


def uses(resources: Iterable[str], *, folder: Path | None = None) -> list[LockOwner]:
    """Return the last use of each account and queue of any of the resources, whether it lasts or is over; by time.

    Raises: RigBusy where there is no folder, and where a mark cannot be read.
    """
    found: dict[str, LockOwner] = {}
    for path in (_file_of(identity_of(resource), folder or lock_folder()) for resource in resources):
        for text in path.parent.glob(f"{path.stem}.*.used"):
            if (owner := _read(text)) is None:
                raise RigBusy(
                    f"{text}: does not say who used the rig; look at the rig, remove that file, then arm anew"
                )
            found[owner.mark] = owner
        if path.exists() and (owner := _holder(path)) is not None:
            found[owner.mark] = owner
    return sorted(found.values(), key=lambda owner: owner.since_utc)


def require_marks() -> None:
    """See that a use of a rig by this account leaves its mark now. Raises: RigBusy."""
    require_room(lock_folder())


def owner_of(resource: str, *, folder: Path | None = None) -> LockOwner | None:
    """Return who holds a resource now, or None."""
    path = _file_of(identity_of(resource), folder or lock_folder())
    return _holder(path) if path.exists() else None


def lock_folder() -> Path:
    """Return the one folder for all accounts. Raises: RigBusy where there is none."""
    try:
        return Path(machine_folder(FOLDER))
    except OSError as error:
        raise RigBusy(
            f"{error.filename or error}: no folder for locks that all accounts share: {error.strerror}; nothing was"
            f" opened; set {OVERRIDE} to the same folder, writable by all and sticky, for every account"
        ) from error


def canonical(resource: str) -> str:
    """Return how a resource is told: links to a device followed, host names in lower case, rig files as full paths.

    A board that VISA knows is no file, wherever the command was called.
    """
    if resource.startswith(DEVICE):
        return resource
    if board := _BOARD.fullmatch(resource):
        return f"GPIB{int(board['number'] or 0)}"
    return canonical_port(resource)


def identity_of(resource: str) -> str:
    """Return what a resource is, whatever it is called.

    It is a host's address for its name, a device's numbers for its path. By any scheme, a port of a host is one thing.
    """
    if network := _NETWORK.match(canonical(resource)):
        return f"tcp {address_of(network['host'].strip('[]'))} {int(network['port'])}"
    path = Path(canonical(resource))
    with suppress(OSError):
        found = path.stat()
        if sys.platform != "win32" and stat.S_ISCHR(found.st_mode):
            return f"character device {os.major(found.st_rdev)} {os.minor(found.st_rdev)}"
    return str(path) if not resource.startswith(DEVICE) else resource


def is_beyond_this_machine(resource: str) -> bool:
    """Return whether other machines may reach it as this one does: over the network, and not at this machine."""
    return identity_of(resource).startswith("tcp ") and not identity_of(resource).startswith(f"tcp {_HERE} ")


def known_elsewhere_as(resources: Iterable[str]) -> list[str]:
    """Return what other machines know those resources by that they reach as well: the same there as here."""
    return [identity_of(resource) for resource in resources if is_beyond_this_machine(resource)]


def is_on_network(resource: str) -> bool:
    """Return whether it is reached by network protocols, at this machine or beyond it."""
    return identity_of(resource).startswith("tcp ")


def folder_of_locks() -> str:
    """Return what tells this folder of locks from every other in the world; empty where nothing does.

    The kernel that keeps the locks, by its start, and the folder by its numbers there. Containers of one machine have
    folders of their own unless they share one, and then its locks. Raises: RigBusy.
    """
    try:
        started = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        folder = lock_folder().stat()
    except OSError:
        return ""
    return f"{started} {folder.st_dev} {folder.st_ino}"


@lru_cache
def address_of(host: str) -> str:
    """Return the one number by which a host is known: this machine's own are one; its name where it has none now."""
    try:
        found = sorted({_plain(str(entry[4][0])) for entry in socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)})
    except OSError:
        return host
    if any(_is_of_this_machine(address) for address in found):
        return _HERE
    return next((address for address in found if ":" not in address), found[0])


def _plain(address: str) -> str:
    """Return an IPv4 address that is written as one of IPv6 (``::ffff:192.0.2.7``) as what it is."""
    mapped = getattr(ip_address(address.partition("%")[0]), "ipv4_mapped", None)
    return address if mapped is None else str(mapped)


def _is_of_this_machine(address: str) -> bool:
    """Return whether an address is one of this machine's own: only those can be listened at."""
    if ip_address(address.partition("%")[0]).is_loopback:
        return True
    try:
        with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind((address, 0))
    except OSError:
        return False
    return True


def serial_of(identity: str) -> str | None:
    """Return the part of a device's answer that only this one gives: its words up to its serial number, or None."""
    found = re.search(r"^(.*?\bserial(?: number)?:? *([A-Za-z0-9-]*\d[A-Za-z0-9-]*))", identity, re.IGNORECASE)
    return None if found is None or not found[2].strip("0-") else f"{DEVICE}{found[1]}"


def account() -> str:
    """Return the name of this account: by its number where there are numbers, which no variable can change."""
    accounts, number = module_here("pwd"), _account_number()
    if accounts is None or number is None:
        return os.environ.get("USERNAME", "unknown")
    try:
        return str(accounts.getpwuid(number).pw_name)
    except KeyError:
        return f"uid {number}"


def _account_number() -> int | None:
    """Return the number of this account; None on Windows, where it has none."""
    number: int | None = getattr(os, "getuid", lambda: None)()
    return number


@contextmanager
def _locked(path: Path, owner: LockOwner, clock: Clock, *, for_stop: bool) -> Iterator[None]:
    with ExitStack() as held:
        try:
            file = held.enter_context(_opened(path))
        except OSError as error:
            if not for_stop:
                raise _unmarked(error, path.parent) from error
            yield  # nobody holds a file that cannot be made
            return
        if not file_lock.take(file, clock, _ATTEMPTS):
            raise RigBusy(
                f"{owner.resource}: in use by {_owner(path) or 'another process'}; nothing was opened;"
                " wait until it has finished, or stop it"
            )
        text = path.with_name(f"{path.stem}.{_whose()}.owner")
        held.callback(_forget, text)
        with suppress(OSError):  # for people: where another account keeps this one from it, the lock holds all the same
            write_whole(text, json.dumps(asdict(owner)), _READABLE)
        try:
            _leave(path, owner)
        except OSError as error:
            if not for_stop:
                raise _unmarked(error, path.parent) from error
        yield


def _forget(text: Path) -> None:
    with suppress(OSError):
        text.unlink()


def _unmarked(error: OSError, folder: Path) -> RigBusy:
    return RigBusy(
        f"{no_room_sentence(error, folder)}: no queue that waits for the rig would see that it is used; nothing was"
        f" opened; {WHAT_TO_DO}"
    )


def _this_process(resource: str, purpose: str, clock: Clock) -> LockOwner:
    since_utc = clock.now_utc().isoformat(timespec="microseconds")
    return LockOwner(resource, os.getpid(), since_utc, purpose, account(), os.environ.get(STARTED_BY, ""))


def _whose() -> str:
    """Return this account as a part of a file's name."""
    number = _account_number()
    return re.sub(r"[^A-Za-z0-9]+", "-", account()) if number is None else str(number)


def _leave(path: Path, owner: LockOwner) -> None:
    """Write who uses it where it stays; what people began and what each queue began do not write over each other.

    Raises: OSError; then the one before is there still.
    """
    by = blake2b(owner.queue.encode(), digest_size=6).hexdigest() if owner.queue else "people"
    mark = path.with_name(f"{path.stem}.{_whose()}.{by}.used")
    write_whole(mark, json.dumps(asdict(owner)), _READABLE)


def _opened(path: Path) -> IO[str]:
    """Open a lock's file, to be read by all: one that another account made cannot be written, and need not be."""
    while True:
        with suppress(FileNotFoundError):
            return path.open(encoding="utf-8")
        with suppress(FileExistsError):
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, _READABLE))
            path.chmod(_READABLE)  # past the umask


def _holder(path: Path) -> LockOwner | None:
    with _opened(path) as file:
        return _owner(path) if file_lock.is_held(file) else None


def _owner(path: Path) -> LockOwner | None:
    """Return what the newest text of a living process beside it says; None where none is whole."""
    read = map(_read, path.parent.glob(f"{path.stem}.*.owner"))
    found = [owner for owner in read if owner is not None and pid_exists(owner.pid)]
    return max(found, key=lambda owner: owner.since_utc, default=None)


def _read(text: Path) -> LockOwner | None:
    with suppress(OSError, ValueError, TypeError):
        return LockOwner(**json.loads(text.read_text(encoding="utf-8")))
    return None


def _file_of(identity: str, folder: Path) -> Path:
    slug = re.sub(r"[^A-Za-z0-9]+", "-", identity).strip("-")[-60:]
    return folder / f"{slug}-{blake2b(identity.encode(), digest_size=6).hexdigest()}.lock"
