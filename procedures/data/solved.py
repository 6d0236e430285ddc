"""Solved packages for a notebook or a script: the document that the commands print, and the same as a table."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

import pandas as pd

from ams.calibration_result import Calibration
from procedures.solution.request import SolvedSensor

_COLUMNS = ("sensor", "axis", "parameter", "value", "standard_uncertainty")


@dataclass(frozen=True, eq=False)
class Solved:
    """The solution of one or several packages."""

    sensors: Mapping[str, SolvedSensor]
    """Name to its rows and its calibration, or why there is none."""
    document: Mapping[str, Any]
    """What ``calrig solve --json`` prints of a run, and ``calrig fit --json`` of a file."""

    @property
    def parameters(self) -> pd.DataFrame:
        """A row for every parameter of every axis, its unit at the end of its name; null what is not determined."""
        table = pd.DataFrame(list(self._rows()), columns=_COLUMNS)
        return table.astype({"value": "float64", "standard_uncertainty": "float64"})

    @property
    def warnings(self) -> list[str]:
        """What somebody must read before the numbers are used, behind the sensor it is about."""
        sentences = [f"{name}: {sensor.failure}" for name, sensor in self.sensors.items() if sensor.failure is not None]
        for name, calibration in self._calibrations():
            sentences += [f"{name}: {warning}" for warning in calibration.warnings]
            sentences += [
                f"{name} {axis}: {word}"
                for axis, solved_axis in calibration.axes.items()
                for word in solved_axis.warnings
            ]
        return sentences

    def plot(self) -> Any:
        """Draw the residuals of every axis against pitch, those of straight lines by row, as a matplotlib Figure."""
        from procedures.data.drawings import residuals_of

        return residuals_of(self.sensors)

    def _repr_html_(self) -> str:
        lines = "".join(f"<li>{escape(warning)}</li>" for warning in self.warnings)
        return self.parameters.to_html(index=False) + (f"<ul>{lines}</ul>" if lines else "")

    def _rows(self) -> Iterator[tuple[object, ...]]:
        for name, calibration in self._calibrations():
            for axis, solved in calibration.axes.items():
                for parameter in solved.parameters:
                    yield name, axis, parameter.name, parameter.value, parameter.standard_uncertainty

    def _calibrations(self) -> Iterator[tuple[str, Calibration]]:
        for name, sensor in self.sensors.items():
            if sensor.calibration is not None:
                yield name, sensor.calibration
