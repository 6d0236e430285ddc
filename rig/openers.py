"""How the devices of each driver are opened: the table that a new driver is added to, beside :mod:`rig.drivers`."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from rig.clock import Clock
from rig.devices import indexing_table, watlow_f4
from rig.devices.abilities import Axis, Environment, Readout
from rig.devices.hp3458a import Hp3458aReadout, Hp3458aSettings, scanner_resource
from rig.devices.indexing_table import IndexingTableSettings
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.errors import DescriptionError
from rig.lines import Lines
from rig.link.gpib import parse_resource
from rig.settings import AxisSettings, EnvironmentSettings, ReadoutSettings
from rig.wire.hp3458a import DEFAULT_ADDRESS

Settings = TypeVar("Settings")


def open_axes(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
    """The axes of one line. Raises: DescriptionError, LinkLost."""
    first = next(iter(axes))
    return _opener(AXES, axes[first].driver, f"axes.{first}")(axes, lines)


def open_readout(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    """Raises: DescriptionError, LinkLost, DeviceSilent, DeviceNonsense."""
    return _opener(READOUTS, settings.driver, f"readouts.{name}")(name, settings, lines, clock)


def open_environment(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    """Raises: DescriptionError, LinkLost."""
    return _opener(ENVIRONMENTS, settings.driver, f"environment.{name}")(name, settings, lines)


def _indexing_tables(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
    tables = {name: settings_as(IndexingTableSettings, axis) for name, axis in axes.items()}
    first = next(iter(tables))
    return indexing_table.connect(tables, lines.stream(f"axes.{first}", tables[first].port))


def _hp3458a(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    meter = settings_as(Hp3458aSettings, settings)
    meter_bus = lines.bus(f"readouts.{name}", parse_resource(meter.resource, DEFAULT_ADDRESS))
    scanner_bus = lines.bus(f"readouts.{name}", scanner_resource(meter))
    return Hp3458aReadout(name, meter, meter_bus, clock, scanner_bus)


def _watlow_f4(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    chamber = settings_as(WatlowF4Settings, settings)
    return watlow_f4.connect(name, chamber, lines.stream(f"environment.{name}", chamber.port, chamber.baud_rate))


AXES: Mapping[str, Callable[[Mapping[str, AxisSettings], Lines], Mapping[str, Axis]]] = {
    "indexing-table": _indexing_tables
}
READOUTS: Mapping[str, Callable[[str, ReadoutSettings, Lines, Clock], Readout]] = {"hp3458a": _hp3458a}
ENVIRONMENTS: Mapping[str, Callable[[str, EnvironmentSettings, Lines], Environment]] = {"watlow-f4": _watlow_f4}

Opener = TypeVar("Opener")


def _opener(openers: Mapping[str, Opener], driver: str, key: str) -> Opener:
    if driver not in openers:
        raise DescriptionError(f"{key}: driver: {driver!r} cannot be opened by this version; nothing was opened")
    return openers[driver]


def settings_as(kind: type[Settings], settings: object) -> Settings:
    """The driver's own settings: the table of drivers says that they are."""
    assert isinstance(settings, kind), f"{settings!r} is no {kind.__name__}"
    return settings
