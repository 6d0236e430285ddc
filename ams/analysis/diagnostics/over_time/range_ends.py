"""Whether what looks like a transient stands at the ends of what an output senses, all of a row alike.

An amplifier that meets its rail there, or an index of the table that is wrong, shortens every dwell at an end by the
same. Where a replication begins at that end, most of a transient that fades over its first dwells is the same.
"""

from collections.abc import Collection
from dataclasses import replace
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import BY_THE_ENDS, SETTLING, AxisTests
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.temperature import explained
from ams.analysis.diagnostics.time_order import means_of_points, settling
from ams.statistics.distributions import f_tail

_AT_THE_END: Final = 1e-3
"""Of what is sensed over its largest: points that sense as much as the one at the end."""
_NEEDED: Final = 0.01
"""Chance of a transient beside the ends: where it is larger it is not needed."""
_PLAIN: Final = 1e-4
"""Chance of the ends beside a transient: where it is larger they are imagined to explain what chance did."""


def explained_by_ends(evidence: Evidence, output: int, decided: AxisTests, convicted: Collection[str]) -> AxisTests:
    """Return the tests, a transient at the start of every replication not told where the ends explain it.

    ``convicted``: names of tests of what is taken out of the evidence already.
    """
    is_open = decided.is_significant.get(SETTLING) and SETTLING not in convicted
    if not is_open or not evidence.order_repeats or not _are_the_ends(evidence, output):
        return decided
    explained_so = decided.tests[SETTLING]._replace(explained_by=BY_THE_ENDS)
    flags = {**decided.is_significant, SETTLING: False}
    return replace(decided, tests={**decided.tests, SETTLING: explained_so}, is_significant=flags)


def _are_the_ends(evidence: Evidence, output: int) -> bool:
    """Return whether the ends are needed beside the transient, and the transient is not beside the ends."""
    layout, mean = evidence.layout, evidence.point_effects[:, output]
    along = means_of_points(layout, evidence.sensed[:, output].copy())
    ends = np.abs(along[:, None] - np.array([along.min(), along.max()])) <= _AT_THE_END
    transient = means_of_points(layout, settling(evidence))[:, None]
    (whole, rank), *without = (
        explained(np.hstack([evidence.basis, *columns]), mean) for columns in ((ends, transient), (transient,), (ends,))
    )
    dof, left = layout.points - rank, float(mean @ mean) - whole
    if dof < 1 or not left > 0.0:
        return False

    def chance(explained_without: float, rank_without: int) -> float:
        more = float(max(rank - rank_without, 1))
        return float(f_tail((whole - explained_without) * dof / (more * left), more, float(dof)))

    of_ends, of_transient = (chance(*each) for each in without)
    return of_ends <= _PLAIN and of_transient > _NEEDED
