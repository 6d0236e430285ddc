"""The test of a transient at the start of every replication, from what repeats and from what does not.

Where the order of the points is the same in every replication, it repeats as a lack of fit does, and is one of the
columns that the means of the points are tested for, beside the linear sensor. Where the order differs, every point
tells it for itself. Both speak of one coefficient, and each has the weight of its own variance.
"""

from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.beliefs import SETTLING, BeliefTest
from ams.analysis.diagnostics.time_order import Slope
from ams.findings import FindingKind
from ams.statistics.distributions import f_tail


@dataclass(frozen=True)
class Between:
    """The test of settling by what differs from replication to replication, to be joined by that of the means."""

    slope: Slope
    output: int
    dof: int

    @property
    def test(self) -> BeliefTest:
        return slope_test(SETTLING, "drift", self.slope, self.output, "")

    def with_means(self, of_means: BeliefTest, dof: int) -> BeliefTest:
        """Return a test of the means; that of settling with what it has in common with this one, each by its weight."""
        if of_means.name != SETTLING:
            return of_means
        tested = self.test
        if not np.isfinite(tested.p_value):
            return of_means
        if not np.isfinite(of_means.p_value):
            return tested
        weights = np.array([tested.uncertainty, of_means.uncertainty]) ** -2.0
        size = float(weights @ [tested.size, of_means.size] / weights.sum())
        uncertainty = float(weights.sum() ** -0.5)
        p_value = float(f_tail((size / uncertainty) ** 2, 1.0, float(min(dof, self.dof))))
        return replace(of_means, p_value=p_value, size=size, uncertainty=uncertainty)


def slope_test(name: str, kind: FindingKind, slope: Slope, output: int, unit: str) -> BeliefTest:
    """Return the test of one output's slope against a column."""
    p_value, coefficient, uncertainty = (
        float(column[output]) for column in (slope.p_value, slope.coefficient, slope.standard_uncertainty)
    )
    return BeliefTest(name, kind, p_value, coefficient, uncertainty, unit)
