"""Which tests of one axis are significant together, those that nearly say the same counted for what they add.

The columns that the means of the points are tested for overlap: K₂ and K₁′, K₃ and K₀′, a memory and the next longer
one. Their correlation is that of what the linear sensor leaves of them, so that it is known from the design and nothing
is estimated. Holm's correction takes their tests for as many as they count (:mod:`ams.statistics.tests_alike`). Of two
terms so alike that the points hold either, the one that is told has the name of the other beside it; so has a recorded
temperature that is told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import MEMORIES, RECORDED, BeliefTest
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.over_time.settling import Between
from ams.analysis.diagnostics.point_means import Elimination
from ams.analysis.diagnostics.replication_scatter import ReplicationScatter
from ams.analysis.diagnostics.tested_terms import accelerometer_base
from ams.statistics.intervals import holm
from ams.statistics.tests_alike import counted

_NEIGHBOUR: Final = {"K2": "K1'", "K1'": "K2", "K3": "K0'", "K0'": "K3"}
_APART: Final = 0.01
"""Chance of a term beside its neighbour: where it is larger, the neighbour explains the points as well."""


@dataclass(frozen=True)
class Overlap:
    """Of the columns of one output."""

    scatter: ReplicationScatter
    between: Between
    names: Mapping[str, int]
    """Of the tests, to their columns."""
    known: Sequence[str]
    """Names of the columns that the others are tested beside."""

    def spared(self, made: Mapping[str, BeliefTest], level: float) -> float:
        """Return by how many tests fewer they count, at the ``level`` of each."""
        of_means = self.scatter.terms.correlation(tuple(self.names[name] for name in self.known))
        share = np.zeros(of_means.shape[0])
        for (name, index), alone in zip(self.names.items(), self.scatter.terms.each(), strict=False):
            if name in made and name not in self.known and alone.standard_uncertainty > 0.0:
                share[index] = self._share(made[name], alone.standard_uncertainty)
        correlation = of_means * np.sqrt(np.outer(share, share))
        memories = [self.names[name] for name in MEMORIES if name in self.names]
        base = accelerometer_base(self.scatter.evidence.models[self.scatter.output])
        rest = np.sqrt(1.0 - share[memories])
        if base is not None and len(memories) == len(MEMORIES) and np.any((rest > 0.0) & (rest < 1.0)):
            alike = previous_attitude.memories_alike(self.scatter.evidence, base)
            correlation[np.ix_(memories, memories)] += np.outer(rest, rest) * alike
        tested = [index for name, index in self.names.items() if name in made and index < share.size]
        return len(tested) - counted(correlation[np.ix_(tested, tested)], level)

    def _share(self, test: BeliefTest, uncertainty_of_means: float) -> float:
        """Return what part of a test's weight the means have: all, or what differs between replications the rest."""
        if test.name not in self.between.estimates or not test.uncertainty > 0.0:
            return 1.0
        return min(1.0, (test.uncertainty / uncertainty_of_means) ** 2)


def significant(made: Mapping[str, BeliefTest], level: float, overlap: Overlap | None) -> dict[str, bool]:
    """Return by name which tests are significant at the ``level`` of all of them."""
    p_values = np.array([test.p_value / test.axes for test in made.values()])
    # As how many tests they count at the very least: where none passes that, as in clean data, none is significant.
    least = len(made) if overlap is None else len(made) - sum(name in made for name in overlap.names) + 1
    known = p_values[~np.isnan(p_values)]
    if not np.any(known * min(least, known.size) <= level):
        return dict.fromkeys(made, False)
    flags = holm(p_values, level)
    if overlap is not None and np.any(holm(p_values, level, least) != flags):
        flags = holm(p_values, level, len(made) - overlap.spared(made, level / len(made)))
    return dict(zip(made, map(bool, flags), strict=True))


def with_neighbours(
    made: Mapping[str, BeliefTest], names: Mapping[str, int], known: Sequence[str], terms: Elimination
) -> dict[str, BeliefTest]:
    """Return the tests, the ``known`` terms with the name of their neighbour where the points hold that one as well.

    They do where the term is not needed beside it: in one of a hundred campaigns at most in which the neighbour is
    what there is, the term alone is told. The neighbour of a recorded temperature is what would be told without it.
    ``names``: of the tests, to their columns.
    """
    found = dict(made)
    for name in known:
        beside = tuple(names[term] for term in known if term != name)
        other = _likest(names, known, terms, beside) if name in RECORDED else _NEIGHBOUR.get(name)
        if other is None or other in known or other not in made:
            continue
        is_there = np.isfinite(terms.test(names[other], beside).p_value)
        if is_there and not terms.test(names[name], (*beside, names[other])).p_value <= _APART:
            found[name] = found[name]._replace(fit_as_well=(other,))
    return found


def _likest(names: Mapping[str, int], known: Sequence[str], terms: Elimination, beside: tuple[int, ...]) -> str | None:
    """Return the column that the points hold most of without the recorded temperature; None where there is none."""
    others = {
        name: terms.test(index, beside).p_value
        for name, index in names.items()
        if name not in known and name not in RECORDED
    }
    return min((name for name in others if np.isfinite(others[name])), key=lambda name: others[name], default=None)
