"""Outputs that no sensor gives and no meter reads: taken as missing, row by row, and told in the row."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Protocol

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.attitude import flag_codes
from ams.inference.rows.angle_stream import Answer
from ams.inputs.possible_outputs import is_impossible, largest_possible
from ams.sets.coefficients import CoefficientSet


class OutputColumns(Protocol):
    """A set and the columns that its outputs are read from."""

    @property
    def coefficients(self) -> CoefficientSet: ...

    @property
    def columns(self) -> Mapping[str, str]:
        """Axis to column."""


def unit_by_column(packages: Iterable[OutputColumns]) -> dict[str, str]:
    """Return the unit of every output, as in keys."""
    return {
        column: package.coefficients.axes[axis].form.measured_unit
        for package in packages
        for axis, column in package.columns.items()
    }


def possible_readings(
    readings: Mapping[str, FloatArray], packages: Iterable[OutputColumns]
) -> Mapping[str, FloatArray]:
    """Return (n,) readings by column, NaN where an output is impossible: the very same where none is."""
    changed = {}
    for name, unit in unit_by_column(packages).items():
        beyond = is_impossible(readings[name], largest_possible(unit))
        if beyond.any():
            changed[name] = np.where(beyond, np.nan, readings[name])
    return {**readings, **changed} if changed else readings


def taken_as_missing(
    readings: Mapping[str, FloatArray], possible: Mapping[str, FloatArray]
) -> Iterator[tuple[str, BoolArray]]:
    """Yield by column the (n,) rows that :func:`possible_readings` took as missing; nothing where it took none."""
    for name, values in possible.items():
        if values is not readings[name]:
            yield name, np.isnan(values) & ~np.isnan(readings[name])


def overload_codes(readings: Mapping[str, FloatArray], possible: Mapping[str, FloatArray]) -> flag_codes.AnswerCodes:
    """Return the (n,) codes of what :func:`possible_readings` took as missing."""
    codes = np.zeros(next(iter(readings.values())).size, dtype=np.uint64)
    for _, rows in taken_as_missing(readings, possible):
        codes[rows] = flag_codes.OVERLOAD
    return codes


def with_overload_codes(
    found: Answer, readings: Mapping[str, FloatArray], possible: Mapping[str, FloatArray]
) -> Answer:
    """Return an answer to rows that tells which of them had an output that was taken as missing."""
    if possible is readings:
        return found
    codes = found.codes | overload_codes(readings, possible)
    return Answer(found.columns, codes, {**found.reasons, **flag_codes.OVERLOAD_WORDS})
