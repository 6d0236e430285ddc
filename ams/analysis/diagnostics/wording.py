"""What the tests of an axis say in words: a sentence for what was found, and a short one for what was not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf, isfinite
from types import MappingProxyType
from typing import Final

import numpy as np

from ams.analysis.diagnostics.beliefs import (
    AUTOCORRELATION,
    BY_POINT,
    BY_POINT_GAIN,
    BY_REPLICATION,
    CURVATURE,
    DRIFT_OF,
    LACK_OF_FIT,
    LAG,
    MEMORIES,
    OVER_TIME,
    ROBUST,
    SETTLING,
    SLIP,
    SQUARENESS,
    STEP,
    TABLE_LIMIT,
    TERMS_OVER_TEMPERATURE,
    TURNED_FROM,
    TURNED_FROM_ALIKE,
    UNEVEN,
    WRONG_DWELL,
    AxisTests,
    BeliefTest,
    TermChange,
)
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.facts import CONTAINED, as_the_order_has_it
from ams.analysis.diagnostics.held_words import BESIDE_MEMORY, lack_words
from ams.analysis.diagnostics.low_order import GYROS_IN_WORDS, IN_WORDS, PPM, TERMS
from ams.analysis.diagnostics.table_curves import TableLimit
from ams.analysis.diagnostics.table_limit_wording import of_table_limit
from ams.analysis.diagnostics.take_back import redo_command, void_command
from ams.analysis.diagnostics.uneven_noise import uneven_text
from ams.analysis.diagnostics.wrong_dwells import WrongDwells
from ams.findings import Finding
from ams.inputs.known_of_run import DwellLabels
from ams.models.extended import CONFOUNDED
from ams.observations import Observations
from ams.rounding import two_digits, with_uncertainty
from ams.statistics.distributions import normal_quantile, normal_share
from ams.units import ARCSEC_PER_DEG, printed

MOST_LISTED: Final = 5
"""Wrong dwells that a sentence names; all stand in ``steps``."""
_NOT_HELD: Final = frozenset({SETTLING, BY_POINT, BY_POINT_GAIN, LAG, TERMS_OVER_TEMPERATURE, ROBUST, *MEMORIES})
"""What is alike in every replication, passes for a sensitivity, or reads to one side: no scatter between replications
holds it."""
MOST_MOVED: Final = 6.0
"""How many times the difference of a robust fit dwells to one side move an offset: simulated for 5 to 20 % of them at 4
to 8 standard deviations, 1.2 to 7."""
_SYMBOLS: Final = {name: (symbol, unit) for name, _, symbol, unit in TERMS}


@dataclass(frozen=True)
class Scale:
    """What turns an output into words: as an angle where the sensitivity is known, in its unit elsewhere."""

    unit: str
    volts_per_radian: float | None

    def words(self, size: float) -> str:
        if self.volts_per_radian is None or abs(size) > self.volts_per_radian:
            return f"{two_digits(size)} {printed(self.unit)}"
        return f"{two_digits(np.rad2deg(size / self.volts_per_radian) * ARCSEC_PER_DEG)}″"


@dataclass(frozen=True)
class Convicted:
    """Wrong dwells of one axis as rows of the observations."""

    found: WrongDwells
    rows: tuple[int, ...]


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
    beyond = {*_NOT_HELD, *([LACK_OF_FIT] if other_angles or is_large else [])}
    for name, test in tests.tests.items():
        is_significant = tests.is_significant[name]
        details = {"test": name, **_numbers(test)}
        if name == TABLE_LIMIT and limit is not None:
            found.append(of_table_limit(test, limit, is_significant=is_significant))
            continue
        if name in (SLIP, STEP) and is_significant:
            continue  # told in the words of the diagnosis
        if name == WRONG_DWELL and convicted is not None:
            found.append(_wrong(test, scale, observations, convicted, details, alike))
            continue
        if is_significant:
            text = _significant(test, scale, drifts, has_table=has_table, drift_is=drift_is, lack_is=lack_is)
            text += _barely_significant(test, tests.conviction_level) if name in _SYMBOLS else ""
        else:
            text = f"{name}: {_not_significant(test)}{_beside(test, scale)}"
        is_held = name not in beyond or (name == ROBUST and MOST_MOVED * abs(test.size) <= offset_expanded)
        if name == ROBUST and is_significant:
            text += f"; that is {'' if is_held else 'not '}in the stated uncertainty of the offset"
        found.append(Finding(test.kind, text, is_significant, test.p_value, details=details, is_held=is_held))
    return tuple(found)


def _numbers(test: BeliefTest) -> dict[str, float | str | None]:
    if not isfinite(test.size):
        return {}
    found: dict[str, float | str | None] = {"size": test.size}
    if isfinite(test.uncertainty):
        found["time_constant_h" if test.name == LAG else "standard_uncertainty"] = test.uncertainty
    if test.unit:
        found["unit"] = test.unit
    return found


def _beside(test: BeliefTest, scale: Scale) -> str:
    """Return what is told of a test also where nothing was found."""
    return f", {_robust_words(test, scale)} from the estimate" if test.name == ROBUST else ""


def _robust_words(test: BeliefTest, scale: Scale) -> str:
    return f"{scale.words(test.size)} in the mean over the attitudes (by chance ±{scale.words(test.uncertainty)})"


def _not_significant(test: BeliefTest) -> str:
    if not test.is_explained:
        return "not significant"
    if test.name in (*MEMORIES, BY_REPLICATION, SETTLING, LACK_OF_FIT, ROBUST):
        return "explained by what a dwell knows of the one before it"
    return "explained by a drift" if test.name in (SLIP, STEP) else "explained by temperature"


_UNTOLD: Final = "; it is plain by itself, and beside the other terms of the model the attitudes do not tell its size"
_BARELY: Final = "; only just told: such sizes come out too large on average, and the term may be much smaller"
_BIASED_SD: Final = 2.0


def _significant(
    test: BeliefTest, scale: Scale, drifts: Mapping[str, str], *, has_table: bool, drift_is: str, lack_is: str
) -> str:
    name, size = test.name, test.size
    if test.unit == PPM:
        shown = f"{_SYMBOLS[name][0]} = {_within(size, 2.0 * test.uncertainty)} ppm{_or_neighbour(test)}: "
        return shown + ", or ".join(map(_of_gyro, (name, *test.fit_as_well)))
    if name in _SYMBOLS:
        symbol, unit = _SYMBOLS[name]
        shown = f"{symbol} = {_within(1e6 * size, 2e6 * test.uncertainty)} µ{unit} ({scale.words(abs(size))})"
        untold = "" if abs(size) > 2.0 * test.uncertainty else _UNTOLD
        bends = ", or ".join(IN_WORDS[term] for term in (name, *test.fit_as_well))
        return f"{shown}{_or_neighbour(test)}: {bends}{untold}" + (
            f"; {CONFOUNDED}" if test.kind == "quadratic" else ""
        )
    if name.startswith(DRIFT_OF):
        quantity = name.removeprefix(DRIFT_OF)
        moved = f" by {drifts[quantity]} (largest less smallest)" if quantity in drifts else ""
        return f"{quantity} changed from replication to replication{moved}; {drift_is}"
    sentences = {
        **_of_residuals(test, scale, lack_is, has_table=has_table),
        **_of_order(test, scale, drift_is),
        **_of_temperature(test, scale),
    }
    return sentences[name]()


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


def _of_gyro(name: str) -> str:
    """Return what a term of a gyro's scale factor is, and where it stands."""
    if name == "K1'":
        return f"{GYROS_IN_WORDS[name]}; it is in no term of the result, which takes part of it for nonlinearity"
    return f"{GYROS_IN_WORDS[name]}, by so much of it at the largest rate"


def _of_residuals(test: BeliefTest, scale: Scale, lack_is: str, *, has_table: bool) -> dict[str, Callable[[], str]]:
    """Return what is said of residuals that repeat, stand out, or show the table."""
    return {
        LACK_OF_FIT: lambda: (
            f"the residuals repeat from replication to replication: lack of fit, {scale.words(test.size)} (standard "
            f"deviation over the attitudes)"
            f"{', more than the table’s index errors explain' if has_table else ''}; {lack_is}"
        ),
        WRONG_DWELL: lambda: (
            "more than a tenth of the dwells stand out from their replications: this is no matter of single dwells but "
            "of an unsteady sensor, channel or supply; look at the noise of the channel before the result is used"
        ),
        ROBUST: lambda: (
            f"a robust fit, which gives little weight to dwells that stand out, is {_robust_words(test, scale)} from "
            f"the estimate: dwells read too far to one side, each too little to be named, or the noise is longer to "
            f"one side; either moves the estimate, by up to some {MOST_MOVED:.0f} times this difference; look at the "
            "residuals of the channel"
        ),
        UNEVEN: lambda: uneven_text(test),
        SQUARENESS: lambda: (
            f"the axes of the table are not at right angles: "
            f"{two_digits(np.rad2deg(abs(test.size)) * ARCSEC_PER_DEG)}″ ± "
            f"{two_digits(np.rad2deg(2.0 * test.uncertainty) * ARCSEC_PER_DEG)}″, which this output sees at high "
            "pitch; predictions hold part of it: have the table looked at, or solve package and table together "
            "([solve] joint = true with a prior of squareness)"
        ),
    }


def _of_order(test: BeliefTest, scale: Scale, drift_is: str) -> dict[str, Callable[[], str]]:
    """Return what is said of outputs that know of time, or of the dwells before them."""
    return {
        OVER_TIME: lambda: (
            f"the offset drifts with time by {scale.words(abs(test.size))} an hour, evenly from replication to "
            f"replication; {drift_is}; a time term in the solution ([solve] time_term) tells it"
        ),
        AUTOCORRELATION: lambda: (
            f"a dwell knows of the dwell before it: correlation {test.size:.2g} inside the replications; the output "
            "wanders or has not settled; a longer settling time or a random order makes dwells independent"
        ),
        TURNED_FROM: lambda: _turned_text(test, scale, "", drift_is),
        **{name: partial(_memory_text, test, scale) for name in MEMORIES},
        TURNED_FROM_ALIKE: lambda: _turned_text(test, scale, ", alike in every replication", drift_is),
        SETTLING: lambda: (
            f"the output settles at the start of every replication: {scale.words(abs(test.size))} at its first dwell, "
            "over after about a quarter of its dwells; alike in each, it is in offset and sensitivities and not in the "
            "stated uncertainties: warm up and settle longer before the first dwell, leave the first dwells out, or "
            'draw the order of the points anew for every replication (order = "random")'
        ),
    }


def _of_temperature(test: BeliefTest, scale: Scale) -> dict[str, Callable[[], str]]:
    """Return what is said of outputs that follow a temperature, and of how they follow the chamber's."""
    return {
        BY_POINT: lambda: _temperature_text(test, scale, "in step with the points, alike in every replication"),
        BY_POINT_GAIN: lambda: _temperature_text(test, scale, "with its sensitivity, alike in every replication"),
        BY_REPLICATION: lambda: _temperature_text(test, scale, "from replication to replication"),
        LAG: lambda: (
            "lag against the chamber: the sensor is not as warm as the record: after heating and after cooling its "
            f"output is still on the way, by {scale.words(test.size)} (root mean square), as with a time constant of "
            f"about {test.uncertainty:g} h; soak longer, or measure the temperature in the sensor; temperature "
            "coefficients are not to be trusted"
        ),
        CURVATURE: lambda: (
            f"quadratic in temperature: offset or sensitivity bend by {scale.words(test.size)} (root mean square), "
            "which a straight line over temperature does not have; use the result near the temperatures measured, or "
            "solve with terms of second order ([solve] temperature_order = 2)"
        ),
        TERMS_OVER_TEMPERATURE: lambda: (
            "terms of second or third order change with temperature: "
            f"{', '.join(_change_words(change, scale) for change in test.changes)}; {scale.words(test.size)} over the "
            "temperatures measured (root mean square), which no term of the result has: away from their mean "
            "predictions and attitudes are off by more than is stated; calibrate at the temperature of use"
        ),
    }


def _change_words(change: TermChange, scale: Scale) -> str:
    per_g, unit = scale.volts_per_radian, f"µ{change.unit if scale.volts_per_radian is None else 'g' + change.unit[1:]}"
    unit, factor = (PPM, 1.0) if change.unit == PPM else (unit, 1e6 / (per_g or 1.0))
    within = _within(factor * change.per_degc, 2.0 * factor * change.standard_uncertainty)
    return f"{_SYMBOLS[change.name][0]} by {within} {unit} per °C"


def _turned_text(test: BeliefTest, scale: Scale, where: str, drift_is: str) -> str:
    by_chance = f"{CONTAINED} only as far as the order of the points makes chance of it"
    held = drift_is if drift_is == BESIDE_MEMORY else by_chance
    return (
        f"a dwell remembers the attitude before it: {scale.words(2.0 * abs(test.size))} after a turn from one end of "
        f"its range to the other{where}; hysteresis, or the output has not settled: a longer settling time tells "
        f"which; {held}"
    )


def _memory_text(test: BeliefTest, scale: Scale) -> str:
    about = test.name.removeprefix("memory of about ")
    together = "" if test.axes == 1 else f", as the {test.axes} of the package show it together,"
    return (
        f"the output{together} remembers the attitudes of about {about} before: "
        f"{_per_g(test.size, test.uncertainty, scale)} of what the force along the axis changed by, fading from dwell "
        f"to dwell{_as_well(test)}; creep of the sensor, of its mount or its case, or a channel that has not settled; "
        "sensitivities hold most of it, and the stated uncertainties only a limit that is declared "
        "(largest_nonlinearity_v): dwell longer, or wait longer before each reading, and measure again"
    )


def _as_well(test: BeliefTest) -> str:
    others = [name.removeprefix("memory of about ") for name in test.fit_as_well]
    return f" ({' and '.join(others)} fit{'s' if len(others) == 1 else ''} as well, of another size)" if others else ""


def _per_g(size: float, uncertainty: float, scale: Scale) -> str:
    if scale.volts_per_radian is None:
        return f"{_within(abs(size), 2.0 * uncertainty)} {printed(scale.unit)} a g"
    micro = 1e6 / scale.volts_per_radian
    return f"{_within(micro * abs(size), 2.0 * micro * uncertainty)} µg a g ({scale.words(abs(size))})"


def _temperature_text(test: BeliefTest, scale: Scale, where: str) -> str:
    return (
        f"the output follows the recorded temperature by {scale.words(abs(test.size))} a °C, {where}, and no "
        "temperature is modelled: offset and sensitivities hold part of it; apply known temperature coefficients, or "
        "hold the temperature"
    )


def _wrong(
    test: BeliefTest,
    scale: Scale,
    observations: Observations,
    convicted: Convicted,
    details: Mapping[str, float | str | None],
    alike: Mapping[DwellLabels, str],
) -> Finding:
    rows, found = convicted.rows, convicted.found
    turns = [alike.get((int(observations.replication[row]), int(observations.point[row])), "") for row in rows]
    dwells = [
        f"{dwell_words(observations, row)} is off by {scale.words(size)}"
        f" ({two_digits(abs(deviations))} standard deviations of a dwell"
        f"{f'; a table that stood off by {turn} would look the same here' if turn else ''})"
        for row, size, deviations, turn in zip(rows, found.sizes, found.deviations, turns, strict=True)
    ]
    more = len(dwells) - MOST_LISTED
    listed = "; ".join(dwells[:MOST_LISTED]) + (f"; and {more} more" if more > 0 else "")
    first = rows[0]
    steps = () if observations.step is None else tuple(int(observations.step[row]) for row in rows)
    redo = redo_command(observations.replication[first], observations.run)
    way_out = (
        f"measure it again ({redo}, or {void_command(min(steps), observations.run)})"
        if steps
        else f"look at it, or take {'its row' if len(rows) == 1 else 'their rows'} out of {observations.source} and "
        "solve it again"
    )
    text = (
        f"wrong dwell: {listed}, against what the other replications say; it is in the result and in its uncertainty, "
        f"and left out of all other tests; {way_out}"
    )
    numbers = {
        **details,
        **({"confounded_with": "table-rotation"} if any(turns) else {}),
        "replication": float(observations.replication[first]),
        "point": float(observations.point[first]),
        "pitch_deg": float(np.rad2deg(observations.pitch_rad[first])),
        "roll_deg": float(np.rad2deg(observations.roll_rad[first])),
    }
    return Finding("wrong-dwell", text, True, test.p_value, steps, numbers)


def _within(value: float, expanded: float) -> str:
    """Return a value to the last of the two digits of its ±, which a rounder value would lie outside of."""
    if not (isfinite(value) and isfinite(expanded)) or expanded <= 0.0:
        return f"{two_digits(value)} ± {two_digits(expanded)}"
    return " ± ".join(with_uncertainty(value, expanded)).replace("-", "−")
