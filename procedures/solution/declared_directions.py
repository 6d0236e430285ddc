"""What a rig file declares of the direction, the polarity and the sensitivity of a sensor's axes."""

from collections.abc import Mapping
from typing import Literal

from ams.inputs.declared_direction import DeclaredDirection
from rig.description.rig_file import Sensor


def declared_directions(sensor: Sensor | None) -> Mapping[str, DeclaredDirection]:
    """Return by sensor axis where its mount has it along the table, with its nominal sensitivity and the sign of it.

    Nothing where no sensor is declared: an axis then lies along the one that it is named by.
    """
    if sensor is None:
        return {}
    return {str(axis): _declared(getattr(sensor.mount, axis), sensor, axis) for axis in sensor.channels}


def declared_in_package(sensor: Sensor, axis: str) -> DeclaredDirection:
    """Return what is declared where levels are counted along the package's own axes: of the mount they know already."""
    return _declared(f"+{axis}", sensor, axis)


def _declared(mounted: str, sensor: Sensor, axis: str) -> DeclaredDirection:
    nominal = sensor.nominal_v_per_g(axis)
    sense: Literal[1, -1] = 1 if mounted[0] == "+" else -1
    return DeclaredDirection(mounted[1], sense, _polarity(nominal), abs(nominal) or None)


def _polarity(nominal: float) -> Literal[1, -1] | None:
    return None if nominal == 0.0 else (1 if nominal > 0.0 else -1)
