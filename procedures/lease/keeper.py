"""Take the lease of what other computers reach as well, keep it while the rig is open, and give it back.

A lease keeps a second computer away; it never stops the first. Whoever finds a device leased is refused before a port
is opened. Whoever loses a lease that he has (the database does not answer, or another took it after it had lapsed) is
told, and goes on: an axis that stops because a database went away would be the greater harm.

The database is asked in a thread of its own: however long it takes, no look at an axis waits for it.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from platform import node
from threading import Event, Lock
from uuid import uuid4

from ams.archive.leases import Claim, Holder, Lease, claim, held, release
from ams.archive.refusals import without_password
from ams.errors import ArchiveAbsent, ArchiveError
from rig.clock import Clock, SystemClock
from rig.errors import RigBusy
from rig.lines.lock import account, folder_of_locks
from rig.local_time import at_both
from rig.threads import BegunThread, begun

LAPSES_S, RENEWED_S = 120.0, 30.0
"""How long a lease outlives its holder, and how often it is renewed."""
GIVEN_BACK_S = 10.0
"""So long the end of a command waits for a database that does not answer; the lease lapses by itself."""


NO_MEMORY = "no memory is left to ask it"


@dataclass(frozen=True, slots=True)
class LeaseNews:
    """What became of a lease while the rig was open."""

    text: str
    is_lost: bool


@dataclass(frozen=True, slots=True)
class Looked:
    """What an archive says of devices before anybody claims them, in sentences."""

    refusals: tuple[str, ...] = ()
    unguarded: tuple[str, ...] = ()
    guarded: tuple[str, ...] = ()


def look(archive_url: str, resources: Sequence[str], clock: Clock | None = None) -> Looked:
    """Say what a claim would meet now; nothing is claimed."""
    shown = without_password(archive_url)
    try:
        others = held(archive_url, resources, (clock or SystemClock()).now_utc())
    except ArchiveAbsent:  # made when it is first written to, as by a claim
        others = ()
    except ArchiveError as error:
        return Looked(unguarded=(f"{_names(resources)}: nothing guards against a second computer now: {error}",))
    return Looked(
        refusals=tuple(_refusal(lease, shown) for lease in others if lease.holder.place != (folder_of_locks() or None)),
        guarded=tuple(
            f"{name_of(resource)}: guarded by a lease in {shown} against computers that use the same archive"
            for resource in resources
        ),
    )


@contextmanager
def leased(
    archive_url: str | None,
    purpose: str,
    tell: Callable[[str], None],
    clock: Clock | None = None,
    lapses_s: float = LAPSES_S,
    renewed_s: float = RENEWED_S,
) -> Iterator["LeaseKeeper"]:
    """Yield who keeps the leases of one open rig, all given back at the end.

    ``archive_url``: None where no archive is configured; then nothing is claimed. ``tell`` hears what cannot be done.
    """
    keeper = LeaseKeeper(archive_url, purpose, tell, clock or SystemClock(), lapses_s, renewed_s)
    try:
        yield keeper
    finally:
        keeper.close()


class LeaseKeeper:
    """Of one command."""

    def __init__(
        self,
        archive_url: str | None,
        purpose: str,
        tell: Callable[[str], None],
        clock: Clock,
        lapses_s: float = LAPSES_S,
        renewed_s: float = RENEWED_S,
    ) -> None:
        self._archive_url = archive_url
        self._tell = tell
        self._clock = clock
        self._lapses_s, self._renewed_s = lapses_s, renewed_s
        self._holder = Holder(uuid4().hex, node() or "unknown host", account(), purpose)
        self._resources: tuple[str, ...] = ()
        self._held: set[str] = set()
        """What was ours at some time."""
        self._last_s: float | None = None
        """When the database last said that all is ours, by this machine's clock."""
        self._failure = ""
        self._taken_by = ""
        self._announced = ""
        """The loss that was told and is not over."""
        self._news: deque[LeaseNews] = deque()
        self._turn = Lock()
        self._awake, self._ends = Event(), Event()
        self._thread: BegunThread | None = None

    def claim(self, resources: Sequence[str]) -> None:
        """Take the leases, all or none, beside those that are held.

        Raises: RigBusy telling who has one; MemoryError where no thread can be had that keeps them: none is taken then.

        A database that does not answer refuses nothing: it is told that nothing guards, and asked again and again.
        """
        if self._archive_url is None or not resources:
            return
        self._holder = replace(self._holder, place=folder_of_locks())
        try:
            found = self._ask(resources, all_or_none=True)
        except ArchiveError as error:
            self._failure = str(error)
            self._tell(f"{_names(resources)}: nothing guards against a second computer now: {error}")
        else:
            if found.others:
                raise RigBusy(_refusal(found.others[0], without_password(self._archive_url)))
            self._held |= set(resources)
            self._last_s = self._clock.monotonic_s()
        with self._turn:
            self._resources = tuple(sorted({*self._resources, *resources}))
        if self._thread is None:
            try:
                self._thread = begun(self._keep, f"the lease of {_names(resources)}, which nobody would keep")
            except MemoryError:  # whoever is refused opens nothing, and another computer need not wait for him
                self._give_back()
                raise

    def belongs_to(self, purpose: str) -> None:
        """From now on others read that the devices are for this."""
        self._holder = replace(self._holder, purpose=purpose)
        self._awake.set()

    def news(self) -> Sequence[LeaseNews]:
        """Return what became of the leases since the last call. Nothing is asked here."""
        if not self._resources:
            return ()
        with self._turn:
            found = [self._news.popleft() for _ in range(len(self._news))]
            loss = self._taken_by or self._lapsed()
            if loss and loss != self._announced:
                found.append(LeaseNews(f"{loss}; the run goes on", is_lost=True))
            elif self._announced and not loss:
                found.append(LeaseNews(f"the lease of {_names(self._resources)} is held again", is_lost=False))
            self._announced = loss
        return found

    def close(self) -> None:
        """Give everything back; where the database does not answer in time, it lapses by itself."""
        if self._thread is None:
            return
        self._ends.set()
        self._awake.set()
        if not self._thread.join(GIVEN_BACK_S) or self._failure:
            self._tell(
                f"the lease of {_names(self._resources)} could not be given back; it lapses by itself:"
                f" {self._failure or 'the database of the archive does not answer'}"
            )

    def _keep(self) -> None:
        while not self._ends.is_set():
            self._awake.wait(self._renewed_s)
            self._awake.clear()
            if not self._ends.is_set():
                self.renew()
        self._give_back()

    def _give_back(self) -> None:
        assert self._archive_url is not None
        self._failure = ""
        try:
            release(self._archive_url, self._holder.token)
        except ArchiveError as error:
            self._failure = str(error)
        except MemoryError:
            self._failure = NO_MEMORY

    def renew(self) -> None:
        """Ask the database once for all that is held; what it says is told by :meth:`news`."""
        with self._turn:
            resources = self._resources
        try:
            found = self._ask(resources)
        except ArchiveError as error:
            self._failure = str(error)
            return
        except MemoryError:  # it is asked again, while the lease lapses and is said to
            self._failure = NO_MEMORY
            return
        with self._turn:
            self._failure = ""
            if found.others:
                self._taken_by = "; ".join(_taken(lease) for lease in found.others)
                return
            if not self._taken_by and (gone := [resource for resource in found.begun if resource in self._held]):
                self._announced = (
                    f"the lease of {_names(gone)} had lapsed and was not kept: another computer may have had the device"
                )
                self._news.append(LeaseNews(f"{self._announced}; the run goes on", is_lost=True))
            self._held |= set(resources)
            self._taken_by = ""
            self._last_s = self._clock.monotonic_s()

    def _ask(self, resources: Sequence[str], *, all_or_none: bool = False) -> Claim:
        assert self._archive_url is not None
        return claim(
            self._archive_url,
            resources,
            self._holder,
            self._lapses_s,
            self._clock.now_utc(),
            all_or_none=all_or_none,
            only_existing=bool(self._held),
        )

    def _lapsed(self) -> str:
        """Say that nobody knows any more whose it is, once; what the database said last stands with it."""
        if self._last_s is not None and self._clock.monotonic_s() - self._last_s < self._lapses_s:
            return ""
        if self._announced:
            return self._announced
        names, why = _names(self._resources), f" ({self._failure})" if self._failure else ""
        if self._last_s is None:
            return f"no lease of {names} could be taken{why}: nothing guards against a second computer"
        return (
            f"the lease of {names} has lapsed: the archive could not be asked for {self._lapses_s:g} s{why};"
            " another computer may take the device"
        )


def _refusal(lease: Lease, shown: str) -> str:
    return (
        f"{name_of(lease.resource)}: another computer has it: {_holding(lease)}; its lease in {shown} lapses in"
        f" {lease.lapses_in_s:.0f} s if nothing more is heard of it; nothing was opened; wait until it has finished,"
        " or stop it there"
    )


def _taken(lease: Lease) -> str:
    return (
        f"{name_of(lease.resource)}: the lease is lost: another computer has it: {_holding(lease)};"
        " two may move this device now; end one of them"
    )


def _holding(lease: Lease) -> str:
    return f"{lease}, since {at_both(lease.since_utc)}"


def name_of(resource: str) -> str:
    """Return a resource as people read it."""
    with suppress(ValueError):
        kind, host, port = resource.split(" ")
        if kind == "tcp":
            return f"{host} port {port}"
    return resource


def _names(resources: Sequence[str]) -> str:
    return ", ".join(name_of(resource) for resource in resources)
