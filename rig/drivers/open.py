"""How the devices of a rig are opened, each by its driver, and seen to have every member of their ability."""

from collections.abc import Mapping

from rig.clock import Clock
from rig.description.device_settings import (
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
    StreamSettings,
)
from rig.devices.abilities import Axis, Environment, Field, Readout, Stream
from rig.devices.members import require_members
from rig.drivers.driver import part_of
from rig.lines.open_lines import Lines


def open_axes(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
    """Open the axes of one line. Raises: DescriptionError, LinkLost."""
    first = next(iter(axes))
    opened = part_of(axes[first].driver, lambda driver: driver.axes, f"axes.{first}").open(axes, lines)
    for name, axis in opened.items():
        require_members(axis, f"axes.{name}", axes[first].driver)
    return opened


def open_readout(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    """Open a readout by its driver. Raises: DescriptionError, LinkLost, DeviceSilent, DeviceNonsense."""
    driver = part_of(settings.driver, lambda driver: driver.readout, f"readouts.{name}")
    readout = driver.open(name, settings, lines, clock)
    require_members(readout, f"readouts.{name}", settings.driver)
    return readout


def open_environment(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    """Open an environment by its driver. Raises: DescriptionError, LinkLost."""
    driver = part_of(settings.driver, lambda driver: driver.environment, f"environment.{name}")
    environment = driver.open(name, settings, lines)
    require_members(environment, f"environment.{name}", settings.driver)
    return environment


def open_sample_stream(name: str, settings: StreamSettings, lines: Lines, clock: Clock) -> Stream:
    """Open a stream of samples by its driver. Raises: DescriptionError, LinkLost."""
    driver = part_of(settings.driver, lambda driver: driver.stream, f"streams.{name}")
    stream = driver.open(name, settings, lines, clock)
    require_members(stream, f"streams.{name}", settings.driver)
    return stream


def open_field(name: str, settings: FieldSettings, lines: Lines) -> Field:
    """Open a field by its driver. Raises: DescriptionError, LinkLost."""
    field = part_of(settings.driver, lambda driver: driver.field, f"field.{name}").open(name, settings, lines)
    require_members(field, f"field.{name}", settings.driver)
    return field
