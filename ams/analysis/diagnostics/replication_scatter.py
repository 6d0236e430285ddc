"""A directed test of the means, held against what its own coefficient does from replication to replication.

The means are tested against what dwells that know nothing of each other leave. Where dwells know of each other, where
something drifts, or where one replication is not like the others, the coefficient of a term scatters between the
replications by more than that. It is then an estimate from n values, with n − 1 degrees of freedom.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import AUTOCORRELATION, MEMORIES, TURNED_FROM_ALIKE, BeliefTest
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import Elimination, spanned
from ams.arrays import FloatArray
from ams.statistics.distributions import f_tail

_LEAST_REPLICATIONS: Final = 3
"""Two differ in one way only, which is no scatter."""
_PLAIN: Final = 0.003
"""Chance of so large a scatter between replications where dwells know nothing of each other."""
_PLAINLY: Final = 0.1
"""Of the level of a test: below it dwells are taken to know of each other, which by chance alone they never seem to."""
_NOTHING: Final = 1e-10
"""Of the square of a column: less is left beside the others by rounding."""
_OF_DWELLS_BEFORE: Final = frozenset({TURNED_FROM_ALIKE, *MEMORIES})
"""What makes dwells know of each other, and is not doubted because they do."""


def is_unsteady(tests: Iterable[BeliefTest], level: float) -> bool:
    """Return whether dwells plainly know of each other, or something drifts; ``level``: of a test."""
    unsteady = (test for test in tests if test.name == AUTOCORRELATION or test.kind == "drift")
    return any(test.p_value <= _PLAINLY * level for test in unsteady)


@dataclass(frozen=True)
class ReplicationScatter:
    """What the columns of one output are referred to."""

    evidence: Evidence
    output: int
    terms: Elimination
    level: float
    """Tests above it are left as they are: no scatter makes them smaller."""
    is_unsteady: bool
    """Whether dwells are known to know of each other, or something to drift: then all columns together may show that
    they scatter, else each has to show it by itself."""

    def referred(self, test: BeliefTest, column: int, beside: tuple[int, ...] = ()) -> BeliefTest:
        """Return a test of one column by the scatter of its coefficient where that is larger."""
        if not test.p_value <= self.level:
            return test
        found = self._scatter(column, beside)
        if found is None:
            return test
        between, white, dof = found
        variance = float(self.evidence.precision_variance[self.output])
        is_plain = float(f_tail(between / white, float(dof), float(self.evidence.grid.dof))) <= _PLAIN
        is_needed = test.name not in _OF_DWELLS_BEFORE and self._do_all_scatter
        if not variance > 0.0 or between <= white or not (is_needed or is_plain):
            return test
        # What the means scatter by beyond the dwells, of the table and of lack of fit, no replication shows.
        square = between + max(test.uncertainty**2 - white, 0.0)
        p_value = float(f_tail(test.size**2 / square, 1.0, float(dof)))
        return test._replace(p_value=max(test.p_value, p_value), uncertainty=float(np.sqrt(square)), dof=float(dof))

    @cached_property
    def _do_all_scatter(self) -> bool:
        """Return whether dwells are not independent, and the columns together scatter between replications by more.

        A drift that is the same in every replication of one order scatters none of them.
        """
        if not self.is_unsteady:
            return False
        given, tested = np.split(self.terms.design, [self.terms.given], axis=1)
        left = tested - given @ np.linalg.lstsq(given, tested, rcond=_NOTHING)[0]
        square, whole = np.einsum("kc,kc->c", left, left), self._whole
        is_left = square > _NOTHING * np.einsum("kc,kc->c", tested, tested)
        dof = float((len(whole) - 1) * int(is_left.sum()))
        if len(whole) < _LEAST_REPLICATIONS or not dof > 0.0:
            return False
        each = whole @ (left[:, is_left] / np.sqrt(square[is_left]))
        ratio = float(np.var(each, axis=0, ddof=1).mean()) / float(self.evidence.precision_variance[self.output])
        return float(f_tail(ratio, dof, float(self.evidence.grid.dof))) <= _PLAIN

    def _scatter(self, column: int, beside: tuple[int, ...]) -> tuple[float, float, int] | None:
        """Return u² of the mean coefficient by replications and by dwells, and the degrees of freedom of the first."""
        layout, design = self.evidence.layout, self.terms.design
        given = design[:, [*range(self.terms.given), *(self.terms.given + other for other in beside)]]
        tested = design[:, self.terms.given + column]
        q = spanned(given)
        left = tested - q @ (q.T @ tested)
        square, whole = float(left @ left), self._whole
        if len(whole) < _LEAST_REPLICATIONS or not square > _NOTHING * float(tested @ tested):
            return None
        each, dof = whole @ left / square, len(whole) - 1
        between = float(np.var(each, ddof=1)) / layout.replications
        return between, float(self.evidence.precision_variance[self.output]) / square / layout.replications, dof

    @cached_property
    def _whole(self) -> FloatArray:
        """(n, K) what every replication that has all points departs by from the others."""
        layout = self.evidence.layout
        of_output = self.evidence.on_grid(self.evidence.departures[:, [self.output]]).reshape(layout.replications, -1)
        return np.asarray(of_output[layout.sum_by_replication(np.ones(layout.rows)) == layout.points])
