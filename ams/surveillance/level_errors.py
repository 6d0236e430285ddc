"""How wrong straight lines are, in the unit of what they sense: real = A·measured + B by one set against another.

Both lines turn the same reading into a level, so their difference is a line itself and is largest at an end of the
range: two points tell all of it. The uncertainty is that of the new calibration; that of the set under test is not part
of it, it is what is being found.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.sets.canonical import Json, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.equations import AxisNumbers
from ams.statistics.intervals import t_quantile

_COVERAGE = 0.95


@dataclass(frozen=True)
class LevelErrors:
    """Errors of one axis at the two ends of the levels that it was exposed to."""

    axis: str
    unit: str
    """Of what is sensed, as it is written in a key."""
    level: FloatArray
    """(2,)"""
    error: FloatArray
    """(2,) told minus true."""
    standard_uncertainty: FloatArray
    """(2,) of the error."""
    coverage_factor: FloatArray
    """(2,) for 95 %."""

    @property
    def expanded(self) -> FloatArray:
        return self.coverage_factor * self.standard_uncertainty

    @property
    def worst(self) -> int:
        """The end where the size of the error and its expanded uncertainty together are largest."""
        return int(np.argmax(np.abs(self.error) + self.expanded))


def level_errors_of(applied: CoefficientSet, measured_by: CoefficientSet) -> Mapping[str, LevelErrors]:
    """Return the errors of the set ``applied`` by axis; ``measured_by`` is the set that its run made.

    Raises: OutsideValidity where the sets have other axes or units.
    """
    if not applied.is_of_lines or set(applied.axes) != set(measured_by.axes) or _units(applied) != _units(measured_by):
        raise OutsideValidity(
            f"{applied.sensor}: errors of straight lines need two sets of the same axes and units: got "
            f"{', '.join(applied.axes)} in {' per '.join(_units(applied))}, measured by {', '.join(measured_by.axes)} "
            f"in {' per '.join(_units(measured_by))}; nothing was computed"
        )
    return {name: _errors(applied.axes[name], measured_by, name) for name in measured_by.axes}


def to_document(errors: LevelErrors) -> dict[str, Json]:
    """Return the errors as plain JSON values, keyed in their unit."""
    columns = {"level": errors.level, "error": errors.error, "standard_uncertainty": errors.standard_uncertainty}
    found: dict[str, Json] = {f"{name}_{errors.unit}": list(map(float, values)) for name, values in columns.items()}
    return {"unit": errors.unit, **found, "coverage_factor": list(map(float, errors.coverage_factor))}


def from_document(axis: str, document: Mapping[str, Json]) -> LevelErrors:
    """Return the errors back from :func:`to_document`."""
    unit = str(document["unit"])

    def column(name: str) -> FloatArray:
        return np.array([number(value) for value in listed(document[name])], dtype=float)

    level, error, uncertainty = (column(f"{name}_{unit}") for name in ("level", "error", "standard_uncertainty"))
    return LevelErrors(axis, unit, level, error, uncertainty, column("coverage_factor"))


def _units(coefficients: CoefficientSet) -> tuple[str, str]:
    form = next(iter(coefficients.axes.values())).form
    return form.measured_unit, form.unit


def _errors(line: AxisNumbers, measured_by: CoefficientSet, name: str) -> LevelErrors:
    new = measured_by.axes[name]
    index = "xyz".index(new.nominal_axis)
    limits = measured_by.validity.levels.get(new.form.inputs[index], (0.0, 0.0))
    level = np.array(limits)
    reading = new.primary[new.form.offset] + new.direction[index] * level
    level_of_line = (reading - line.primary[line.form.offset]) / line.direction[index]
    variances, dofs = _variances(measured_by, name, level)
    total = variances.sum(axis=0)
    shares = variances / np.where(total > 0.0, total, 1.0)
    with np.errstate(divide="ignore"):
        dof = 1.0 / np.sum(shares**2 / dofs[:, None], axis=0)
    uncertainty = np.sqrt(total) / abs(line.direction[index])
    error = np.zeros_like(level) if line is new else level_of_line - level
    return LevelErrors(name, new.form.unit, level, error, uncertainty, np.asarray(t_quantile(_COVERAGE, dof)))


def _variances(coefficients: CoefficientSet, name: str, level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (parts, 2) variances of the reading that a line predicts at two levels, and the parts' freedom."""
    numbers = coefficients.axes[name]
    primary = table(table(table(coefficients.document["axes"])[name])["primary"])
    order = [str(entry) for entry in listed(primary["order"])]
    kept = [order.index(numbers.form.offset), order.index(numbers.form.directions["xyz".index(numbers.nominal_axis)])]
    rows = np.stack([np.ones_like(level), level], axis=-1)
    variances, dofs = [np.zeros_like(level)], [np.inf]
    for part in map(table, table(primary["components"]).values()):
        matrix = [[0.0 if cell is None else number(cell) for cell in listed(row)] for row in listed(part["covariance"])]
        square = np.array(matrix)[np.ix_(kept, kept)]
        variances.append(np.einsum("ni,ij,nj->n", rows, square, rows))
        dofs.append(np.inf if part["degrees_of_freedom"] is None else number(part["degrees_of_freedom"]))
    return np.stack(variances), np.array(dofs)
