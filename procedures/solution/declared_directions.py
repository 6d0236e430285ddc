"""What a rig file declares of the direction, the polarity and the sensitivity of a sensor's axes."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal

from ams.inputs.declared_direction import DeclaredDirection, NominalSensitivity, nominal_of_unit
from rig.description.rig_file import Sensor

VOLTS: Final[Mapping[str, str]] = MappingProxyType({})
"""Every output is read in volts."""


def declared_directions(sensor: Sensor | None, units: Mapping[str, str] = VOLTS) -> Mapping[str, DeclaredDirection]:
    """Return by sensor axis where its mount has it along the table, with its nominal sensitivity and the sign of it.

    ``units``: sensor axis to the unit of its readings; those of which none is said are volts. Nothing where no
    sensor is declared: an axis then lies along the one that it is named by.
    """
    if sensor is None:
        return {}
    return {
        str(axis): _declared(getattr(sensor.mount, axis), sensor, axis, units.get(axis, "v"))
        for axis in sensor.channels
    }


def declared_in_package(sensor: Sensor, axis: str, unit: str) -> DeclaredDirection:
    """Return what is declared where levels are counted along the package's own axes: of the mount they know already.

    ``unit``: of the readings.
    """
    return _declared(f"+{axis}", sensor, axis, unit)


def _declared(mounted: str, sensor: Sensor, axis: str, unit: str) -> DeclaredDirection:
    nominal = sensor.nominal_v(axis)
    sense: Literal[1, -1] = 1 if mounted[0] == "+" else -1
    return DeclaredDirection(mounted[1], sense, _polarity(nominal), _nominal(nominal, unit, sensor.sensed_unit))


def _polarity(nominal: float) -> Literal[1, -1] | None:
    return None if nominal == 0.0 else (1 if nominal > 0.0 else -1)


def _nominal(declared: float, unit: str, per: str) -> NominalSensitivity | None:
    """Return what is declared of an output in volts; of readings in a unit of what is sensed, what the unit says."""
    if declared != 0.0:
        return NominalSensitivity(abs(declared), per=per)
    return nominal_of_unit(unit, per)
