"""Outputs that no sensor gives, or that the meter could not have read: the numbers are in another unit than volts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.errors import ObservationsError
from ams.observations import Observations

_MILLI: Final = 1e-3
_OVERLOAD: Final = 9e37
"""No reading is beyond: SCPI meters answer 9.9e37 for an overload (IEEE 488.2: infinity), −9.9e37 below, and 9.91e37
for no number."""


@dataclass(frozen=True)
class Reach:
    """How far an output can go, to either side of zero."""

    largest_v: float
    why: str
    """What says so, in words."""
    way_out: str
    """What else to correct than the unit of the column; empty where nothing is."""


OF_ANY_SENSOR: Final = Reach(50.0, "servo accelerometers end at ±15 V", "")


def largest_possible(unit: str) -> float:
    """Return the largest number, to either side of zero, that a reading in a unit can be; ``unit`` as in keys."""
    return OF_ANY_SENSOR.largest_v if unit == "v" else _OVERLOAD


def is_impossible(outputs: FloatArray, largest: float) -> BoolArray:
    """Return where (…,) outputs are beyond it; what is no finite number is missing, and not beyond."""
    return np.asarray((np.abs(outputs) > largest) & np.isfinite(outputs))


def of_impossible(output: float, unit: str) -> str:
    """Say what an output is that no reading in a unit can be, and what to do."""
    if abs(output) > _OVERLOAD or unit != "v":
        return f"{output:g} is the code by which a meter says overload or no reading; choose a higher range"
    reach = OF_ANY_SENSOR
    allowed = f"allowed {-reach.largest_v:g} to {reach.largest_v:g} V ({reach.why})"
    return f"got {output:g} V, {allowed}; {_likely_unit(abs(output), reach)}"


def _likely_unit(largest: float, allowed: Reach) -> str:
    if largest * _MILLI <= allowed.largest_v:
        return "the numbers look like millivolts: divide the column by 1000"
    return "give the column in volts"


def refuse_overloads(observations: Observations, columns: Mapping[str, str]) -> None:
    """Refuse what a meter answers where it read nothing, in any unit.

    ``columns``: sensor axis to the column that it was read from. Raises: ObservationsError.
    """
    for label, outputs in observations.outputs.items():
        beyond = np.abs(outputs) > _OVERLOAD
        if beyond.any():
            row = int(np.flatnonzero(beyond)[0])
            raise ObservationsError(
                f"{observations.source}: column {columns.get(label, label)}: replication "
                f"{observations.replication[row]}, point {observations.point[row]}: got {outputs[row]:g}, the code by "
                f"which a meter says overload or no reading ({int(beyond.sum())} of {outputs.size} rows); nothing was "
                "solved; measure these rows again in a higher range, or take them out"
            )


def refuse_impossible_outputs(
    observations: Observations, columns: Mapping[str, str], reach: Mapping[str, Reach]
) -> None:
    """Refuse outputs in volts that are beyond what could have been read.

    ``columns``: sensor axis to the column that it was read from; ``reach``: sensor axis to what its meter reads, where
    a rig file declares it. Raises: ObservationsError that names file, column, row, what is allowed and the likely unit.
    """
    for label, outputs in observations.outputs.items():
        allowed = reach.get(label, OF_ANY_SENSOR)
        beyond = np.abs(outputs) > allowed.largest_v
        if observations.unit_of(label) != "v" or not beyond.any():
            continue
        row, unit = int(np.flatnonzero(beyond)[0]), _likely_unit(float(np.abs(outputs).max()), allowed)
        rows = f"{int(beyond.sum())} of {outputs.size} rows"
        raise ObservationsError(
            f"{observations.source}: column {columns.get(label, label)}: {rows} are "
            f"impossible, the first in replication {observations.replication[row]}, point {observations.point[row]}: "
            f"got {outputs[row]:g} V, allowed {-allowed.largest_v:g} to {allowed.largest_v:g} V ({allowed.why}); "
            f"nothing was solved; {unit}{allowed.way_out}"
        )
