"""What the tests of an axis say in words: a sentence for what was found, and a short one for what was not."""

from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType
from typing import Final

from ams.analysis.diagnostics import order_words, residual_words, temperature_words, term_words
from ams.analysis.diagnostics.beliefs import (
    BY_POINT,
    BY_POINT_GAIN,
    BY_REPLICATION,
    DRIFT_OF,
    LACK_OF_FIT,
    LAG,
    MEMORIES,
    ROBUST,
    SETTLING,
    SLIP,
    STEP,
    TABLE_LIMIT,
    TERMS_OVER_TEMPERATURE,
    WRONG_DWELL,
    AxisTests,
    BeliefTest,
)
from ams.analysis.diagnostics.facts import as_the_order_has_it
from ams.analysis.diagnostics.held_words import BESIDE_MEMORY, lack_words
from ams.analysis.diagnostics.residual_words import MOST_MOVED, robust_size
from ams.analysis.diagnostics.size_words import AxisWords, Scale
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.table_limit_wording import of_table_limit
from ams.analysis.diagnostics.wrong_dwell_words import Convicted, wrong_dwell_finding
from ams.findings import Finding, Said
from ams.inputs.known_of_run import DwellLabels
from ams.observations import Observations

_NOT_HELD: Final = frozenset({SETTLING, BY_POINT, BY_POINT_GAIN, LAG, TERMS_OVER_TEMPERATURE, ROBUST, *MEMORIES})
"""What is alike in every replication, passes for a sensitivity, or reads to one side: no scatter between replications
holds it."""
_WORDS: Final = {**term_words.WORDS, **residual_words.WORDS, **order_words.WORDS, **temperature_words.WORDS}
"""Of every test but for those of a drift of a quantity, and for what has words of its own."""


def findings_of(
    tests: AxisTests,
    scale: Scale,
    observations: Observations,
    convicted: Convicted | None,
    drifts: Mapping[str, str],
    *,
    has_table: bool,
    limit: TableLimit | None = None,
    order: Sequence[Finding] = (),
    follows_gravity: bool = False,
    other_angles: bool = False,
    largest_lack: float = inf,
    alike: Mapping[DwellLabels, str] = MappingProxyType({}),
    offset_expanded: float = 0.0,
) -> tuple[Finding, ...]:
    """Return a finding for every test that was made; ``drifts``: how far each quantity moved, in words.

    ``order``: what is said of the order of the points, which may let a drift pass or leave it unknown.
    ``follows_gravity``: whether the zero of a gyro is told to follow gravity, beyond what is declared.
    ``other_angles``: whether other signs or another order of the angles are told to explain a lack of fit.
    ``largest_lack``: of fit that the stated uncertainties may hold, in the output's unit.
    ``offset_expanded``: the expanded uncertainty of the offset.
    ``alike``: dwells at which a table that stood off would look as wrong readings, and by how much it stood off then.
    """
    found = []
    is_remembering = any(tests.is_significant.get(name) for name in MEMORIES)
    drift_is = BESIDE_MEMORY if is_remembering else as_the_order_has_it(order)
    lack = tests.tests.get(LACK_OF_FIT)
    is_large = lack is not None and lack.size > largest_lack
    lack_is = lack_words(
        other_angles=other_angles, is_large=is_large, follows_gravity=follows_gravity, is_remembering=is_remembering
    )
    words = AxisWords(scale, tests.conviction_level, has_table, lack_is, drift_is, drifts)
    beyond = {*_NOT_HELD, *([LACK_OF_FIT] if other_angles or is_large else [])}
    for name, test in tests.tests.items():
        is_significant = tests.is_significant[name]
        if name == TABLE_LIMIT and limit is not None:
            found.append(of_table_limit(test, limit, is_significant=is_significant))
            continue
        if name in (SLIP, STEP) and is_significant:
            continue  # told in the words of the diagnosis
        if name == WRONG_DWELL and convicted is not None:
            found.append(wrong_dwell_finding(test, scale, observations, convicted, alike))
            continue
        is_held = name not in beyond or (name == ROBUST and MOST_MOVED * abs(test.size) <= offset_expanded)
        said = _significant(test, words) if is_significant else Said(f"{name}: {_not_significant(test, scale)}")
        if name == ROBUST and is_significant:
            said = said._replace(
                fact=f"{said.fact}; that is {'' if is_held else 'not '}in the stated uncertainty of the offset"
            )
        found.append(
            Finding(
                test.kind,
                said.fact,
                is_significant,
                test.p_value,
                details={"test": name, **test.numbers},
                is_held=is_held,
                what_to_do=said.what_to_do,
            )
        )
    return tuple(found)


def _significant(test: BeliefTest, words: AxisWords) -> Said:
    say = order_words.drift_of_quantity if test.name.startswith(DRIFT_OF) else _WORDS[test.name]
    return say(test, words)


def _not_significant(test: BeliefTest, scale: Scale) -> str:
    """Return why nothing was found; of a robust fit also how far it is."""
    said = _explained(test) if test.is_explained else "not significant"
    return f"{said}, {robust_size(test, scale)} from the estimate" if test.name == ROBUST else said


def _explained(test: BeliefTest) -> str:
    if test.name in (*MEMORIES, BY_REPLICATION, SETTLING, LACK_OF_FIT, ROBUST):
        return "explained by what a dwell knows of the one before it"
    return "explained by a drift" if test.name in (SLIP, STEP) else "explained by temperature"
