"""How the devices of a rig are opened, each by its driver, and seen to have every member of their ability."""

from collections.abc import Mapping
from typing import TypeVar

from rig.abilities.abilities import Axis, Environment, Field, RateAxis, Readout, Stoppable, Stream
from rig.clock import Clock
from rig.description.device_settings import (
    AxisSettings,
    EnvironmentSettings,
    FieldSettings,
    ReadoutSettings,
    StreamSettings,
)
from rig.drivers.driver import part_of
from rig.errors import DescriptionError
from rig.lines.open_lines import Lines

Device = TypeVar("Device")


def open_axes(axes: Mapping[str, AxisSettings], lines: Lines) -> Mapping[str, Axis]:
    """Open the axes of one line. Raises: DescriptionError, LinkLost."""
    first = next(iter(axes))
    opened = part_of(axes[first].driver, lambda driver: driver.axes, f"axes.{first}").open(axes, lines)
    for name, settings in axes.items():
        if name not in opened:
            raise DescriptionError(
                f"axes.{name}: driver {settings.driver!r} opened {', '.join(opened) or 'nothing'} and not this axis;"
                " nothing was moved; mend the driver"
            )
        _whole(opened[name], Axis, settings.driver, f"axes.{name}")
        if settings.turning == "revolves":
            _whole(opened[name], RateAxis, settings.driver, f"axes.{name}")
            _whole(opened[name], Stoppable, settings.driver, f"axes.{name}")  # a rate does not end by itself
    return opened


def open_readout(name: str, settings: ReadoutSettings, lines: Lines, clock: Clock) -> Readout:
    """Open a readout by its driver. Raises: DescriptionError, LinkLost, DeviceSilent, DeviceNonsense."""
    driver = part_of(settings.driver, lambda driver: driver.readout, f"readouts.{name}")
    return _whole(driver.open(name, settings, lines, clock), Readout, settings.driver, f"readouts.{name}")


def open_environment(name: str, settings: EnvironmentSettings, lines: Lines) -> Environment:
    """Open an environment by its driver. Raises: DescriptionError, LinkLost."""
    driver = part_of(settings.driver, lambda driver: driver.environment, f"environment.{name}")
    return _whole(driver.open(name, settings, lines), Environment, settings.driver, f"environment.{name}")


def open_sample_stream(name: str, settings: StreamSettings, lines: Lines, clock: Clock) -> Stream:
    """Open a stream of samples by its driver. Raises: DescriptionError, LinkLost."""
    driver = part_of(settings.driver, lambda driver: driver.stream, f"streams.{name}")
    return _whole(driver.open(name, settings, lines, clock), Stream, settings.driver, f"streams.{name}")


def open_field(name: str, settings: FieldSettings, lines: Lines) -> Field:
    """Open a field by its driver. Raises: DescriptionError, LinkLost."""
    driver = part_of(settings.driver, lambda driver: driver.field, f"field.{name}")
    return _whole(driver.open(name, settings, lines), Field, settings.driver, f"field.{name}")


def _whole(device: Device, ability: type, driver: str, key: str) -> Device:
    """Return a device that has every member of its ability. Raises: DescriptionError.

    What is missed only when it is needed, such as a stop, is missed too late.
    """
    members = {name for name in vars(ability) if not name.startswith("_")} | set(ability.__annotations__)
    if missing := sorted(name for name in members if not hasattr(device, name)):
        raise DescriptionError(
            f"{key}: driver {driver!r}: its {type(device).__name__} has no {', '.join(missing)}, which"
            f" {ability.__name__} in rig/abilities/abilities.py asks for; nothing was moved; mend the driver"
        )
    return device
