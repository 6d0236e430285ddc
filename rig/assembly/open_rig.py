"""The one place that chooses: real device or twin, which clock, which chance; and that owns the rig's locks.

Everything is opened together or not at all, and given back in the opposite order.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from rig.abilities.abilities import (
    Axis,
    Environment,
    Field,
    NoChance,
    Readout,
    Stream,
    TwinChance,
    WriteFile,
)
from rig.assembly.device_groups import DeviceGroups, GroupOpener, ports_by_device
from rig.assembly.faulty_lines import with_faults
from rig.assembly.guard_of_rig import stop_guard
from rig.assembly.identity import AXES, FirstAnswers, Identifiable, expected, require_expected
from rig.clock import Clock, ScaledClock, SystemClock, VirtualClock
from rig.crash_points import refuse_crash_points
from rig.description.device_settings import TWIN_PORT
from rig.description.fault_plan import FaultPlan
from rig.description.rig_file import RigDescription
from rig.drivers.twin_lines import twin_lines
from rig.errors import DescriptionError, RigError
from rig.guard.stop_guard import StopGuard
from rig.lines.lock import RigLock, acquire, is_on_network, known_elsewhere_as, serial_of
from rig.lines.open_lines import Lines
from rig.lines.recording import LineSource
from rig.link.counts import ExchangeCounts
from rig.motion.motion_memory import MotionMemory
from rig.motion.supervisor import Supervisor
from rig.twins.physics.world import World

Claim = Callable[[Sequence[str]], None]
"""Take what other machines reach as well, by the names that they know it by too.

Raises: RigBusy where one of them has it.
"""


def claimed_by_nobody_else(_resources: Sequence[str]) -> None:
    """Claim nothing: no machine but this one is kept away."""


class Rig:
    """Open devices by the names of the rig file. A context manager."""

    def __init__(
        self,
        description: RigDescription,
        clock: Clock,
        groups: DeviceGroups,
        chance: TwinChance | None,
        held: ExitStack,
        guard: StopGuard | None = None,
        purpose: str = "calrig",
        claim: Claim = claimed_by_nobody_else,
        memory: MotionMemory | None = None,
        *,
        for_stop: bool = False,
    ) -> None:
        self.description = description
        self.clock = clock
        self._groups = groups
        self._chance = chance
        self._first_answers = FirstAnswers()
        self._held = held
        self._guard = guard
        self._purpose = purpose
        self._claim = claim
        self._for_stop = for_stop
        self.motion = memory or MotionMemory()  # over all connections
        self._locked: set[str] = set()
        """Devices by their serial numbers."""

    @property
    def axes(self) -> Mapping[str, Axis]:
        return self._groups.devices.axes

    @property
    def readouts(self) -> Mapping[str, Readout]:
        return self._groups.devices.readouts

    @property
    def environments(self) -> Mapping[str, Environment]:
        return self._groups.devices.environments

    @property
    def streams(self) -> Mapping[str, Stream]:
        return self._groups.devices.streams

    @property
    def fields(self) -> Mapping[str, Field]:
        return self._groups.devices.fields

    @property
    def chance(self) -> TwinChance:
        return self._chance or self._groups.chance or NoChance()

    def link_counts(self) -> Mapping[str, ExchangeCounts]:
        """Return the counts of every line, by table, or by device where several share it (``axes.pitch, unit 2``)."""
        return self._groups.counts()

    def reconnect(self) -> None:
        """Close every line and open it again; drivers forget all but what chambers were set to, locks and twins stay.

        Every one: what falls silent with the others, as when the power fails, is not lost and has forgotten what its
        driver set; and of a connection whose other end is gone the port knows nothing. Where one stays away the others
        were opened at that attempt and are kept at the next, since to open a port resets some of what hangs on it.
        Nothing is set in motion. An axis that was told to turn, and was not seen at rest since, is told to stop as soon
        as its line is open. A line that stays away keeps no other closed: what is on it answers as closed, and it can
        be tried again. Raises as :func:`open_rig`, for the first line that stays away.
        """
        if failures := self._groups.renew():
            raise failures[0]

    def open_lost(self, until_s: float) -> str:
        """Open again the lines that are lost or closed, and keep those that are open, whose devices remember all.

        Axes are told to stop as by :meth:`reconnect`, and while one that turns stays away nothing else is opened. None
        is begun after ``until_s``, rig seconds. Return what failed, a clause each; empty where nothing did.
        """
        return "; ".join(map(str, self._groups.open_lost(until_s)))

    def prepare_to_move(self) -> None:
        """Begin what must be there before the first motion, which should not wait for it."""
        if self._guard is not None:
            self._guard.begin()

    def sign_of_life(self) -> None:
        """Say that whoever has the rig is at work, while he waits for something else than a device."""
        if self._guard is not None:
            self._guard.sign_of_life()

    def why_stop(self) -> str:
        """Return why nothing may move on: somebody had the axes stopped from elsewhere, or the stop guard is gone.

        For a thread beside the one that has the devices; empty while nothing is known. See :meth:`heed_stop`.
        """
        return "" if self._guard is None else self._guard.why_stop()

    def heed_stop(self) -> None:
        """Take that stop as obeyed: every axis was seen at rest since."""
        if self._guard is not None:
            self._guard.take_trouble()

    def belongs_to(self, run_dir: Path, ring: Sequence[str] = ()) -> Callable[[], None]:
        """Whoever stops these axes from elsewhere tells of it in the run's folder, and to people by ``ring``.

        Return what is called once the run's end is on record: to close this before is told as the run's death.
        """
        return (lambda: None) if self._guard is None else self._guard.belongs_to(run_dir, ring)

    def identities(self) -> dict[str, str]:
        """Return who every device says it is, by table (``axes.pitch``).

        Raises: DeviceSilent, DeviceNonsense, LinkLost, RequestRefused where one is not the one that the file means,
        RigBusy where somebody else holds it by another port.
        """
        found = {key: device.identify() for key, device in self.by_table().items()}
        require_expected(expected(self.description), found)
        self._lock_devices(found.values())
        self.strangers(found)
        return found

    def strangers(self, found: Mapping[str, str]) -> dict[str, str]:
        """Return table to a sentence where ``found``, as of :meth:`identities`, is not who answered there first."""
        return self._first_answers.strangers(found)

    def stranger_axes(self, names: Iterable[str]) -> dict[str, str]:
        """Ask axes who they are; return axis to a sentence where that is not who answered there first, or nobody does.

        An axis that was not asked before is known from now on.
        """
        found, silent = dict[str, str](), dict[str, str]()
        for name in names:
            try:
                found[f"{AXES}{name}"] = self.axes[name].identify()
            except RigError as error:
                silent[name] = f"{name}: who answers on its line is not known: {error}"
        return {key.removeprefix(AXES): sentence for key, sentence in self.strangers(found).items()} | silent

    def _lock_devices(self, identities: Iterable[str]) -> None:
        """Lock every device that tells its serial number: it is this rig's by whatever port others reach it.

        Twins tell those of others. Raises: RigBusy.
        """
        if self.description.is_simulated:
            return
        wanted = {serial for identity in identities if (serial := serial_of(identity)) is not None} - self._locked
        self._held.enter_context(acquire(sorted(wanted), self._purpose, for_stop=self._for_stop))
        self._locked |= wanted
        if any(map(is_on_network, real_ports(self.description))):
            self._claim(sorted(wanted))

    def require_identities(self) -> None:
        """Ask those who they are of whom the file states it. Raises as :meth:`identities`."""
        stated, devices = expected(self.description), self.by_table()
        require_expected(stated, {key: devices[key].identify() for key in stated})

    def by_table(self) -> dict[str, Identifiable]:
        """Return every device by its table in the rig file (``axes.pitch``)."""
        return self._groups.devices.by_table()

    def close(self) -> None:
        """Give ports and locks back; closing twice is harmless.

        Nothing is moved; what is not known to stand is stopped.
        """
        try:
            if self._guard is not None:
                self._guard.close()
            self._groups.close()
        finally:
            self._held.close()

    def __enter__(self) -> "Rig":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def open_rig(
    description: RigDescription,
    *,
    clock: Clock | None = None,
    rig_file: Path | None = None,
    purpose: str = "calrig",
    line_source: LineSource | None = None,
    faults: FaultPlan | None = None,
    tell_fault: Callable[[str], None] = lambda _sentence: None,
    write: WriteFile | None = None,
    claim: Claim = claimed_by_nobody_else,
    for_stop: bool = False,
) -> Rig:
    """Lock and open everything that the description names; nothing moves.

    ``line_source`` (:mod:`rig.lines.recording`) records or replays the lines.
    ``claim`` keeps other machines from what they reach as well; it is asked when this machine's locks are held.
    ``for_stop``: nothing is to move, and axes are to stop; what others must be able to see, and cannot where the disk
    of the machine folder is full, keeps nobody from it.
    ``faults`` go wrong on the twins' lines, and ``tell_fault`` hears of each.
    ``write`` keeps how far cables are wound; without it, real axes whose cables wind up refuse to turn.
    ``rig_file`` is locked as well where given, so that two commands do not drive twins of one file. Raises: RigBusy,
    LinkLost, DescriptionError, and what a device says at its first question.
    """
    refuse_crash_points(real_ports(description))
    clock = clock or choose_clock(description)
    with ExitStack() as held:
        lock_rig(description, rig_file, purpose, held, for_stop=for_stop)
        claim(known_elsewhere_as(real_ports(description)))
        world = World(description) if description.uses_twins else None
        served = twin_lines(description, world) if world else []
        if faults is not None and world is not None:
            served = with_faults(served, faults, world, clock.monotonic_s(), tell_fault)
        twins = {key: line.twin for line in served for key in line.keys}

        guard, memory = stop_guard(description, rig_file, purpose, for_stop=for_stop), MotionMemory()

        def lines_in(opened: ExitStack) -> Lines:
            return Lines(clock, twins, line_source, opened, guard.sign_of_life if guard else None)

        opener = GroupOpener(description, clock, lines_in, Supervisor(clock, memory=memory), write)
        groups = DeviceGroups(description, opener, guard, memory)
        return Rig(description, clock, groups, world, held.pop_all(), guard, purpose, claim, memory, for_stop=for_stop)


def choose_clock(description: RigDescription) -> Clock:
    """Return a clock, virtual, real or scaled, as ``[twin] time`` says.

    Raises: DescriptionError for virtual time at real ports.
    """
    twin = description.twin
    if twin is None or not description.is_simulated:
        return SystemClock()
    if isinstance(twin.time, float):
        return ScaledClock(twin.time)
    if twin.time == "real" or not description.uses_twins:
        return SystemClock()
    if real_ports(description):
        raise DescriptionError(
            f"twin: time: 'virtual' cannot be kept at a real port ({real_ports(description)[0]});"
            ' put every device on its twin, or set time = "real"'
        )
    return VirtualClock(SystemClock().now_utc())


def real_ports(description: RigDescription) -> list[str]:
    """Return every port that will really be opened, each once."""
    ports = [port for of_device in ports_by_device(description).values() for port in of_device]
    return [port for port in dict.fromkeys(ports) if port != TWIN_PORT]


def lock_rig(
    description: RigDescription, rig_file: Path | None, purpose: str, held: ExitStack, *, for_stop: bool = False
) -> RigLock:
    """Lock every real port and the rig file, until ``held`` closes. Raises: RigBusy naming the owner."""
    resources = [*real_ports(description), *([str(rig_file)] if rig_file else [])]
    return held.enter_context(acquire(resources, purpose, for_stop=for_stop))
