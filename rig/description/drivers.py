"""The drivers that are installed, by the name a rig file gives them, and the settings table of each.

A driver is one object and one entry point ``calrig.drivers`` (:class:`rig.drivers.driver.Driver`, which adds how its
devices and twins are opened). It is imported when a file names it, or when a mistake needs the names of all.
"""

from collections.abc import Mapping
from typing import Any, Literal

from rig.errors import DescriptionError
from rig.registry import Registry

Ability = Literal["axes", "readouts", "environments", "streams", "fields"]
TABLES: Mapping[str, Ability] = {
    "axes": "axes",
    "readouts": "readouts",
    "environment": "environments",
    "streams": "streams",
    "field": "fields",
}
"""Table of a rig file to the ability that its devices have."""


class DescribedDriver:
    """What a rig file needs to know of a driver."""

    name: str
    speaks_modbus: bool
    """Whether its devices answer in Modbus, and so refuse by exception codes."""

    def settings_class(self, ability: Ability) -> type | None:
        """Return the strict table of a device with this ability, None where the driver has no such devices."""
        raise NotImplementedError


DESCRIBED_DRIVERS: Registry[DescribedDriver] = Registry("calrig.drivers", DescribedDriver, DescriptionError)


def settings_classes(ability: Ability) -> dict[str, type]:
    """Return driver name to settings table of every driver of that ability; all drivers are imported for it."""
    found = {name: driver.settings_class(ability) for name, driver in DESCRIBED_DRIVERS.items()}
    return {name: settings for name, settings in found.items() if settings is not None}


def classes_for(ability: Ability, devices: object) -> tuple[type, ...]:
    """Return the settings tables that a table of devices, as it was read, can be checked against.

    Where every device names a driver of the ability these are theirs alone and nothing else is imported; where one
    does not, every table of the ability, so that the mistake can be told with what is allowed.
    """
    if not isinstance(devices, dict):
        return tuple(settings_classes(ability).values())
    found = [_settings_of(ability, device) for device in devices.values()]
    known = [settings for settings in found if settings is not None]
    return tuple(dict.fromkeys(known)) if len(known) == len(found) else tuple(settings_classes(ability).values())


def _settings_of(ability: Ability, device: Any) -> type | None:
    name = device.get("driver") if isinstance(device, dict) else None
    if not isinstance(name, str) or name not in DESCRIBED_DRIVERS:
        return None
    return DESCRIBED_DRIVERS[name].settings_class(ability)
