"""The one place that chooses: real device or twin, which clock, which chance; and that owns the rig's locks.

Everything is opened together or not at all, and given back in the opposite order.
"""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from rig.bench import axis_lines, twin_lines
from rig.clock import Clock, ScaledClock, SystemClock, VirtualClock
from rig.description import RigDescription
from rig.devices import indexing_table, watlow_f4
from rig.devices.abilities import Axis, Environment, NoChance, Readout, TwinChance
from rig.devices.hp3458a import Hp3458aReadout, Hp3458aSettings, scanner_resource
from rig.devices.indexing_table import IndexingTableSettings
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.errors import DescriptionError
from rig.kept_lines import LineSource
from rig.link.byte_stream import ByteStream
from rig.link.gpib import GpibBus, GpibResource, parse_resource
from rig.link.memory import MemoryStream
from rig.link.ports import open_stream
from rig.link.prologix import PrologixBus
from rig.lock import RigLock, acquire, canonical
from rig.settings import TWIN_PORT
from rig.twins.control import RemoteChance
from rig.twins.world import World
from rig.wire.hp3458a import DEFAULT_ADDRESS


class Rig:
    """Open devices by the names of the rig file. A context manager."""

    def __init__(
        self,
        description: RigDescription,
        *,
        axes: Mapping[str, Axis],
        readouts: Mapping[str, Readout],
        environments: Mapping[str, Environment],
        chance: TwinChance,
        clock: Clock,
        resources: ExitStack,
    ) -> None:
        self.description = description
        self.axes = axes
        self.readouts = readouts
        self.environments = environments
        self.chance = chance
        self.clock = clock
        self._resources = resources

    def identities(self) -> dict[str, str]:
        """Who every device says it is, by table (``axes.pitch``). Raises: DeviceSilent, DeviceNonsense, LinkLost."""
        tables: dict[str, Mapping[str, Axis | Readout | Environment]] = {
            "axes": dict(self.axes),
            "readouts": dict(self.readouts),
            "environment": dict(self.environments),
        }
        return {
            f"{table}.{name}": device.identify()
            for table, devices in tables.items()
            for name, device in devices.items()
        }

    def close(self) -> None:
        """Give ports and locks back; closing twice is harmless. Nothing is moved or stopped."""
        self._resources.close()

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
) -> Rig:
    """Lock and open everything that the description names; nothing moves.

    ``line_source`` (:mod:`rig.kept_lines`) records or replays the lines.
    ``rig_file`` is locked as well where given, so that two commands do not drive twins of one file. Raises: RigBusy,
    LinkLost, DescriptionError, and what a device says at its first question.
    """
    clock = clock or choose_clock(description)
    with ExitStack() as opened:
        lock_rig(description, rig_file, purpose, opened)
        world = World(description) if description.uses_twins else None
        opening = _Opening(description, clock, world, line_source or _as_it_is, opened)
        return Rig(
            description,
            axes=opening.axes(),
            readouts=opening.readouts(),
            environments=opening.environments(),
            chance=opening.chance(),
            clock=clock,
            resources=opened.pop_all(),
        )


def choose_clock(description: RigDescription) -> Clock:
    """Virtual, real or scaled, as ``[twin] time`` says. Raises: DescriptionError for virtual time at real ports."""
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
    """Every port that will really be opened, each once."""
    ports = [axis.port for axis in description.axes.values()]
    ports += [chamber.port for chamber in description.environment.values()]
    for readout in description.readouts.values():
        if isinstance(readout, Hp3458aSettings):
            ports += [parse_resource(readout.resource, DEFAULT_ADDRESS).port, scanner_resource(readout).port]
    return [port for port in dict.fromkeys(ports) if port != TWIN_PORT]


def lock_rig(description: RigDescription, rig_file: Path | None, purpose: str, held: ExitStack) -> RigLock:
    """Every real port and the rig file, until ``held`` closes. Raises: RigBusy naming the owner."""
    resources = real_ports(description) + ([str(rig_file)] if rig_file is not None else [])
    return held.enter_context(acquire(resources, purpose))


class _Opening:
    """Opens lines as devices need them, each line once."""

    def __init__(
        self, description: RigDescription, clock: Clock, world: World | None, source: LineSource, opened: ExitStack
    ) -> None:
        self._description = description
        self._clock = clock
        self._world = world
        self._source = source
        self._opened = opened
        self._streams: dict[str, ByteStream] = {}
        self._buses: dict[tuple[str, str], GpibBus] = {}
        lines = twin_lines(description, world) if world is not None else []
        self._twins = {key: line for line in lines for key in line.keys}

    def axes(self) -> dict[str, Axis]:
        described = self._description.axes
        found: dict[str, Axis] = {}
        for line in axis_lines(described):
            tables = {name: described[name] for name in line}
            indexing = {name: axis for name, axis in tables.items() if isinstance(axis, IndexingTableSettings)}
            if len(indexing) < len(tables):
                raise _no_driver(f"axes.{line[0]}", tables[line[0]].driver)
            found |= indexing_table.connect(indexing, self._stream(f"axes.{line[0]}", tables[line[0]].port))
        return {name: found[name] for name in described}

    def readouts(self) -> dict[str, Readout]:
        found: dict[str, Readout] = {}
        for name, settings in self._description.readouts.items():
            if not isinstance(settings, Hp3458aSettings):
                raise _no_driver(f"readouts.{name}", settings.driver)
            meter = self._bus(f"readouts.{name}", parse_resource(settings.resource, DEFAULT_ADDRESS))
            scanner = self._bus(f"readouts.{name}", scanner_resource(settings))
            found[name] = Hp3458aReadout(name, settings, meter, self._clock, scanner)
        return found

    def environments(self) -> dict[str, Environment]:
        found: dict[str, Environment] = {}
        for name, settings in self._description.environment.items():
            if not isinstance(settings, WatlowF4Settings):
                raise _no_driver(f"environment.{name}", settings.driver)
            stream = self._stream(f"environment.{name}", settings.port, settings.baud_rate)
            found[name] = watlow_f4.connect(name, settings, stream)
        return found

    def chance(self) -> TwinChance:
        if self._world is not None:
            return self._world
        control = self._description.twin.control if self._description.twin else None
        return RemoteChance(self._stream("twin.control", control)) if control else NoChance()

    def _bus(self, key: str, resource: GpibResource) -> GpibBus:
        """The controller that carries an instrument; instruments of one adapter share it."""
        place = (key if resource.carrier == "twin" else resource.carrier, resource.port)
        if place not in self._buses:
            self._buses[place] = self._open_bus(key, resource)
            self._opened.callback(self._buses[place].close)
        return self._buses[place]

    def _open_bus(self, key: str, resource: GpibResource) -> GpibBus:
        if resource.carrier == "visa":
            from rig.link.visa import VisaBus

            return VisaBus(resource.port, SystemClock())
        return PrologixBus(self._stream(key, resource.port))

    def _stream(self, key: str, port: str, baud_rate: int = 9600) -> ByteStream:
        """The line to ``port``, opened once; a twin's is in memory and named by its device."""
        name = f"twin of {key}" if port == TWIN_PORT else canonical(port)
        if name not in self._streams:
            stream = self._source(key, lambda: self._open(key, port, baud_rate))
            self._opened.callback(stream.close)
            self._streams[name] = stream
        return self._streams[name]

    def _open(self, key: str, port: str, baud_rate: int) -> ByteStream:
        if port == TWIN_PORT:
            return MemoryStream(self._twins[key].twin, self._clock, f"twin of {key}")
        return open_stream(port, clock=SystemClock(), baud_rate=baud_rate)


def _as_it_is(_key: str, open_line: Callable[[], ByteStream]) -> ByteStream:
    return open_line()


def _no_driver(key: str, driver: str) -> DescriptionError:
    return DescriptionError(f"{key}: driver {driver!r} cannot be opened by this version; nothing was opened")
