"""The drivers by the name a rig file gives them, and the settings table of each.

How a driver's devices are opened stands in :mod:`rig.drivers.open`, its twin in :mod:`rig.drivers.twin_lines`.

Built-in drivers stand in the tables there and below. Other distributions register theirs by the driver's name under
three entry points an ability: ``calrig.readouts`` names the settings table, ``calrig.readouts.open`` and
``calrig.readouts.twin`` the functions with the signatures of those tables (a driver without a twin leaves it out);
likewise ``axes``, ``environments``, ``streams`` and ``fields``.
"""

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Literal

Ability = Literal["axes", "readouts", "environments", "streams", "fields"]
Part = Literal["open", "twin"]

BUILT_IN: Mapping[Ability, Mapping[str, str]] = {
    "axes": {
        "esp301": "rig.devices.esp301:Esp301Settings",
        "indexing-table": "rig.devices.indexing_table:IndexingTableSettings",
        "maestro": "rig.devices.maestro:MaestroSettings",
        "manual": "rig.devices.manual:ManualSettings",
        "oriental-az": "rig.devices.oriental_az:OrientalAzSettings",
        "zaber": "rig.devices.zaber:ZaberSettings",
    },
    "readouts": {
        "hp3458a": "rig.devices.hp3458a:Hp3458aSettings",
        "scpi-daq": "rig.devices.scpi_daq:ScpiDaqSettings",
    },
    "environments": {
        "watlow-f4": "rig.devices.watlow_f4:WatlowF4Settings",
        "watlow-f4t": "rig.devices.watlow_f4t:WatlowF4TSettings",
    },
    "fields": {
        "manual": "rig.devices.manual_field:ManualFieldSettings",
    },
    "streams": {
        "csv-imu": "rig.devices.csv_imu:CsvImuSettings",
        "vn100": "rig.devices.vn100:Vn100Settings",
    },
}
"""Ability to driver name to ``module:settings class``."""


def settings_classes(ability: Ability) -> dict[str, type]:
    """Driver name to the settings table of every driver of that ability."""
    registered = {entry.name: entry.value for entry in entry_points(group=f"calrig.{ability}")}
    return {name: _load(target) for name, target in (dict(BUILT_IN[ability]) | registered).items()}


def registered_part(ability: Ability, part: Part, driver: str) -> Any:
    """The function that another distribution registered, None where there is none."""
    entries = entry_points(group=f"calrig.{ability}.{part}", name=driver)
    return next(iter(entries)).load() if entries else None


def _load(target: str) -> type:
    module, _, attribute = target.partition(":")
    loaded = getattr(import_module(module), attribute)
    assert isinstance(loaded, type)
    return loaded
