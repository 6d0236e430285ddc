"""What is said of a term of low order that an axis shows: symbol, size, effect, and what it is not told from."""

from collections.abc import Callable, Mapping
from typing import Final

from ams.analysis.diagnostics.beliefs import BeliefTest, TermChange
from ams.analysis.diagnostics.low_order import GYROS_IN_WORDS, IN_WORDS, PPM, TERMS
from ams.analysis.diagnostics.size_words import AxisWords, Scale, within
from ams.findings import Said
from ams.models.extended import CONFOUNDED
from ams.statistics.distributions import normal_quantile, normal_share

_SYMBOLS: Final = {name: (symbol, unit) for name, _, symbol, unit in TERMS}
_UNTOLD: Final = "; it is plain by itself, and beside the other terms of the model the attitudes do not tell its size"
_BARELY: Final = "; only just told: such sizes come out too large on average, and the term may be much smaller"
_OR_THE_ORDER: Final = (
    "; or whatever repeats with the order of the points, which is the same in every replication, such as a hum that "
    "the dwells fall into step with"
)
_DRAW_THE_ORDER: Final = (
    'draw the order of the points anew for every replication (order = "random"): what goes with the order scatters '
    "then, and what goes with the attitude stays"
)
_OR_THE_RATES: Final = (
    "; or of the table's: rates that are wrong by another part at one speed, or in one sense, than at the others bend "
    "every gyro on it alike"
)
_BIASED_SD: Final = 2.0


def _term(test: BeliefTest, words: AxisWords) -> Said:
    shown = _of_gyro(test) if test.unit == PPM else _of_accelerometer(test, words.scale) + words.or_the_table
    shown += _barely_significant(test, words.conviction_level)
    return Said(shown + _OR_THE_ORDER, _DRAW_THE_ORDER) if words.order_repeats else Said(shown)


def _of_gyro(test: BeliefTest) -> str:
    shown = f"{_SYMBOLS[test.name][0]} = {within(test.size, 2.0 * test.uncertainty)} ppm{_or_neighbour(test)}: "
    return shown + ", or ".join(map(_where_in_gyro, (test.name, *test.fit_as_well))) + _OR_THE_RATES


def _of_accelerometer(test: BeliefTest, scale: Scale) -> str:
    size, (symbol, unit) = test.size, _SYMBOLS[test.name]
    shown = f"{symbol} = {within(1e6 * size, 2e6 * test.uncertainty)} µ{unit} ({scale.words(abs(size))})"
    untold = "" if abs(size) > 2.0 * test.uncertainty else _UNTOLD
    bends = ", or ".join(IN_WORDS[term] for term in (test.name, *test.fit_as_well))
    confounded = f"; {CONFOUNDED}" if test.kind == "quadratic" else ""
    return f"{shown}{_or_neighbour(test)}: {bends}{untold}{confounded}"


def _or_neighbour(test: BeliefTest) -> str:
    """Return the term that nothing tells from this one: a bend from an asymmetry."""
    others = " and ".join(_SYMBOLS[name][0] for name in test.fit_as_well)
    return f", or {others}: this design does not tell them apart" if others else ""


def _barely_significant(test: BeliefTest, level: float) -> str:
    """Return what is said of a size that chance lifted over the bound of its test, in good part; else nothing.

    A size that is told because it is beyond a bound is too large on average: at the bound by more than one and a half
    standard deviations, two beyond it by less than a tenth (the mean of a normal distribution cut off there).
    """
    beyond = normal_quantile(1.0 - 0.5 * level) + _BIASED_SD
    return _BARELY if test.p_value > 2.0 * normal_share(-beyond) else ""


def _where_in_gyro(name: str) -> str:
    """Return what a term of a gyro's scale factor is, and where it stands."""
    if name == "K1'":
        return f"{GYROS_IN_WORDS[name]}; it is in no term of the result, which takes part of it for nonlinearity"
    return f"{GYROS_IN_WORDS[name]}, by so much of it at the largest rate"


def change_words(change: TermChange, scale: Scale) -> str:
    """Return how a term changes with temperature."""
    per_g, unit = scale.volts_per_radian, f"µ{change.unit if scale.volts_per_radian is None else 'g' + change.unit[1:]}"
    unit, factor = (PPM, 1.0) if change.unit == PPM else (unit, 1e6 / (per_g or 1.0))
    size = within(factor * change.per_degc, 2.0 * factor * change.standard_uncertainty)
    return f"{_SYMBOLS[change.name][0]} by {size} {unit} per °C"


WORDS: Final[Mapping[str, Callable[[BeliefTest, AxisWords], Said]]] = dict.fromkeys(_SYMBOLS, _term)
