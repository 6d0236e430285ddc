"""The one place that chooses: real device or twin, which clock, which chance; and that owns the rig's locks.

Everything is opened together or not at all, and given back in the opposite order.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import cast

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
from rig.abilities.setpoint_memory import carry_over
from rig.assembly.faulty_lines import with_faults
from rig.assembly.guard_of_rig import guarded_lines, stop_guard
from rig.assembly.identity import Identifiable, expected, require_expected, stranger_axes
from rig.cables.cable import CableGuard, TurningAxis
from rig.cables.cable_memory import memory_of
from rig.cables.winding import Machine
from rig.clock import Clock, ScaledClock, SystemClock, VirtualClock
from rig.crash_points import refuse_crash_points
from rig.description.device_settings import TWIN_PORT
from rig.description.fault_plan import FaultPlan
from rig.description.rig_file import RigDescription
from rig.drivers.open import open_axes, open_environment, open_field, open_readout, open_sample_stream
from rig.drivers.twin_lines import axis_lines, twin_lines
from rig.errors import DescriptionError, LinkLost
from rig.guard.stop_guard import GuardedLine, StopGuard
from rig.lines.lock import RigLock, acquire, is_on_network, known_elsewhere_as, serial_of
from rig.lines.open_lines import Lines
from rig.lines.recording import LineSource
from rig.link.counts import ExchangeCounts
from rig.link.gpib import port_of
from rig.motion.motion_memory import MotionMemory
from rig.motion.supervisor import Supervisor
from rig.twins.physics.world import World
from rig.twins.serving.control import RemoteChance
from rig.twins.twin import Twin

Claim = Callable[[Sequence[str]], None]
"""Take what other machines reach as well, by the names that they know it by too.

Raises: RigBusy where one of them has it.
"""


def claimed_by_nobody_else(_resources: Sequence[str]) -> None:
    """Claim nothing: no machine but this one is kept away."""


@dataclass(frozen=True)
class Connected:
    """The devices of a rig over lines that are open, and how to give the lines back."""

    axes: Mapping[str, Axis]
    readouts: Mapping[str, Readout]
    environments: Mapping[str, Environment]
    streams: Mapping[str, Stream]
    fields: Mapping[str, Field]
    chance: TwinChance
    counts: Callable[[], Mapping[str, ExchangeCounts]]
    guarded: tuple[GuardedLine, ...]
    """Real lines on which axes are that somebody else could stop."""
    lines: ExitStack


class Rig:
    """Open devices by the names of the rig file. A context manager."""

    def __init__(
        self,
        description: RigDescription,
        clock: Clock,
        connect: Callable[[], Connected],
        devices: Connected,
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
        self._connect = connect
        self._devices = devices
        self._answered_first: dict[str, str] = {}
        self._held = held
        self._guard = guard
        self._purpose = purpose
        self._claim = claim
        self._for_stop = for_stop
        self.motion = memory or MotionMemory()  # over all connections
        self._locked: set[str] = set()
        """Devices by their serial numbers."""
        if guard is not None:
            guard.hold(devices.guarded)

    @property
    def axes(self) -> Mapping[str, Axis]:
        return self._devices.axes

    @property
    def readouts(self) -> Mapping[str, Readout]:
        return self._devices.readouts

    @property
    def environments(self) -> Mapping[str, Environment]:
        return self._devices.environments

    @property
    def streams(self) -> Mapping[str, Stream]:
        return self._devices.streams

    @property
    def fields(self) -> Mapping[str, Field]:
        return self._devices.fields

    @property
    def chance(self) -> TwinChance:
        return self._devices.chance

    def link_counts(self) -> Mapping[str, ExchangeCounts]:
        """Return the counts of every line, by table, or by device where several share it (``axes.pitch, unit 2``)."""
        return self._devices.counts()

    def reconnect(self) -> None:
        """Close every line and open it again; drivers forget all but what chambers were set to, locks and twins stay.
        Nothing moves. Where it fails, the lines are closed and it can be tried again. Raises as :func:`open_rig`.
        """
        if self._guard is not None:
            self._guard.release()
        self._close_lines()
        before, self._devices = self._devices.environments, self._connect()
        carry_over(before, self._devices.environments)
        if self._guard is not None:
            self._guard.hold(self._devices.guarded)

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
        self._answered_first = self._answered_first or found
        return found

    def stranger_axes(self) -> dict[str, str]:
        """Return axis to a sentence where another device answers than :meth:`identities` found first."""
        return stranger_axes(self.axes, self._answered_first)

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
        tables: dict[str, Mapping[str, Axis | Readout | Environment | Stream | Field]] = {
            "axes": dict(self.axes),
            "readouts": dict(self.readouts),
            "environment": dict(self.environments),
            "streams": dict(self.streams),
            "field": dict(self.fields),
        }
        return {f"{table}.{name}": device for table, devices in tables.items() for name, device in devices.items()}

    def close(self) -> None:
        """Give ports and locks back; closing twice is harmless.

        Nothing is moved; what is not known to stand is stopped.
        """
        try:
            if self._guard is not None:
                self._guard.close()
            self._close_lines()
        finally:
            self._held.close()

    def _close_lines(self) -> None:
        """Close the lines; a port that is gone cannot be closed properly, and need not be."""
        with suppress(LinkLost):
            self._devices.lines.close()

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

        def connect() -> Connected:
            return _connected(description, clock, world, twins, line_source, guard, write, memory)

        return Rig(
            description, clock, connect, connect(), held.pop_all(), guard, purpose, claim, memory, for_stop=for_stop
        )


def _connected(
    description: RigDescription,
    clock: Clock,
    world: World | None,
    twins: Mapping[str, Twin],
    line_source: LineSource | None,
    guard: StopGuard | None,
    write: WriteFile | None,
    memory: MotionMemory,
) -> Connected:
    """Open every device over lines of its own, or none."""
    with ExitStack() as opened:
        lines = Lines(clock, twins, line_source, opened, guard.sign_of_life if guard else None)
        found: dict[str, Axis] = {}
        line_of: dict[str, str] = {}
        for names in axis_lines(description.axes):
            found |= open_axes({name: description.axes[name] for name in names}, lines)
            line_of |= dict.fromkeys(names, names[0])
        over_ports = guarded_lines(description, found, lines)
        supervisor = Supervisor(clock, guard if over_ports else None, memory)
        homes_deg = {name: settings.home_attitude_deg for name, settings in description.axes.items()}
        bear = {name: settings.wrap_turns for name, settings in description.axes.items()}
        supervised = {
            name: supervisor.supervise(axis, homes_deg[name], line_of[name], bear[name]) for name, axis in found.items()
        }
        found = {name: guarded(axis, description, name, clock, write) for name, axis in supervised.items()}
        return Connected(
            axes={name: found[name] for name in description.axes},
            readouts={
                name: open_readout(name, settings, lines, clock) for name, settings in description.readouts.items()
            },
            environments={
                name: open_environment(name, settings, lines) for name, settings in description.environment.items()
            },
            streams={
                name: open_sample_stream(name, settings, lines, clock) for name, settings in description.streams.items()
            },
            fields={name: open_field(name, settings, lines) for name, settings in description.field.items()},
            chance=world or _remote_chance(description, lines),
            counts=lines.counts,
            guarded=over_ports,
            lines=opened.pop_all(),
        )


def guarded(axis: Axis, description: RigDescription, name: str, clock: Clock, write: WriteFile | None) -> Axis:
    """Return an axis that remembers how far its cables are wound, where they wind. Raises: DescriptionError."""
    settings = description.axes[name]
    if settings.wrap_turns is None or settings.turning != "revolves":
        return axis
    memory = memory_of(description.rig.name, name, settings, write)
    counts = Machine(settings.home_attitude_deg, settings.position_wraps)
    return CableGuard(cast("TurningAxis", axis), settings.wrap_turns, memory, clock, counts)


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
    ports = [axis.port for axis in description.axes.values()]
    ports += [chamber.port for chamber in description.environment.values()]
    ports += [stream.port for stream in description.streams.values()]
    ports += [coil.port for coil in description.field.values()]
    for readout in description.readouts.values():
        resources = (getattr(readout, "resource", None), getattr(readout, "scanner_resource", None))
        ports += [port_of(resource) for resource in resources if resource is not None]
    return [port for port in dict.fromkeys(ports) if port != TWIN_PORT]


def lock_rig(
    description: RigDescription, rig_file: Path | None, purpose: str, held: ExitStack, *, for_stop: bool = False
) -> RigLock:
    """Lock every real port and the rig file, until ``held`` closes. Raises: RigBusy naming the owner."""
    resources = [*real_ports(description), *([str(rig_file)] if rig_file else [])]
    return held.enter_context(acquire(resources, purpose, for_stop=for_stop))


def _remote_chance(description: RigDescription, lines: Lines) -> TwinChance:
    control = description.twin and description.twin.control
    return RemoteChance(lines.stream("twin.control", control)) if control else NoChance()
