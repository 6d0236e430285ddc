"""The least that a few groups of rows may be said to differ by: no less than the noise inside them leaves in the mean.

Two replications agree by chance: in one parameter of a hundred to a hundredth of what the noise of their own dwells
lets them, and between four parameters their differences have one direction, so that along all others they say nothing
at all. An interval from their difference alone holds the truth in 95 % of campaigns, and next to never where it came
out narrow (simulated: of the narrowest 2 % of two replications 12 % do, of three 32 %). What the dwells scatter by
inside the replications is known with many degrees of freedom by then, and a drift only adds to it.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.solve.components import ComponentColumns
from ams.solve.linear_form import LinearForm
from ams.statistics.intervals import t_quantile
from ams.statistics.short_of import short_of

FEW_GROUPS: Final = 3
"""More of them tell their own spread; noise known with no more degrees of freedom than these cannot correct it."""


def no_less_than_noise(
    spread: ComponentColumns, estimator: FloatArray, form: LinearForm, precision: FloatArray, dof: int
) -> ComponentColumns:
    """Widen the spread of a few groups in every direction where its interval is narrower than that of noise alone.

    ``precision``: (m,) variance of a row of unit weight inside the groups, with its degrees of freedom. The causes stay
    those that were seen: what is added belongs to each estimate alone.
    """
    if dof <= FEW_GROUPS or spread.dof[0] >= FEW_GROUPS:
        return spread
    weights = 1.0 if form.weights is None else form.weights
    root = np.asarray(np.linalg.cholesky((estimator / weights) @ np.swapaxes(estimator, -1, -2)))
    # An interval is Student's factor times the standard uncertainty: the factors differ, the intervals are compared.
    least = (t_quantile(0.95, float(dof)) / t_quantile(0.95, spread.dof)) ** 2 * precision
    return replace(spread, covariance=spread.covariance + short_of(spread.covariance, root, least))
