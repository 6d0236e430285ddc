"""How the devices of each driver are opened: the table that a new driver is added to, beside
:mod:`rig.description.driver_names`."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from rig.clock import Clock
from rig.description.device_settings import (
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
    StreamSettings,
)
from rig.description.driver_names import Ability, registered_part
from rig.devices import (
    csv_imu,
    esp301,
    indexing_table,
    maestro,
    manual,
    manual_field,
    oriental_az,
    vn100,
    watlow_f4,
    watlow_f4t,
    zaber,
)
from rig.devices.abilities import Axis, Environment, Field, Readout, Stream
from rig.devices.csv_imu import CsvImuSettings
from rig.devices.esp301 import Esp301Settings
from rig.devices.hp3458a import Hp3458aReadout, Hp3458aSettings, scanner_resource
from rig.devices.indexing_table import IndexingTableSettings
from rig.devices.maestro import MaestroSettings
from rig.devices.manual import ManualSettings
from rig.devices.oriental_az import OrientalAzSettings
from rig.devices.scpi_daq import DEFAULT_ADDRESS as DAQ_ADDRESS
from rig.devices.scpi_daq import ScpiDaqReadout, ScpiDaqSettings
from rig.devices.vn100 import Vn100Settings
from rig.devices.watlow_f4 import WatlowF4Settings
from rig.devices.watlow_f4t import WatlowF4TSettings
from rig.devices.zaber import ZaberSettings
from rig.errors import DescriptionError
from rig.lines.open_lines import Lines
from rig.link.byte_stream import ByteStream
from rig.link.gpib import is_on_a_bus, parse_resource
from rig.link.messages import GpibMessages, MessageLine, StreamMessages
from rig.wire.hp3458a import DEFAULT_ADDRESS

Settings = TypeVar("Settings")
Kind = TypeVar("Kind", bound=AxisSettings)
AxesOpener = Callable[[Mapping[str, AxisSettings], Lines], Mapping[str, Axis]]
LINE_SETTINGS = ("baud_rate", "parity", "rts_cts", "data_bits", "stop_bits")


def open_axes(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
    """The axes of one line. Raises: DescriptionError, LinkLost."""
    first = next(iter(axes))
    return _opener("axes", AXES, axes[first].driver, f"axes.{first}")(axes, lines)


def open_readout(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    """Raises: DescriptionError, LinkLost, DeviceSilent, DeviceNonsense."""
    return _opener("readouts", READOUTS, settings.driver, f"readouts.{name}")(name, settings, lines, clock)


def open_environment(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    """Raises: DescriptionError, LinkLost."""
    return _opener("environments", ENVIRONMENTS, settings.driver, f"environment.{name}")(name, settings, lines)


def open_sample_stream(name: str, settings: StreamSettings, lines: Lines, clock: Clock) -> Stream:
    """Raises: DescriptionError, LinkLost."""
    return _opener("streams", STREAMS, settings.driver, f"streams.{name}")(name, settings, lines, clock)


def open_field(name: str, settings: FieldSettings, lines: Lines) -> Field:
    """Raises: DescriptionError, LinkLost."""
    return _opener("fields", FIELDS, settings.driver, f"field.{name}")(name, settings, lines)


def _axes_of(kind: type[Kind], connect: Callable[[Mapping[str, Kind], ByteStream], Mapping[str, Axis]]) -> AxesOpener:
    """The opener of a driver whose axes share a line; baud rate, parity and handshake where its settings have them."""

    def open_line(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
        own = {name: settings_as(kind, axis) for name, axis in axes.items()}
        first = next(iter(own))
        line = {name: value for name in LINE_SETTINGS if (value := getattr(own[first], name, None)) is not None}
        return connect(own, lines.stream(f"axes.{first}", own[first].port, **line))

    return open_line


def _hp3458a(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    meter = settings_as(Hp3458aSettings, settings)
    meter_bus = lines.bus(f"readouts.{name}", parse_resource(meter.resource, DEFAULT_ADDRESS))
    scanner_bus = lines.bus(f"readouts.{name}", scanner_resource(meter))
    return Hp3458aReadout(name, meter, meter_bus, clock, scanner_bus)


def _watlow_f4(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    chamber = settings_as(WatlowF4Settings, settings)
    return watlow_f4.connect(name, chamber, lines.stream(f"environment.{name}", chamber.port, chamber.baud_rate))


def _watlow_f4t(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    chamber = settings_as(WatlowF4TSettings, settings)
    return watlow_f4t.connect(name, chamber, lines.stream(f"environment.{name}", chamber.port, chamber.baud_rate))


def _scpi_daq(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    daq = settings_as(ScpiDaqSettings, settings)
    key = f"readouts.{name}"
    line: MessageLine
    if is_on_a_bus(daq.resource):
        resource = parse_resource(daq.resource, DAQ_ADDRESS)
        line = GpibMessages(lines.bus(key, resource), resource.address)
    else:
        line = StreamMessages(lines.stream(key, daq.resource))
    return ScpiDaqReadout(name, daq, line, clock)


def _vn100(name: str, settings: StreamSettings, lines: Lines, clock: Clock) -> Stream:
    unit = settings_as(Vn100Settings, settings)
    return vn100.connect(name, unit, lines.stream(f"streams.{name}", unit.port, unit.baud_rate), clock)


def _csv_imu(name: str, settings: StreamSettings, lines: Lines, clock: Clock) -> Stream:
    board = settings_as(CsvImuSettings, settings)
    line = lines.stream(f"streams.{name}", board.port, board.baud_rate, dtr_low=board.dtr_low, rts_low=board.rts_low)
    return csv_imu.connect(name, board, line, clock)


def _manual_field(name: str, settings: FieldSettings, lines: Lines) -> Field:
    return manual_field.connect(name, settings, lines.stream(f"field.{name}", settings.port))


AXES: Mapping[str, AxesOpener] = {
    "esp301": _axes_of(Esp301Settings, esp301.connect),
    "indexing-table": _axes_of(IndexingTableSettings, indexing_table.connect),
    "maestro": _axes_of(MaestroSettings, maestro.connect),
    "manual": _axes_of(ManualSettings, manual.connect),
    "oriental-az": _axes_of(OrientalAzSettings, oriental_az.connect),
    "zaber": _axes_of(ZaberSettings, zaber.connect),
}
READOUTS: Mapping[str, Callable[[str, ReadoutSettings, Lines, Clock], Readout]] = {
    "hp3458a": _hp3458a,
    "scpi-daq": _scpi_daq,
}
ENVIRONMENTS: Mapping[str, Callable[[str, EnvironmentSettings, Lines], Environment]] = {
    "watlow-f4": _watlow_f4,
    "watlow-f4t": _watlow_f4t,
}
STREAMS: Mapping[str, Callable[[str, StreamSettings, Lines, Clock], Stream]] = {"csv-imu": _csv_imu, "vn100": _vn100}
FIELDS: Mapping[str, Callable[[str, FieldSettings, Lines], Field]] = {"manual": _manual_field}

Opener = TypeVar("Opener")


def _opener(ability: Ability, openers: Mapping[str, Opener], driver: str, key: str) -> Opener:
    opener: Opener | None = openers.get(driver) or registered_part(ability, "open", driver)
    if opener is None:
        raise DescriptionError(f"{key}: driver: {driver!r} cannot be opened by this version; nothing was opened")
    return opener


def settings_as(kind: type[Settings], settings: object) -> Settings:
    """The driver's own settings: the table of drivers says that they are."""
    assert isinstance(settings, kind), f"{settings!r} is no {kind.__name__}"
    return settings
