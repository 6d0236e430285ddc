"""What the tests of an axis say in words: a sentence for what was found, and a short one for what was not."""

from collections.abc import Mapping
from typing import Final

from ams.analysis.diagnostics.beliefs import (
    ATTITUDE_TURN,
    BACKLASH,
    DRIFT_OF,
    IN_STEP,
    ROBUST,
    SLIP,
    STEP,
    AxisTests,
    BeliefTest,
)
from ams.analysis.diagnostics.size_words import AxisWords, Scale
from ams.analysis.diagnostics.words import order_words, residual_words, temperature_words, term_words
from ams.analysis.diagnostics.words.residual_words import robust_size
from ams.findings import EXPLAINED_BY, Finding, Said

DIAGNOSED: Final = frozenset({SLIP, STEP, ATTITUDE_TURN, IN_STEP, *BACKLASH.values()})
_TOGETHER: Final = "told by the axes of the package together"
WORDS: Final = {**term_words.WORDS, **residual_words.WORDS, **order_words.WORDS, **temperature_words.WORDS}
"""Of every test but for those of a drift of a quantity, and for what has words of its own."""


def findings_of(tests: AxisTests, words: AxisWords, worded: Mapping[str, Finding]) -> tuple[Finding, ...]:
    """Return a finding for every test that was made.

    ``worded``: by the name of their test, the findings that have words of their own. A change in mid-run and
    a play of the table, where they are significant, are told by their diagnosis.
    """
    tested = ((name, test, tests.is_significant[name]) for name, test in tests.tests.items())
    return tuple(
        worded[name] if name in worded else _finding(test, words, is_significant=is_significant)
        for name, test, is_significant in tested
        if name in worded or not (is_significant and name in DIAGNOSED)
    )


def _finding(test: BeliefTest, words: AxisWords, *, is_significant: bool) -> Finding:
    fact, what_to_do = _significant(test, words) if is_significant else (_not_significant(test, words.scale), "")
    details = {"test": test.name, **test.numbers}
    if test.explained_by and not is_significant:
        details[EXPLAINED_BY] = test.explained_by
    return Finding(
        test.kind,
        fact,
        is_significant,
        test.p_value,
        details=details,
        is_held=test.is_held,
        what_to_do=what_to_do,
    )


def _significant(test: BeliefTest, words: AxisWords) -> Said:
    say = order_words.drift_of_quantity if test.name.startswith(DRIFT_OF) else WORDS[test.name]
    said = say(test, words)
    return said._replace(fact=f"{said.fact}; {_TOGETHER}: {test.in_package}") if test.in_package else said


def _not_significant(test: BeliefTest, scale: Scale) -> str:
    """Return that nothing was found, and why; of a robust fit also how far it is."""
    why = f"explained by {test.explained_by}" if test.explained_by else "not significant"
    distance = f", {robust_size(test, scale)} from the estimate" if test.name == ROBUST else ""
    return f"{test.name}: {why}{distance}"
