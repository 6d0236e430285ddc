"""The devices of an open rig, group by group: what shares a port is opened together, and waits for no other group.

So an adapter that stays away keeps no axis from its stop. The groups of axes that were told to turn, and were not seen
at rest since, come first, and each such axis is told to stop as soon as its line is open.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from typing import Any, cast

from rig.abilities.abilities import Axis, Environment, Field, Readout, Stream, TwinChance, WriteFile
from rig.abilities.setpoint_memory import carry_over
from rig.assembly.guard_of_rig import guarded_lines
from rig.assembly.identity import Identifiable
from rig.cables.cable import CableGuard, TurningAxis
from rig.cables.cable_memory import memory_of
from rig.cables.winding import Machine
from rig.clock import Clock
from rig.description.device_settings import TWIN_PORT
from rig.description.rig_file import RigDescription
from rig.drivers.open import open_axes, open_environment, open_field, open_readout, open_sample_stream
from rig.drivers.twin_lines import axis_lines
from rig.errors import LinkClosed, LinkLost, RigError
from rig.guard.stop_guard import GuardedLine, StopGuard
from rig.lines.lock import canonical
from rig.lines.open_lines import Lines
from rig.link.counts import ExchangeCounts
from rig.link.gpib import port_of
from rig.motion.motion_memory import MotionMemory
from rig.motion.supervisor import Supervisor
from rig.twins.serving.control import RemoteChance

CONTROL = "twin.control"


@dataclass(slots=True)
class DeviceTables:
    """Devices by name, table by table. What was opened anew takes the place of what it was."""

    axes: dict[str, Axis]
    readouts: dict[str, Readout]
    environments: dict[str, Environment]
    streams: dict[str, Stream]
    fields: dict[str, Field]

    def update(self, others: "DeviceTables") -> None:
        self.axes.update(others.axes)
        self.readouts.update(others.readouts)
        self.environments.update(others.environments)
        self.streams.update(others.streams)
        self.fields.update(others.fields)

    def in_order_of(self, description: RigDescription) -> "DeviceTables":
        """Return the same devices in the order of the rig file."""
        return DeviceTables(
            {name: self.axes[name] for name in description.axes},
            {name: self.readouts[name] for name in description.readouts},
            {name: self.environments[name] for name in description.environment},
            {name: self.streams[name] for name in description.streams},
            {name: self.fields[name] for name in description.field},
        )

    def by_table(self) -> dict[str, Identifiable]:
        """Return every device by its table in the rig file (``axes.pitch``)."""
        tables: dict[str, Mapping[str, Identifiable]] = {
            "axes": self.axes,
            "readouts": self.readouts,
            "environment": self.environments,
            "streams": self.streams,
            "field": self.fields,
        }
        return {f"{table}.{name}": device for table, devices in tables.items() for name, device in devices.items()}


@dataclass(frozen=True, slots=True)
class OpenedGroup:
    """The devices of one group, over lines that were opened, and how to give the lines back."""

    devices: DeviceTables
    chance: TwinChance | None
    """What the group's line tells twins elsewhere; None of a group without such a line."""
    guarded: tuple[GuardedLine, ...]
    """Real lines on which axes are that somebody else could stop."""
    counts: Callable[[], Mapping[str, ExchangeCounts]]
    is_any_lost: Callable[[], bool]
    """Whether one of the lines was found to be gone."""
    lines: ExitStack


@dataclass(frozen=True, slots=True)
class GroupOpener:
    """What devices need beside their keys. ``lines_in``: makes lines that are given back with the stack."""

    description: RigDescription
    clock: Clock
    lines_in: Callable[[ExitStack], Lines]
    supervisor: Supervisor
    write: WriteFile | None

    def open(self, keys: Sequence[str]) -> OpenedGroup:
        """Open the devices of a group, or none. Raises as :func:`rig.assembly.open_rig.open_rig`."""
        description, clock = self.description, self.clock

        def chosen(table: str, settings: Mapping[str, Any]) -> dict[str, Any]:
            return {name: its for name, its in settings.items() if f"{table}.{name}" in keys}

        with ExitStack() as opened:
            lines = self.lines_in(opened)
            axes, guarded = self._axes(chosen("axes", description.axes), lines)
            readouts, streams = chosen("readouts", description.readouts), chosen("streams", description.streams)
            chambers, fields = chosen("environment", description.environment), chosen("field", description.field)
            devices = DeviceTables(
                axes,
                {name: open_readout(name, settings, lines, clock) for name, settings in readouts.items()},
                {name: open_environment(name, settings, lines) for name, settings in chambers.items()},
                {name: open_sample_stream(name, settings, lines, clock) for name, settings in streams.items()},
                {name: open_field(name, settings, lines) for name, settings in fields.items()},
            )
            control = description.twin and description.twin.control
            chance = RemoteChance(lines.stream(CONTROL, control)) if control and CONTROL in keys else None
            return OpenedGroup(devices, chance, guarded, lines.counts, lines.is_any_lost, opened.pop_all())

    def _axes(self, settings: Mapping[str, Any], lines: Lines) -> tuple[dict[str, Axis], tuple[GuardedLine, ...]]:
        found: dict[str, Axis] = {}
        line_of: dict[str, str] = {}
        for names in axis_lines(settings):
            found |= open_axes({name: settings[name] for name in names}, lines)
            line_of |= dict.fromkeys(names, names[0])
        homes = {name: its.home_attitude_deg if its.moves_to_home else None for name, its in settings.items()}
        supervised = {
            name: self.supervisor.supervise(found[name], homes[name], line_of[name], its.wrap_turns)
            for name, its in settings.items()
        }
        axes = {name: self._with_cables(axis, name) for name, axis in supervised.items()}
        return axes, guarded_lines(self.description, found, lines)

    def _with_cables(self, axis: Axis, name: str) -> Axis:
        """Return an axis that remembers how far its cables are wound, where they wind. Raises: DescriptionError."""
        settings = self.description.axes[name]
        if settings.wrap_turns is None or settings.turning != "revolves":
            return axis
        memory = memory_of(self.description.rig.name, name, settings, self.write)
        counts = Machine(settings.home_attitude_deg, settings.position_wraps)
        return CableGuard(cast("TurningAxis", axis), settings.wrap_turns, memory, self.clock, counts)


class DeviceGroup:
    """One group over all its openings."""

    def __init__(self, keys: Sequence[str], opener: GroupOpener) -> None:
        """Open it. Raises as :func:`rig.assembly.open_rig.open_rig`."""
        self.name = keys[0]
        self._keys, self._opener = tuple(keys), opener
        self.opened = opener.open(self._keys)
        self.is_open = True
        self.why_closed: RigError = LinkLost(f"{self.name}: its line is closed; open it again")
        """What the last attempt to open it met, where it is not open."""

    def open(self) -> None:
        """Open what is closed: drivers forget all but what chambers were set to. Raises: RigError; it stays closed."""
        before, self.opened = self.opened, self._opener.open(self._keys)
        carry_over(before.devices.environments, self.opened.devices.environments)
        self.is_open = True

    def close(self) -> None:
        """Close the lines; a port that is gone cannot be closed properly, and need not be."""
        self.is_open = False
        with suppress(LinkLost):
            self.opened.lines.close()

    def is_lost(self) -> bool:
        """Return whether a line was found to be gone, or is when its devices are asked; one that is silent is there."""
        if not self.is_open or self.opened.is_any_lost():
            return True
        for device in self.opened.devices.by_table().values():
            try:
                device.identify()
            except (LinkLost, LinkClosed):
                return True
            except RigError:
                continue
        return False

    @property
    def guarded(self) -> tuple[GuardedLine, ...]:
        """Lines for the stop guard: which opens one that is closed here by its address, when it has to."""
        if self.is_open:
            return self.opened.guarded
        return tuple(replace(line, descriptor=None) for line in self.opened.guarded)


class DeviceGroups:
    """All of a rig."""

    def __init__(
        self, description: RigDescription, opener: GroupOpener, guard: StopGuard | None, memory: MotionMemory
    ) -> None:
        """Open all groups or none. Raises as :func:`rig.assembly.open_rig.open_rig`."""
        self._clock, self._memory = opener.clock, memory
        self._groups: list[DeviceGroup] = []
        with ExitStack() as opened:
            for keys in _keys_of_groups(description):
                self._groups.append(DeviceGroup(keys, opener))
                opened.callback(self._groups[-1].close)
            opened.pop_all()
        opened_devices = DeviceTables({}, {}, {}, {}, {})
        for group in self._groups:
            opened_devices.update(group.opened.devices)
        self.devices = opened_devices.in_order_of(description)
        self._guard = guard
        opener.supervisor.warden = guard if any(group.guarded for group in self._groups) else None
        self._hold()

    @property
    def chance(self) -> TwinChance | None:
        return next((group.opened.chance for group in self._groups if group.opened.chance is not None), None)

    def counts(self) -> dict[str, ExchangeCounts]:
        return {name: counts for group in self._groups for name, counts in group.opened.counts().items()}

    def renew(self) -> list[RigError]:
        """Close every line and open it anew; return what kept which from that, of each group that stays closed.

        Behind an attempt at which one stayed away only what is closed, or was lost since, is opened.
        """
        if all(group.is_open for group in self._groups):
            if self._guard is not None:
                self._guard.release()
            self.close()
        turning, others = self._by_urgency()
        return [*self._opened(turning), *self._opened(others)]

    def open_lost(self, until_s: float) -> list[RigError]:
        """Open the groups that are closed or lost, and leave the others as they are; return as :meth:`renew`.

        While an axis that turns stays away nothing else is opened. No group is begun after ``until_s``, rig seconds.
        """
        turning, others = self._by_urgency()
        return self._opened(turning, until_s) or self._opened(others, until_s)

    def close(self) -> None:
        """Close every line; closing twice is harmless."""
        for group in reversed(self._groups):
            group.close()

    def _by_urgency(self) -> tuple[list[DeviceGroup], list[DeviceGroup]]:
        """Return the groups in which an axis turns, as far as is known, and the others."""
        turning = [group for group in self._groups if self._turning_in(group)]
        return turning, [group for group in self._groups if group not in turning]

    def _turning_in(self, group: DeviceGroup) -> list[Axis]:
        return [axis for name, axis in group.opened.devices.axes.items() if self._memory.known(name).is_turn]

    def _opened(self, groups: Iterable[DeviceGroup], until_s: float | None = None) -> list[RigError]:
        failures: list[RigError] = []
        for group in groups:
            if until_s is not None and self._clock.monotonic_s() >= until_s:
                failures += [] if group.is_open else [group.why_closed]
                continue
            if not group.is_lost():
                continue
            group.close()
            if group.guarded:  # the guard may have opened it for a stop meanwhile: it gives that back as well
                self._hold()
            try:
                group.open()
            except RigError as error:
                group.why_closed = error
                failures.append(error)
                continue
            self.devices.update(group.opened.devices)
            try:
                self._stop_turning_in(group)
            except LinkLost as error:
                group.close()
                group.why_closed = error
                failures.append(error)
            self._hold()
        return failures

    def _stop_turning_in(self, group: DeviceGroup) -> None:
        """Tell what turns to stop. Raises: LinkLost where the line broke again at once."""
        for axis in self._turning_in(group):
            try:
                axis.stop()
            except LinkLost:
                raise
            except RigError:
                continue  # who opens lines sees it stand, and tells what fails

    def _hold(self) -> None:
        """Let the stop guard hold the lines as they are now."""
        if self._guard is not None:
            self._guard.hold([line for group in self._groups for line in group.guarded])


def ports_by_device(description: RigDescription) -> dict[str, tuple[str, ...]]:
    """Return the ports of every device by its table (``axes.pitch``), twins' as well."""
    found: dict[str, tuple[str, ...]] = {f"axes.{name}": (axis.port,) for name, axis in description.axes.items()}
    found |= {f"environment.{name}": (chamber.port,) for name, chamber in description.environment.items()}
    found |= {f"streams.{name}": (stream.port,) for name, stream in description.streams.items()}
    found |= {f"field.{name}": (coil.port,) for name, coil in description.field.items()}
    for name, readout in description.readouts.items():
        resources = (getattr(readout, "resource", None), getattr(readout, "scanner_resource", None))
        found[f"readouts.{name}"] = tuple(port_of(resource) for resource in resources if resource is not None)
    return found


def _keys_of_groups(description: RigDescription) -> list[list[str]]:
    """Return which devices are opened together: axes of one line, and whatever shares a real port."""
    ports = ports_by_device(description)
    lines = [[f"axes.{name}" for name in names] for names in axis_lines(description.axes)]
    tables = ("readouts", "environment", "streams", "field")
    lines += [[key] for table in tables for key in ports if key.startswith(f"{table}.")]
    if description.twin and description.twin.control:
        lines.append([CONTROL])
        ports[CONTROL] = (description.twin.control,)
    groups: list[tuple[list[str], set[str]]] = []
    for keys in lines:
        shared = {canonical(port) for key in keys for port in ports[key] if port != TWIN_PORT}
        joined = [group for group in groups if group[1] & shared]
        groups = [group for group in groups if group not in joined]
        merged = [key for group in joined for key in group[0]]
        groups.append(([*merged, *keys], shared.union(*(group[1] for group in joined))))
    return [keys for keys, _ in groups]
