"""The drivers by the name a rig file gives them, and the settings table of each.

How a driver's devices are opened stands in :mod:`rig.openers`, its twin in :mod:`rig.bench`.

Built-in drivers stand in the tables below; other distributions register their settings tables under the entry
points ``calrig.axes``, ``calrig.readouts`` and ``calrig.environments``.
"""

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import Literal

Ability = Literal["axes", "readouts", "environments"]

BUILT_IN: Mapping[Ability, Mapping[str, str]] = {
    "axes": {"indexing-table": "rig.devices.indexing_table:IndexingTableSettings"},
    "readouts": {"hp3458a": "rig.devices.hp3458a:Hp3458aSettings"},
    "environments": {"watlow-f4": "rig.devices.watlow_f4:WatlowF4Settings"},
}
"""Ability to driver name to ``module:settings class``."""


def settings_classes(ability: Ability) -> dict[str, type]:
    """Driver name to the settings table of every driver of that ability."""
    registered = {entry.name: entry.value for entry in entry_points(group=f"calrig.{ability}")}
    return {name: _load(target) for name, target in (dict(BUILT_IN[ability]) | registered).items()}


def _load(target: str) -> type:
    module, _, attribute = target.partition(":")
    loaded = getattr(import_module(module), attribute)
    assert isinstance(loaded, type)
    return loaded
