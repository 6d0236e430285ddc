"""The columns that the means of the points are tested for, beside the linear sensor."""

from math import inf
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import COLUMNS, BeliefTest, Column
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.low_order import squareness_of_points
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.over_time.order_columns import left_by_order
from ams.analysis.diagnostics.point_means import LEAST_DOF, Elimination, Tested, eliminate, independent
from ams.analysis.diagnostics.tested_terms import (
    ASYMMETRY_OF_OFFSET,
    accelerometer_base,
    terms_at_points,
    tested_base,
    with_sign_of_axis,
)
from ams.arrays import FloatArray
from ams.models.accelerometer import LINEAR_COLUMNS, PitchRoll
from ams.models.extended import ExtendedPitchRoll
from ams.models.thermal import TEMPERATURE_NAMES
from ams.remembered import remembered

_FEWEST_POINTS: Final = LINEAR_COLUMNS + len(COLUMNS) + LEAST_DOF
"""Of fewer no term can be spared."""


def by_point_degc(evidence: Evidence, output: int) -> FloatArray:
    """Return (K, 2) temperature of the points, and its product with what the output senses over its largest.

    (K, 0) where none is recorded, where it is modelled or where it is one.
    """
    column, layout = by_temperature.departure_of_points(evidence), evidence.layout
    if column is None or TEMPERATURE_NAMES[0] in evidence.models[0].primary_names:
        return np.zeros((layout.points, 0))
    return np.column_stack([column, column * layout.mean_by_point(evidence.sensed[:, output])])


def low_order(evidence: Evidence, output: int, known: FloatArray, turned: FloatArray) -> Elimination | None:
    """Return what the means of the points are tested for, ready to be tested beside the linear sensor.

    These are the terms of low order, the attitude before and the temperature. None where the model has no such terms.
    ``turned`` (N,) is what the sensor was turned by from the attitude before.
    """
    base = tested_base(evidence.models[output])
    if base is None:
        return None
    layout, rows = evidence.layout, evidence.rows
    shared = terms_at_points(evidence, output, base)
    terms = with_sign_of_axis(shared, evidence, output, base)
    linear, fitted = evidence.basis[:, :LINEAR_COLUMNS], evidence.basis[:, LINEAR_COLUMNS:]
    whole = independent(np.hstack([linear, known])) if known.shape[1] > 0 else linear
    means = evidence.means(output, whole, fitted @ evidence.alone[LINEAR_COLUMNS:, output])
    before = layout.mean_by_point(turned)
    sees_squareness = isinstance(base, PitchRoll | ExtendedPitchRoll)
    skew = squareness_of_points(rows, layout, base.nominal_axis if sees_squareness else "x", evidence.primary[output])
    in_order = left_by_order(evidence, accelerometer_base(base), layout.points - _FEWEST_POINTS)
    degc = by_point_degc(evidence, output)
    columns = np.column_stack([terms, skew, before, in_order, degc])
    unshared = np.column_stack([known, terms[:, [ASYMMETRY_OF_OFFSET]], skew, before, degc])
    return eliminate(means, columns, _beside(evidence.basis, shared, in_order), unshared)


@remembered(16)
def _beside(basis: FloatArray, terms: FloatArray, in_order: FloatArray) -> FloatArray:
    return np.hstack([basis, terms, in_order])


def column_test(column: Column, tested: Tested, dof: float = inf) -> BeliefTest:
    """Return the test of a column by what the means say of it."""
    coefficient, uncertainty = tested.coefficient, tested.standard_uncertainty
    return BeliefTest(
        column.name, column.kind, tested.p_value, coefficient, uncertainty, column.unit, dof, is_held=column.is_held
    )
