"""What the attitudes and their order cannot tell, and what a drift did to the estimate because of that order."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.time_order import (
    LARGEST_CORRELATION,
    EvenDrift,
    InOrder,
    confounding,
    confounding_in_layings,
    row_time,
)
from ams.arrays import FloatArray
from ams.findings import Finding
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.drifting import DRIFT_NAME, SECONDS_PER_HOUR
from ams.models.model import Model
from ams.models.thermal import TEMPERATURE_NAMES
from ams.parameter_words import words_of
from ams.rounding import significant
from ams.sets.verdict_conditions import NO_TIMES
from ams.statistics.intervals import t_factor
from ams.units import label_and_unit, signed_in_words

_DISTINGUISHED, _LEVEL = 3.0, 0.99
"""Standard uncertainties at the least, and the level of Student's factor where few replications know them badly: of
dead channels of two replications one in a hundred is told from zero by it, and a live one whose sensitivity these know
to no better than 1/64 is not.
"""
_EXPANDED = 2.0
"""Standard uncertainties of an expanded one: what is declared of an offset has no degrees of freedom."""
_MOST_NAMED = 3
"""Parameters in a sentence."""
_ORDER_OF_ROWS, _NO_ORDER = "order of the rows with attitude", "order of the rows"
"""Tests of rows without times: how the one goes with the other, and where nothing says in which order they stand."""
CONTAINED = "it is contained in the stated uncertainties"
_PASSES = "of that, what went on inside the replications is not in the stated uncertainties, as the order has it"
_NOT_SENSED = "what was visited does not change what this axis senses, or the channel is dead or its input open"
_ERRORS_COUNTED = "errors that the rows show, and that are counted, are as large as what this axis senses"
_LESS_OF_THEM = "remove their cause (the budget names the source) and measure again"
_UNJUDGED = (
    "whether what went on inside the replications is in the stated uncertainties cannot be judged: no times are given, "
    "and the rows are not in the order of the replications; give the column time_s"
)


def stimulus_of(model: Model) -> str:
    """Return in one word what the points of a model set: attitudes, rates or levels."""
    if any(name.endswith("_v_per_dps") for name in model.primary_names):
        return "rate"
    return "level" if model.convention == "SR" else "attitude"


def undetermined_axis(
    model: Model, primary: FloatArray, covariance: FloatArray, dof: FloatArray, *, by_errors: bool = False
) -> Iterator[Finding]:
    """Yield a finding where the sensitivity along the nominal axis is not told from zero.

    ``primary``, ``dof``: (P,); ``covariance``: (P, P). ``by_errors``: it is, but for errors that the rows show and that
    are counted in the covariance.
    """
    name = next(
        (primary_name for primary_name in model.primary_names if primary_name.startswith(f"k_{model.nominal_axis}_")),
        None,
    )
    if name is None:
        return
    index = model.primary_names.index(name)
    k, u = float(primary[index]), float(np.sqrt(max(covariance[index, index], 0.0)))
    if not abs(k) <= max(_DISTINGUISHED, t_factor(_LEVEL, float(dof[index]))) * u:
        return
    unit = words_of(name).unit
    size = f"{significant(k, 3)} {unit}"
    fact = (
        f"the sensitivity along the nominal axis {model.nominal_axis} is not told from zero: {size} with a "
        f"standard uncertainty of {significant(u)} {unit}: {_ERRORS_COUNTED if by_errors else _NOT_SENSED}; the "
        "result is not usable and there is no coefficient set"
    )
    yield Finding(
        "axis-undetermined",
        fact,
        True,
        None,
        details={"sensitivity": k, "standard_uncertainty": u},
        what_to_do=_LESS_OF_THEM if by_errors else "add attitudes that change it, or leave this axis out",
    )


def undetermined_offset(model: Model, primary: FloatArray, covariance: FloatArray) -> Iterator[Finding]:
    """Yield a finding where the offset of an accelerometer is known no better than the output changes by over 1 g."""
    offset, along = "offset_v", f"k_{model.nominal_axis}_v_per_g"
    if offset not in model.primary_names or along not in model.primary_names:
        return
    index = model.primary_names.index(offset)
    u = float(np.sqrt(max(covariance[index, index], 0.0)))
    change_v = abs(float(primary[model.primary_names.index(along)]))
    if not change_v <= _EXPANDED * u:
        return
    fact = (
        f"the offset has a standard uncertainty of {significant(u)} V where the output changes by "
        f"{significant(change_v, 3)} V from 0 to 1 g: no angle is told by this axis; the result is not usable and "
        "there is no coefficient set"
    )
    yield Finding(
        "axis-undetermined",
        fact,
        True,
        None,
        details={"sensitivity": change_v, "standard_uncertainty": u},
        what_to_do="correct what is declared (the budget names the source), or measure again",
    )


_THERE_AND_BACK: Final = "such as there-and-back"


@dataclass(frozen=True)
class _Together:
    """How the order of time goes with the points: its correlation, where, and what passes for parameters by it."""

    r: float
    where: str
    passes: str
    otherwise: str
    """Which order tells them apart."""
    by_term: str = ""
    """What tells them apart in any order, as a sentence goes on with it."""


def _in_replications(r: float, stimulus: str) -> _Together:
    """``stimulus``: levels are few, and there and back has them in one order."""
    otherwise = "that every second replication reverses (forward-reverse)" if stimulus == "level" else _THERE_AND_BACK
    passes = "a drift within a replication would pass for offset and sensitivity"
    by_term = ", or take an even drift into the solution (--time-term linear; [solve] time_term)"
    return _Together(r, "inside the replications", passes, f"an order {otherwise}", by_term)


def _in_layings(points: InOrder, time_s: FloatArray) -> Iterator[_Together]:
    """Yield how they go together inside the runs of rows of one laying, where they do."""
    r = confounding_in_layings(points, LINEAR_COLUMNS, time_s)
    if r is None or not r > LARGEST_CORRELATION:
        return
    if stimulus_of(points.models[0]) == "rate":
        while_, otherwise = "while it turns about one axis", "alternate the senses at two rates or more"
    else:
        while_, otherwise = "from one move of the slower axis to the next", "take the other sense in every second row"
    passes = (
        "what comes back each time, such as a zero that warms up and is back at the next, would pass for sensitivity"
    )
    yield _Together(r, while_, passes, f"an order that goes there and back {while_}, or {otherwise}")


def _even_drift_is_solved(points: InOrder) -> bool:
    return DRIFT_NAME in points.models[0].primary_names


def _confounded(points: InOrder, r: float | None, time_s: FloatArray) -> list[_Together]:
    """Return where the order goes with the points: through the replications, else inside the layings; nowhere: empty.

    ``r``: inside the replications. An even drift in the solution holds what goes on through them, not what comes back
    with every laying.
    """
    if r is not None and r > LARGEST_CORRELATION and not _even_drift_is_solved(points):
        return [_in_replications(r, stimulus_of(points.models[0]))]
    return [*_in_layings(points, time_s)]


def time_confounded(points: InOrder) -> Iterator[Finding]:
    """Yield a finding on the order of the points; without times one that is not significant, of the order of rows."""
    time_s = points.rows.time_s
    if time_s is None:
        yield from _rows_confounded(points)
        return
    r = confounding(points, LINEAR_COLUMNS, time_s)
    what, met = stimulus_of(points.models[0]), _confounded(points, r, time_s)
    details: dict[str, float | str | None] = {"test": "time with attitude"}
    for found in met:
        fact = (
            f"time and {what} go together {found.where} (correlation {found.r:.2f}, allowed {LARGEST_CORRELATION:g}): "
            f"{found.passes} and is not in the uncertainties"
        )
        what_to_do = f"measure every replication to its end, in {found.otherwise}{found.by_term}"
        details |= {"correlation": found.r}
        yield Finding("time-confounded", fact, True, None, details=details, what_to_do=what_to_do)
    if not met and r is not None:
        fact = (
            f"time and {what}: correlation {r:.2f} inside the replications, allowed {LARGEST_CORRELATION:g}"
            f"{'; an even drift is in the solution' if _even_drift_is_solved(points) else ''}"
        )
        yield Finding("time-confounded", fact, False, None, details={**details, "correlation": r})


def _rows_confounded(points: InOrder) -> Iterator[Finding]:
    """Yield what the order of rows without times tells: nothing is wrong with a run only because it has no times."""
    passed = row_time(points)
    if passed is None:
        fact = (
            f"{NO_TIMES}, and the rows are not in the order of the replications: a drift inside the replications "
            "cannot be judged, and is not in the uncertainty"
        )
        what_to_do = "give the column time_s, or the rows in the order in which they were measured"
        yield Finding("time-confounded", fact, False, None, details={"test": _NO_ORDER}, what_to_do=what_to_do)
        return
    r = confounding(points, LINEAR_COLUMNS, passed)
    for found in _confounded(points, r, passed):
        fact = (
            f"{NO_TIMES}, and the order of the rows, taken for them, goes with the {stimulus_of(points.models[0])} "
            f"{found.where} (correlation {found.r:.2f}, allowed {LARGEST_CORRELATION:g}): {found.passes}, and is not "
            "in the uncertainty"
        )
        details: dict[str, float | str | None] = {"test": _ORDER_OF_ROWS, "correlation": found.r}
        what_to_do = f"give the column time_s, and use {found.otherwise}"
        yield Finding("time-confounded", fact, False, None, details=details, what_to_do=what_to_do)


def untold_order(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Return what the order of rows without times leaves untested."""
    return tuple(found.text for found in findings if found.details.get("test") in (_NO_ORDER, _ORDER_OF_ROWS))


def as_the_order_has_it(findings: Iterable[Finding]) -> str:
    """Return whether a drift is in the uncertainties: not where the order lets it pass, or where none is known."""
    of_order = [finding for finding in findings if finding.kind == "time-confounded"]
    tests = {finding.details.get("test") for finding in of_order}
    if _NO_ORDER in tests:
        return _UNJUDGED
    return _PASSES if _ORDER_OF_ROWS in tests or any(finding.is_significant for finding in of_order) else CONTAINED


@dataclass(frozen=True)
class Moved:
    """What an even drift did to the parameters of one axis, as the order of its points has it."""

    names: tuple[str, ...]
    by: FloatArray
    """In the parameters' units."""
    uncertainties: FloatArray
    """Standard, as stated."""


def drift_in_parameters(drift: EvenDrift, moved: Moved, unit: str, *, has_times: bool) -> Iterator[Finding]:
    """Yield a finding where a drift that is plain moved a parameter by more than its standard uncertainty.

    Without times the drift is one from row to row.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(moved.uncertainties > 0.0, np.abs(moved.by) / moved.uncertainties, 0.0)
    share = np.nan_to_num(share)
    if not share.max() > 1.0:
        return
    beyond = [int(index) for index in np.argsort(-share)[:_MOST_NAMED] if share[index] > 1.0]
    shown = ", ".join(
        f"{quantity} by {signed_in_words(float(moved.by[index]), words)} ({significant(float(share[index]))} of its "
        "standard uncertainties)"
        for index in beyond
        for quantity, words in (label_and_unit(moved.names[index]),)
    )
    each, rate = ("an hour", drift.slope * SECONDS_PER_HOUR) if has_times else ("from row to row", drift.slope)
    taken = "" if has_times else f" ({NO_TIMES}; the order of the rows was taken for them, evenly spaced)"
    fact = (
        f"the output drifts evenly through the run, by {signed_in_words(rate, unit)} {each}{taken}, and the order "
        f"of the points lets that into the estimate: {shown}; the stated uncertainties do not hold it"
    )
    what_to_do = (
        f"{'' if has_times else 'give the column time_s, and then '}take the drift into the solution (--time-term "
        "linear; [solve] time_term), or measure in an order that lets less of it in (calrig check compares them)"
    )
    details: dict[str, float | str | None] = {
        "test": "drift in the parameters",
        "per_hour" if has_times else "per_row": rate,
        "largest_share_of_u": float(share.max()),
    }
    yield Finding("time-confounded", fact, True, drift.p_value, details=details, is_held=False, what_to_do=what_to_do)


def temperature_confounded(evidence: Evidence) -> Iterator[Finding]:
    """Yield a finding where the recorded temperature, which is not modelled, goes with the attitude."""
    if TEMPERATURE_NAMES[0] in evidence.models[0].primary_names:
        return
    r = confounding(evidence, LINEAR_COLUMNS, evidence.rows.temperature_degc)
    if r is None or not r > LARGEST_CORRELATION:
        return
    what = stimulus_of(evidence.models[0])
    fact = (
        f"the recorded temperature goes with the {what} inside the replications (correlation {r:.2f}, allowed "
        f"{LARGEST_CORRELATION:g}): what it does to the sensor passes for offset and sensitivity, and no temperature "
        "is modelled"
    )
    what_to_do = "hold the temperature, take another order of the points, or apply known temperature coefficients"
    details: dict[str, float | str | None] = {"test": "temperature with attitude", "correlation": r}
    yield Finding("temperature-residual", fact, True, None, details=details, what_to_do=what_to_do)
