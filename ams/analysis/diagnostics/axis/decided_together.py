"""Which tests of an axis are significant, decided over all of them: a column that is counts as known for the others.

Which column goes first is a matter of what was measured and of what is simpler; a drift that temperature explains is
temperature's.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import Final

from ams.analysis.diagnostics.axis.axis_over_temperature import axis_over_temperature
from ams.analysis.diagnostics.axis.overlap import Overlap, significant, with_neighbours
from ams.analysis.diagnostics.axis.point_columns import column_test
from ams.analysis.diagnostics.axis.stated_sizes import stated_sizes
from ams.analysis.diagnostics.beliefs import (
    AXIS_OVER_TEMPERATURE,
    BY_REPLICATION,
    BY_TEMPERATURE,
    COLUMNS,
    CURVATURE,
    LAG,
    RECORDED,
    SQUARENESS,
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
    names = {column.name: index for index, column in enumerate(tested_columns)}
    known, dof = list[str](), inf if scatter is None else scatter.terms.dof
    while True:
        is_significant = significant(made, level, None if scatter is None else Overlap(scatter, between, names, known))
        still_open = [name for name in names if is_significant.get(name) and name not in known]
        if scatter is None or not still_open:
            if scatter is not None and known:
                made = stated_sizes(made, names, [name for name in known if name not in convicted], scatter, between)
                made = with_neighbours(made, names, known, scatter.terms)
            return AxisTests(made, is_significant, level=level)
        known.append(_next(still_open, made, scatter.terms, tuple(names[name] for name in known)))
        beside = tuple(names[name] for name in known)
        for name, column_index in names.items():
            if name in made and name not in known and name not in convicted:
                tested = column_test(tested_columns[column_index], scatter.terms.test(column_index, beside), dof)
                tested = between.with_means(scatter.referred(tested, column_index, beside))
                made[name] = tested._replace(p_value=tested.p_value if isfinite(tested.p_value) else 1.0)


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
