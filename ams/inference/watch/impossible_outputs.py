"""How many rows of each output were taken as missing because no sensor gives such a one, and what they held."""

from collections.abc import Iterator, Mapping

import numpy as np

from ams.arrays import FloatArray
from ams.inference.rows.possible_rows import taken_as_missing
from ams.inputs.possible_outputs import of_impossible


class ImpossibleOutputs:
    """Outputs by column, in their units, as they come."""

    def __init__(self, units: Mapping[str, str]) -> None:
        self._units = units
        self._rows = dict.fromkeys(units, 0)
        self._largest = dict.fromkeys(units, 0.0)

    def take(self, readings: Mapping[str, FloatArray], possible: Mapping[str, FloatArray]) -> None:
        """Take further rows as they were read, and with what was taken as missing."""
        for name, rows in taken_as_missing(readings, possible):
            both = np.append(readings[name][rows], self._largest[name])
            self._rows[name] += both.size - 1
            self._largest[name] = float(both[np.argmax(np.abs(both))])

    def doubts(self) -> Iterator[str]:
        """Say of every column how many there were, and of what size."""
        for name, rows in self._rows.items():
            if rows:
                has = "1 row has" if rows == 1 else f"{rows} rows have"
                said = of_impossible(self._largest[name], self._units[name])
                yield f"{name}: {has} an output that none gives: taken as missing; {said}"
