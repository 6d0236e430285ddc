"""Tests of a transient at the start of every replication and of a memory, from what repeats and from what does not.

Where the order of the points is the same in every replication, it repeats as a lack of fit does, and is one of the
columns that the means of the points are tested for, beside the linear sensor. Where the order differs, every point
tells it for itself. Both speak of one coefficient, and each has the weight of its own variance.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BeliefTest
from ams.analysis.diagnostics.time_order import Slope
from ams.finding_kinds import FindingKind
from ams.statistics.distributions import f_tail


@dataclass(frozen=True)
class Estimate:
    """Of one coefficient."""

    size: float
    uncertainty: float
    dof: float

    @property
    def p_value(self) -> float:
        """NaN where nothing is known."""
        if not self.uncertainty > 0.0:
            return np.nan
        return float(f_tail((self.size / self.uncertainty) ** 2, 1.0, self.dof))


UNKNOWN: Final = Estimate(np.nan, np.nan, np.nan)


def joined(estimates: Iterable[Estimate]) -> Estimate:
    """Return what independent estimates of one coefficient say together, each by the weight of its variance.

    The degrees of freedom are those of Welch and Satterthwaite.
    """
    known = [estimate for estimate in estimates if estimate.uncertainty > 0.0]
    if len(known) < 2:
        return known[0] if known else UNKNOWN
    weights = [estimate.uncertainty**-2.0 for estimate in known]
    whole = sum(weights)
    size = sum(weight * estimate.size for weight, estimate in zip(weights, known, strict=True)) / whole
    dof = whole**2 / sum(weight**2 / estimate.dof for weight, estimate in zip(weights, known, strict=True))
    return Estimate(size, whole**-0.5, dof)


@dataclass(frozen=True)
class Between:
    """Estimates by what differs from replication to replication, to be joined by those of the means."""

    estimates: Mapping[str, Estimate]
    """By the name of the test."""

    def with_means(self, of_means: BeliefTest) -> BeliefTest:
        """Return a test of the means with what the estimate of the same name here has to say."""
        estimate = self.estimates.get(of_means.name)
        if estimate is None or not estimate.uncertainty > 0.0:
            return of_means
        means = Estimate(of_means.size, of_means.uncertainty, of_means.dof)
        return of_estimate(of_means, joined([estimate, means]))


def of_estimate(test: BeliefTest, estimate: Estimate) -> BeliefTest:
    """Return a test as one estimate has it."""
    size, uncertainty, dof = estimate.size, estimate.uncertainty, estimate.dof
    return test._replace(p_value=estimate.p_value, size=size, uncertainty=uncertainty, dof=dof)


def slope_test(
    name: str, kind: FindingKind, slope: Slope, output: int, unit: str, *, is_held: bool = True
) -> BeliefTest:
    """Return the test of one output's slope against a column; ``is_held`` as of the test."""
    p_value, coefficient, uncertainty = (
        float(column[output]) for column in (slope.p_value, slope.coefficient, slope.standard_uncertainty)
    )
    return BeliefTest(name, kind, p_value, coefficient, uncertainty, unit, is_held=is_held)
