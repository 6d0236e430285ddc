"""What a driver is: one object with the settings, the opener and the twin of every kind of device it drives.

Codec (:mod:`rig.wire`), device (:mod:`rig.devices`) and twin (:mod:`rig.twins`) stay apart; the driver's file in this
room brings them together and is registered under ``calrig.drivers``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from rig.abilities.abilities import Axis, Environment, Field, Readout, Stream
from rig.clock import Clock
from rig.description.device_settings import (
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
    StreamSettings,
)
from rig.description.drivers import Ability, DescribedDriver
from rig.errors import DescriptionError
from rig.lines.open_lines import Lines
from rig.link.byte_stream import ByteStream
from rig.registry import Registry
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.physics.world import World
from rig.twins.twin import Twin

OfAxes = TypeVar("OfAxes", bound=AxisSettings)
OfReadout = TypeVar("OfReadout", bound=ReadoutSettings)
OfEnvironment = TypeVar("OfEnvironment", bound=EnvironmentSettings)
OfStream = TypeVar("OfStream", bound=StreamSettings)
OfField = TypeVar("OfField", bound=FieldSettings)
LINE_SETTINGS = ("baud_rate", "parity", "rts_cts", "data_bits", "stop_bits")


@dataclass(frozen=True)
class AxesDriver(Generic[OfAxes]):
    """Axes, those of one line opened together; so is their twin. A ``twin`` of None: there is none."""

    settings: type[OfAxes]
    open: Callable[[Mapping[str, OfAxes], Lines], Mapping[str, Axis]]
    """Raises: DescriptionError, LinkLost."""
    twin: Callable[[Mapping[str, OfAxes], World, float], Twin] | None = None
    """From the axes of one line, the world and the rig seconds in a second of the line."""


@dataclass(frozen=True)
class ReadoutDriver(Generic[OfReadout]):
    """A readout; its twin comes with how the rig file writes the address, such as ``{port}``."""

    settings: type[OfReadout]
    open: Callable[[str, OfReadout, Lines, Clock], Readout]
    """Raises: DescriptionError, LinkLost, DeviceSilent, DeviceNonsense."""
    twin: Callable[[str, OfReadout, World], tuple[Twin, str]] | None = None


@dataclass(frozen=True)
class EnvironmentDriver(Generic[OfEnvironment]):
    """A chamber or an oven; its twin takes the rig seconds in a second of the line as well."""

    settings: type[OfEnvironment]
    open: Callable[[str, OfEnvironment, Lines], Environment]
    """Raises: DescriptionError, LinkLost."""
    twin: Callable[[str, OfEnvironment, World, float], Twin] | None = None


@dataclass(frozen=True)
class StreamDriver(Generic[OfStream]):
    """A unit that sends by itself; its twin is strapped to the table."""

    settings: type[OfStream]
    open: Callable[[str, OfStream, Lines, Clock], Stream]
    """Raises: DescriptionError, LinkLost."""
    twin: Callable[[str, OfStream, StrappedDown], Twin] | None = None


@dataclass(frozen=True)
class FieldDriver(Generic[OfField]):
    """A coil or a magnet."""

    settings: type[OfField]
    open: Callable[[str, OfField, Lines], Field]
    """Raises: DescriptionError, LinkLost."""
    twin: Callable[[str, OfField, World], Twin] | None = None


@dataclass(frozen=True)
class Driver(DescribedDriver):
    """One driver, by its name in a rig file, with every ability that its devices have."""

    name: str
    axes: AxesDriver[Any] | None = None
    readout: ReadoutDriver[Any] | None = None
    environment: EnvironmentDriver[Any] | None = None
    stream: StreamDriver[Any] | None = None
    field: FieldDriver[Any] | None = None
    speaks_modbus: bool = False
    """Whether every line of it carries Modbus, by RTU or TCP: a fault file may put exceptions on it then."""

    def settings_class(self, ability: Ability) -> type | None:
        parts: Mapping[Ability, Any] = {
            "axes": self.axes,
            "readouts": self.readout,
            "environments": self.environment,
            "streams": self.stream,
            "fields": self.field,
        }
        return None if parts[ability] is None else parts[ability].settings


DRIVERS: Registry[Driver] = Registry("calrig.drivers", Driver, DescriptionError)
Part = TypeVar("Part")


def part_of(driver: str, choose: Callable[[Driver], Part | None], key: str) -> Part:
    """Return what a driver has for the device at ``key``. Raises: DescriptionError where it has nothing."""
    part = choose(DRIVERS[driver]) if driver in DRIVERS else None
    if part is None:
        raise DescriptionError(
            f"{key}: driver: {driver!r} cannot be opened: no installed driver of this name has such devices; nothing "
            "was opened; install its distribution"
        )
    return part


def on_one_line(
    connect: Callable[[Mapping[str, OfAxes], ByteStream], Mapping[str, Axis]],
) -> Callable[[Mapping[str, OfAxes], Lines], Mapping[str, Axis]]:
    """Return the opener of axes that share a line; baud rate, parity and handshake where their settings have them."""

    def open_line(axes: Mapping[str, OfAxes], lines: Lines) -> Mapping[str, Axis]:
        first = next(iter(axes))
        line = {name: value for name in LINE_SETTINGS if (value := getattr(axes[first], name, None)) is not None}
        return connect(axes, lines.stream(f"axes.{first}", axes[first].port, **line))

    return open_line


def numbers(axes: Mapping[str, AxisSettings]) -> dict[int, str]:
    """Return the number of each axis on its controller to its name."""
    return {axis.axis: name for name, axis in axes.items()}
