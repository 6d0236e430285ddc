"""The twins of a rig, line by line: which devices share a line, and which twin stands at its other end.

The same lines are read in memory (:mod:`rig.assembly.open_rig`) and over real ports (:mod:`rig.assembly.simulate`).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rig.description.device_settings import (
    TWIN_PORT,
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
)
from rig.description.rig_file import RigDescription, TwinSection
from rig.drivers.driver import Driver, part_of
from rig.errors import DescriptionError
from rig.twins.physics.strapped_down import StrappedDown
from rig.twins.physics.world import World
from rig.twins.twin import Twin


@dataclass(frozen=True)
class TwinLine:
    """One line and the twin at its end."""

    keys: tuple[str, ...]
    """The devices on it by their tables in the rig file, such as ``axes.pitch`` and ``axes.roll``."""
    twin: Twin
    address: str = "{port}"
    """How the rig file writes the port, where a device's address is more than the port."""


def axis_lines(axes: Mapping[str, AxisSettings]) -> list[tuple[str, ...]]:
    """Return the names of the axes that share a line: same driver and port, each with a number of its own.

    Twins with equal numbers are two controllers; at real ports the rig file is refused for that.
    """
    lines: list[list[str]] = []
    for name, axis in axes.items():
        for line in lines:
            others = [axes[other] for other in line]
            same_port = (others[0].driver, others[0].port) == (axis.driver, axis.port)
            if same_port and axis.line_address not in [other.line_address for other in others]:
                line.append(name)
                break
        else:
            lines.append([name])
    return [tuple(line) for line in lines]


def twin_lines(description: RigDescription, world: World, time_factor: float = 1.0) -> list[TwinLine]:
    """Return the lines of every device whose port says ``twin``.

    ``time_factor``: rig seconds in a second of the line.

    Raises: DescriptionError where a driver has no twin.
    """
    axes = {name: axis for name, axis in description.axes.items() if axis.port == TWIN_PORT}
    readouts = {name: meter for name, meter in description.readouts.items() if is_twin(meter)}
    chambers = {name: chamber for name, chamber in description.environment.items() if chamber.port == TWIN_PORT}
    return [
        *(_axes_line({name: axes[name] for name in line}, world, time_factor) for line in axis_lines(axes)),
        *(_readout_line(name, readout, world) for name, readout in readouts.items()),
        *(_environment_line(name, chamber, world, time_factor) for name, chamber in chambers.items()),
        *_stream_lines(description, world),
        *(_field_line(name, coil, world) for name, coil in description.field.items() if coil.port == TWIN_PORT),
    ]


def without_twin(description: RigDescription) -> frozenset[str]:
    """Return the devices, such as ``axes.pitch``, whose drivers have no twin."""
    parts: tuple[tuple[str, Mapping[str, Any], Callable[[Driver], Any]], ...] = (
        ("axes", description.axes, lambda driver: driver.axes),
        ("readouts", description.readouts, lambda driver: driver.readout),
        ("environment", description.environment, lambda driver: driver.environment),
        ("streams", description.streams, lambda driver: driver.stream),
        ("field", description.field, lambda driver: driver.field),
    )
    return frozenset(
        f"{table}.{name}"
        for table, devices, choose in parts
        for name, settings in devices.items()
        if part_of(settings.driver, choose, f"{table}.{name}").twin is None
    )


def is_twin(readout: ReadoutSettings) -> bool:
    return getattr(readout, "resource", None) == TWIN_PORT


def _axes_line(axes: Mapping[str, AxisSettings], world: World, time_factor: float) -> TwinLine:
    keys = tuple(f"axes.{name}" for name in axes)
    twin = _twin_of(axes[next(iter(axes))].driver, lambda driver: driver.axes, keys[0])
    return TwinLine(keys, twin(axes, world, time_factor))


def _readout_line(name: str, readout: ReadoutSettings, world: World) -> TwinLine:
    key = f"readouts.{name}"
    twin, address = _twin_of(readout.driver, lambda driver: driver.readout, key)(name, readout, world)
    return TwinLine((key,), twin, address)


def _environment_line(name: str, chamber: EnvironmentSettings, world: World, time_factor: float) -> TwinLine:
    key = f"environment.{name}"
    twin = _twin_of(chamber.driver, lambda driver: driver.environment, key)
    return TwinLine((key,), twin(name, chamber, world, time_factor))


def _stream_lines(description: RigDescription, world: World) -> Iterator[TwinLine]:
    streams = {name: stream for name, stream in description.streams.items() if stream.port == TWIN_PORT}
    source = StrappedDown(world, description.twin or TwinSection())
    for name, stream in streams.items():
        key = f"streams.{name}"
        yield TwinLine((key,), _twin_of(stream.driver, lambda driver: driver.stream, key)(name, stream, source))


def _field_line(name: str, coil: FieldSettings, world: World) -> TwinLine:
    key = f"field.{name}"
    return TwinLine((key,), _twin_of(coil.driver, lambda driver: driver.field, key)(name, coil, world))


def _twin_of(driver: str, choose: Callable[[Driver], Any], key: str) -> Callable[..., Any]:
    """Return how the twin of the device at ``key`` is made. Raises: DescriptionError where its driver has none."""
    twin: Callable[..., Any] | None = part_of(driver, choose, key).twin
    if twin is None:
        raise DescriptionError(
            f"{key}: driver: {driver!r} has no twin: it works at its real port, and cannot be rehearsed or simulated"
        )
    return twin
