"""Which tests of an axis are significant, decided over all of them: a column that is counts as known for the others.

Which column goes first is a matter of what was measured and of what is simpler; a drift that temperature explains is
temperature's.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Final

from ams.analysis.diagnostics.axis.axis_over_temperature import axis_over_temperature
from ams.analysis.diagnostics.axis.overlap import Overlap, significant, with_neighbours
from ams.analysis.diagnostics.axis.point_columns import column_test
from ams.analysis.diagnostics.axis.stated_sizes import stated_sizes
from ams.analysis.diagnostics.beliefs import (
    AXIS_OVER_TEMPERATURE,
    BY_REPLICATION,
    BY_TEMPERATURE,
    BY_TERMS,
    COLUMNS,
    CURVATURE,
    LAG,
    MEMORIES,
    OF_THE_ORDER,
    RECORDED,
    SETTLING,
    SQUARENESS,
    TURNED_FROM_ALIKE,
    AxisTests,
    BeliefTest,
    Column,
)
from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import temperature as by_temperature
from ams.analysis.diagnostics.over_time.settling import Between
from ams.analysis.diagnostics.point_means import Elimination
from ams.analysis.diagnostics.replication_scatter import ReplicationScatter

_NEEDED: Final = 0.05
_NEEDED_BESIDE_TERMS: Final = 0.005
"""Of one of the columns that the order makes, of which there are up to eight."""
_ESTIMATED: Final = ("K2", "Kpp", "Kip", "Kio", "Kpo", "K3")
"""The terms that an extended model estimates whether they are significant or not."""
_OF_ORDER: Final = frozenset({TURNED_FROM_ALIKE, *MEMORIES, SETTLING, *OF_THE_ORDER})
"""Columns that the order of the dwells makes of the attitudes."""
_PLAINER: Final = {"K1'": "K2", "K0'": "K3", SQUARENESS: "Kpo"}


def decided_together(
    made: dict[str, BeliefTest],
    scatter: ReplicationScatter | None,
    between: Between,
    convicted: Collection[str],
    level: float,
    tested_columns: Sequence[Column],
) -> AxisTests:
    """Holm over all at the level of the axis.

    A significant column counts as known, and the other columns are tested beside it.
    The recorded temperature goes first where it is significant: what was measured before what is only imagined.
    """
    if scatter is None:
        return AxisTests(made, significant(made, level, None), level=level)
    names = {column.name: index for index, column in enumerate(tested_columns)}
    known, explained = list[str](), set[str]()
    tests_beside = _Beside(tested_columns, names, scatter, between)
    while True:
        is_significant = significant(made, level, Overlap(scatter, between, names, known))
        still_open = [name for name in names if is_significant.get(name) and name not in known]
        needless = tests_beside.explained_by_terms([*known, *still_open], known, {*convicted, *explained})
        if needless:
            explained |= needless
            known = [name for name in known if name not in needless]
        elif still_open:
            known.append(_next(still_open, made, scatter.terms, tuple(names[name] for name in known)))
        else:
            if known:
                made = stated_sizes(made, names, [name for name in known if name not in convicted], scatter, between)
                made = with_neighbours(made, names, known, scatter.terms)
            return AxisTests(made, is_significant, level=level)
        for name in names:
            if name in made and name not in known and name not in convicted:
                made[name] = tests_beside.terms(name, known) if name in explained else tests_beside.known(name, known)


@dataclass(frozen=True)
class _Beside:
    """Tests of the columns beside others that count as known."""

    columns: Sequence[Column]
    names: Mapping[str, int]
    """Column to its place."""
    scatter: ReplicationScatter
    between: Between

    def known(self, name: str, known: Sequence[str]) -> BeliefTest:
        """Return the test of a column beside those that are known."""
        index, beside = self.names[name], tuple(self.names[other] for other in known if other != name)
        tested = column_test(self.columns[index], self.scatter.terms.test(index, beside), self.scatter.terms.dof)
        tested = self.between.with_means(self.scatter.referred(tested, index, beside))
        return tested._replace(p_value=tested.p_value if isfinite(tested.p_value) else 1.0)

    def terms(self, name: str, known: Sequence[str]) -> BeliefTest:
        """Return the same beside all terms of low order as well, which explain what it does."""
        estimated = [other for other in _ESTIMATED if other in self.names and other not in known]
        return self.known(name, [*known, *estimated])._replace(explained_by=BY_TERMS)

    def explained_by_terms(
        self, significant_names: Sequence[str], known: Sequence[str], settled: Collection[str]
    ) -> set[str]:
        """Return which of the significant columns nobody needs beside the terms of low order, of which one is told.

        They are those that the order of the dwells makes. In an order that repeats, a slow memory or a settling is
        nearly what several small terms make of it together, and one column is plainer than each of them.
        """
        if not any(name in _ESTIMATED for name in significant_names):
            return set()
        candidates = [name for name in significant_names if name in _OF_ORDER and name not in settled]
        return {name for name in candidates if not self.terms(name, known).p_value <= _NEEDED_BESIDE_TERMS}


def _next(
    still_open: Sequence[str], made: Mapping[str, BeliefTest], columns: Elimination, beside: tuple[int, ...]
) -> str:
    """Return the column that counts as known from now on: the recorded temperature, else the most significant.

    A large bend is in part what any column of the points shows, the temperature's too: it goes first only where it is
    needed beside all others, or where the most significant of them is not needed beside it. Of two that are nearly
    collinear the bend goes before the asymmetry, unless that is needed beside the bend as well.
    """
    names = [column.name for column in COLUMNS]
    recorded = [name for name in still_open if name in RECORDED]
    others = tuple(names.index(name) for name in still_open if name not in RECORDED)
    needed = [name for name in recorded if not columns.test(names.index(name), (*beside, *others)).p_value > _NEEDED]
    if needed or not others:
        return min(needed or recorded, key=lambda name: made[name].p_value)
    # By the means alone, where all have the same degrees of freedom: an estimate between replications as well would put
    # a transient before the bend that it only looks like.
    in_means = {names[index]: columns.test(index, beside).p_value for index in others}
    most = min(in_means, key=lambda name: (in_means[name] if isfinite(in_means[name]) else 1.0, made[name].p_value))
    record = tuple(names.index(name) for name in RECORDED)
    if recorded and not columns.test(names.index(most), (*beside, *record)).p_value <= _NEEDED:
        return min(recorded, key=lambda name: made[name].p_value)
    plainer = _PLAINER.get(most)
    if plainer is not None and plainer in still_open:
        still_needed = columns.test(names.index(most), (*beside, names.index(plainer)))
        if not still_needed.p_value <= _NEEDED:
            return plainer
    return most


def explained_by_temperature(evidence: Evidence, output: int, decided: AxisTests) -> AxisTests:
    """Take from drift what temperature explains, and from curvature what a lag does."""
    flags, tests = dict(decided.is_significant), dict(decided.tests)
    if not any(flags.get(name) for name in (LAG, CURVATURE, BY_REPLICATION, AXIS_OVER_TEMPERATURE)):
        return decided
    lag_h = tests[LAG].uncertainty if flags.get(LAG) else None
    between = by_temperature.between_replications(evidence, output, lag_h, curved=bool(flags.get(CURVATURE)))
    if flags.get(LAG) and flags.get(CURVATURE) and not between.curvature.p_value <= decided.conviction_level:
        flags[CURVATURE] = False
        tests[CURVATURE] = tests[CURVATURE]._replace(explained_by=BY_TEMPERATURE)
    turning = axis_over_temperature(evidence, output, lag_h) if flags.get(AXIS_OVER_TEMPERATURE) else None
    left = between.unexplained if turning is None else turning.unexplained
    if flags.get(LAG) or not left <= decided.conviction_level:
        for name, test in tests.items():
            if test.kind == "drift" and flags[name]:
                flags[name], tests[name] = False, test._replace(explained_by=BY_TEMPERATURE)
    return replace(decided, tests=tests, is_significant=flags)
