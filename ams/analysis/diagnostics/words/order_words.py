"""What is said of outputs that know of time, or of the dwells before them."""

from collections.abc import Callable, Mapping
from typing import Final

from ams.analysis.diagnostics.beliefs import (
    AFTER_MOVES,
    AUTOCORRELATION,
    DRIFT_OF,
    HELD_ACROSS,
    MEMORIES,
    OVER_TIME,
    SETTLING,
    TURNED_FROM,
    TURNED_FROM_ALIKE,
    BeliefTest,
)
from ams.analysis.diagnostics.facts import CONTAINED
from ams.analysis.diagnostics.size_words import AxisWords
from ams.analysis.diagnostics.words.held_words import BESIDE_MEMORY
from ams.findings import Said


def drift_of_quantity(test: BeliefTest, words: AxisWords) -> Said:
    """Return what is said of a quantity that changed from replication to replication."""
    quantity = test.name.removeprefix(DRIFT_OF)
    moved = f" by {words.drifts[quantity]} (largest less smallest)" if quantity in words.drifts else ""
    return Said(f"{quantity} changed from replication to replication{moved}; {words.drift_is}")


def _over_time(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"the offset drifts with time by {words.scale.words(abs(test.size))} an hour, evenly from replication to "
        f"replication; {words.drift_is}",
        "a time term in the solution ([solve] time_term) tells it",
    )


def _autocorrelation(test: BeliefTest, _: AxisWords) -> Said:
    return Said(
        f"a dwell knows of the dwell before it: correlation {test.size:.2g} inside the replications; the output "
        "wanders or has not settled",
        "a longer settling time or a random order makes dwells independent",
    )


def _turned(test: BeliefTest, words: AxisWords) -> Said:
    where = ", alike in every replication" if test.name == TURNED_FROM_ALIKE else ""
    by_chance = f"{CONTAINED} only as far as the order of the points makes chance of it"
    held = BESIDE_MEMORY if words.drift_is == BESIDE_MEMORY else by_chance
    return Said(
        f"a dwell remembers the attitude before it: {words.scale.words(2.0 * abs(test.size))} after a turn from one "
        f"end of its range to the other{where}; hysteresis, or the output has not settled; {held}",
        "a longer settling time tells which",
    )


def _memory(test: BeliefTest, words: AxisWords) -> Said:
    about = test.name.removeprefix("memory of about ")
    together = "" if test.axes == 1 else f", as the {test.axes} of the package show it together,"
    return Said(
        f"the output{together} remembers the attitudes of about {about} before: "
        f"{words.scale.per_g(test.size, test.uncertainty)} of what the force along the axis changed by, fading from "
        f"dwell to dwell{_as_well(test)}; creep of the sensor, of its mount or its case, a channel that has not "
        f"settled, or play of an axis, which rests by the way that it came{_or_the_table(words)}; sensitivities hold "
        "most of it, and the stated uncertainties only a limit that is declared (largest_nonlinearity_v)",
        "dwell longer, or wait longer before each reading, and measure again",
    )


def _or_the_table(words: AxisWords) -> str:
    """Return that index errors look the same: in an order that is always the same each index has its own dwells."""
    return words.or_the_table if words.order_repeats else ""


def _as_well(test: BeliefTest) -> str:
    others = [name.removeprefix("memory of about ") for name in test.fit_as_well]
    return f" ({' and '.join(others)} fit{'s' if len(others) == 1 else ''} as well, of another size)" if others else ""


def _settling(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"the output settles at the start of every replication: {words.scale.words(abs(test.size))} at its first "
        f"dwell, over after about a quarter of its dwells{_or_the_table(words)}; alike in each, it is in offset and "
        "sensitivities and not in the stated uncertainties",
        "warm up and settle longer before the first dwell, leave the first dwells out, or draw the order of the points "
        'anew for every replication (order = "random")',
    )


def _held_across(test: BeliefTest, words: AxisWords) -> Said:
    axis = test.name.removeprefix("force along ").removesuffix(" at the dwell before")
    return Said(
        "the output keeps some of what the dwell before had across it: "
        f"{words.scale.per_g(test.size, test.uncertainty)} of the force along {axis} then less that now, alike in "
        "every replication; a channel that keeps a part of the one that was read before it (multiplexer, relay, "
        "dielectric), a mount that gives way slowly, or what else goes with the order of the dwells; "
        "sensitivities hold most of it, and the stated uncertainties do not",
        "wait longer between closing a channel and reading it, read every channel twice, or draw the order of the "
        'points anew for every replication (order = "random")',
    )


def _after_moves(test: BeliefTest, words: AxisWords) -> Said:
    return Said(
        f"the output settles after every move of the slower axis: {words.scale.words(abs(test.size))} at the first "
        f"dwell after it, over after some five dwells{_or_the_table(words)}; alike in every replication, it is in "
        "offset and sensitivities and not in the stated uncertainties",
        "settle longer after moves of that axis, and look for the heat of its motor and the pull of cables; a random "
        "order moves it at every dwell and hides it in the offset",
    )


WORDS: Final[Mapping[str, Callable[[BeliefTest, AxisWords], Said]]] = {
    OVER_TIME: _over_time,
    AUTOCORRELATION: _autocorrelation,
    TURNED_FROM: _turned,
    TURNED_FROM_ALIKE: _turned,
    **dict.fromkeys(MEMORIES, _memory),
    SETTLING: _settling,
    **dict.fromkeys(HELD_ACROSS, _held_across),
    AFTER_MOVES: _after_moves,
}
