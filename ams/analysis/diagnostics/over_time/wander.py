"""What is left of a test where dwells know of the dwells before them: a slow wander looks like much that is slow.

The estimate c = aᵀe/aᵀa of a column a has under the correlations r_k of dwells k apart the variance σ²/aᵀa times
1 + 2 Σ r_k Σ aᵢaᵢ₊ₖ/aᵀa, and a sum of squares counts for n/(1 + 2 Σ r_k²) dwells. The correlations are those of what
differs from replication to replication beside the column, as r_k = s φᵏ⁻¹: white noise and an element with a memory.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import (
    AT_A_LOCATION,
    AUTOCORRELATION,
    BY_REPLICATION,
    BY_THE_DWELL_BEFORE,
    LACK_OF_FIT,
    ROBUST,
    SETTLING,
    AxisTests,
)
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.time_order import settling
from ams.arrays import FloatArray

_LAGS: Final = 60
"""Dwells apart, at the most, over which neighbours are compared."""
_FADING: Final = np.linspace(0.0, 0.98, 50)
"""Correlations from one dwell to the next that are tried."""


def beside_wander(evidence: Evidence, output: int, tests: AxisTests, made: frozenset[str]) -> AxisTests:
    """Return the tests, those of what is slow or repeats as significant as dwells that know of each other have it.

    ``made``: names of tests that were made on something else.
    """
    if not tests.is_significant.get(AUTOCORRELATION) or AUTOCORRELATION in made:
        return tests
    found, flags = dict(tests.tests), dict(tests.is_significant)
    columns = {BY_REPLICATION: by_temperature.departure_degc(evidence), SETTLING: settling(evidence)}
    for name in (BY_REPLICATION, SETTLING, LACK_OF_FIT, AT_A_LOCATION, ROBUST):
        if not flags.get(name) or name in made:
            continue
        less = _inflation(evidence, output, columns.get(name))
        p_value = found[name].p_value ** (1.0 / less)
        flags[name] = p_value <= tests.conviction_level
        explained_by = "" if flags[name] else BY_THE_DWELL_BEFORE
        uncertainty = found[name].uncertainty * less**0.5
        found[name] = found[name]._replace(p_value=p_value, uncertainty=uncertainty, explained_by=explained_by)
    return replace(tests, tests=found, is_significant=flags)


def _inflation(evidence: Evidence, output: int, column: FloatArray | None) -> float:
    """Return by how much more than white noise's the square of an estimate scatters; of a sum of squares without."""
    order = evidence.time_order
    y = evidence.departures[order, output]
    if not np.any(y):  # of one replication nothing differs
        return 1.0
    if column is None:
        return max(1.0, 1.0 + 2.0 * float(np.sum(_correlations(y) ** 2)))
    a = (column - column.mean())[order]
    differs = evidence.layout.about_points(column)[order]
    square = float(differs @ differs)
    if square > 0.0:
        y = y - differs * (float(differs @ y) / square)
    return max(1.0, 1.0 + 2.0 * float(_correlations(y) @ _products(a)))


def _products(y: FloatArray) -> FloatArray:
    lags = range(1, min(_LAGS, y.size - 1) + 1)
    return np.array([float(y[:-lag] @ y[lag:]) for lag in lags]) / float(y @ y)


def _correlations(y: FloatArray) -> FloatArray:
    """Return the correlation of dwells 1, 2, 3 … apart, as white noise beside an element with a memory has it."""
    seen = _products(y)
    powers = _FADING[:, None] ** np.arange(seen.size)
    sizes = powers @ seen / np.einsum("fk,fk->f", powers, powers)
    left = np.einsum("fk,fk->f", seen - sizes[:, None] * powers, seen - sizes[:, None] * powers)
    best = int(np.argmin(left))
    return np.asarray(sizes[best] * powers[best])
