"""Which memory of the attitudes before is told of an output, of those that fit alike."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf, log1p
from typing import Final

from ams.analysis.diagnostics.beliefs import (
    AUTOCORRELATION,
    BY_ANOTHER_MEMORY,
    BY_THE_DWELL_BEFORE,
    LIKE_A_MEMORY,
    MEMORIES,
    TURNED_FROM,
    AxisTests,
    BeliefTest,
)

_FITS_AS_WELL: Final = 6.63
"""χ² of one degree of freedom at 1 %: by less in twice the log likelihood another time constant is not told apart."""
_OF_THE_DWELL_BEFORE: Final = (AUTOCORRELATION, TURNED_FROM)


def plainest_memory(tests: AxisTests, together: BeliefTest | None) -> BeliefTest | None:
    """Return the test of the memory that is plain, and plainer than what looks like one; None: none is.

    ``together``: what the outputs of a package show, as large as it is of this one, where it shows none by itself.
    """
    made = [test for name in MEMORIES if (test := tests.tests.get(name)) is not None]
    best = min(made, key=lambda test: test.p_value, default=None)
    if best is not None and best.p_value <= tests.conviction_level:
        plainest = min(test.p_value for test in tests.tests.values() if test.name in LIKE_A_MEMORY)
        if best.p_value <= plainest:
            return with_those_that_fit_as_well(best, tests.memories)
    if together is None or together.name not in MEMORIES or together.name not in tests.tests:
        return None
    return together


def but_for_memories(together: BeliefTest | None) -> tuple[BeliefTest, ...]:
    """Return what the outputs of a package show together where that is no memory: at most one test."""
    return () if together is None or together.name in MEMORIES else (together,)


def with_those_that_fit_as_well(best: BeliefTest, tests: Sequence[BeliefTest]) -> BeliefTest:
    """Return the most significant of the tests of a memory with the names of the others that nothing tells from it."""
    dof = min((test.dof for test in tests), default=1.0)
    gains = {test.name: dof * log1p((test.size / test.uncertainty) ** 2 / dof) for test in tests}
    least = gains.get(best.name, inf) - _FITS_AS_WELL
    return best._replace(fit_as_well=tuple(name for name, gain in gains.items() if name != best.name and gain >= least))


def without_lesser_memories(tests: AxisTests) -> AxisTests:
    """Return the tests with one memory at most told: the plainest, and none that the dwell before explains better."""
    rung = sorted(
        (name for name in MEMORIES if tests.is_significant.get(name)), key=lambda name: tests.tests[name].p_value
    )
    if not rung:
        return tests
    made, flags = dict(tests.tests), dict(tests.is_significant)
    nearest = min((made[name].p_value for name in _OF_THE_DWELL_BEFORE if flags.get(name)), default=1.0)
    best, *others = rung
    if nearest < made[best].p_value:
        explained = dict.fromkeys(rung, BY_THE_DWELL_BEFORE)
    else:
        explained = dict.fromkeys(others, BY_ANOTHER_MEMORY)
        if others and not made[best].fit_as_well:
            made[best] = with_those_that_fit_as_well(made[best], tests.memories)
    for name, by in explained.items():
        made[name], flags[name] = made[name]._replace(explained_by=by), False
    return replace(tests, tests=made, is_significant=flags)
