"""A comparison of calibrations for a person, as a table and as a document."""

from collections.abc import Sequence
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from ams.parameter_words import words_of
from ams.units import ARCSEC_PER_DEG, small_unit
from procedures.check.candidate import Candidate, Comparison
from procedures.check.candidate_file import cannot_see, hours_source, left_open, target_in_words, what_holds_it
from procedures.plan.drift_bias import TIME_CONFOUNDED

SHOWN = ("offset_v", "sensitivity_v_per_g")
MOST_ROWS = 14


def render_comparison(comparison: Comparison) -> Group:
    """Return the candidates that no other beats, and what the chosen one cannot see."""
    chosen = comparison.candidates[comparison.chosen]
    names = [name for name in SHOWN if name in chosen.parameters]
    halves = [f"{words_of(name).symbol} ±\n({small_unit(words_of(name).unit)[0]})" for name in names]
    table = Table(
        "",
        "points ×\nreplications ×\nreadings",
        "NPLC",
        "order",
        "hours",
        "U95\n(″)",
        "calibra-\ntion (″)",
        *halves,
        box=None,
    )
    for place in _shown(comparison):
        one = comparison.candidates[place]
        table.add_row(
            "→" if place == comparison.chosen else "",
            f"{one.points} × {one.replications} × {one.samples}",
            _nplc(one),
            one.order,
            f"{one.hours:.2f}",
            f"{one.half_width_deg * ARCSEC_PER_DEG:.3g}",
            f"{one.calibration_deg * ARCSEC_PER_DEG:.3g}",
            *(_scaled(one, name) for name in names),
        )
    low, high = comparison.asked.usage.pitch_deg
    each = f", {chosen.hours / comparison.sensors:.2g} h each of {comparison.sensors}" if comparison.sensors > 1 else ""
    return Group(
        table,
        f"{len(comparison.candidates)} calibrations compared; shown are some that no other beats. →: "
        f"{target_in_words(comparison.asked.target)}: {chosen.hours:.2f} h{each}",
        f"hours: half of such runs take longer (p50), by {hours_source(comparison)}; NPLC: own is the readout's; "
        f"{_halves_in_words(names)}",
        f"U95: rms of the 95 % half-width of one future angle over pitch {low:g}° to {high:g}° and every roll, at "
        f"{comparison.asked.usage.noise_arcsec:.2g}″ a reading; the worst angle of the worst sensor",
        "",
        _otherwise(comparison, chosen),
        "time: correlation of time with a term of the model; an order above "
        f"{TIME_CONFOUNDED:g} lets a drift pass for a parameter, the report says so, and none is chosen",
        *cannot_see(chosen),
        *map(escape, left_open(comparison.asked.rig)),
        *what_holds_it(comparison, chosen),
    )


def _halves_in_words(names: Sequence[str]) -> str:
    told = (f"{words_of(name).symbol} the {words_of(name).label}" for name in names)
    return f"±: 95 % half-width ({', '.join(told)})"


def _otherwise(comparison: Comparison, chosen: Candidate) -> Table:
    """Return the chosen calibration in the other orders, and with fewer sensors on the table at once."""
    table = Table(
        "the same in order", "points", "sensors at once", "hours a run", "for all", "U95\n(″)", "time", box=None
    )
    for one in comparison.candidates:
        is_other_order = one.sensors == chosen.sensors and one.order != chosen.order
        if _but_order(one) == _but_order(chosen) and (is_other_order or one.order == chosen.order):
            table.add_row(
                f"{'→ ' if one is chosen else ''}{one.order}",
                str(one.points),
                str(one.sensors),
                f"{one.run_hours:.2f}",
                f"{one.hours:.2f}",
                f"{one.half_width_deg * ARCSEC_PER_DEG:.3g}",
                f"{one.time_correlation:.2f}",
            )
    return table


def _but_order(one: Candidate) -> object:
    return {**one.design, "order": None}, one.replications, one.samples, one.nplc


def _nplc(one: Candidate) -> str:
    return "own" if one.nplc is None else f"{one.nplc:g}"


def _shown(comparison: Comparison) -> list[int]:
    """Return the chosen one with its neighbours, and the ends: a front may have forty places."""
    front, most = list(comparison.front), MOST_ROWS
    place = front.index(comparison.chosen)
    first = min(max(place - most // 2, 0), max(len(front) - most, 0))
    return sorted({front[0], *front[first : first + most], front[-1]})


def comparison_document(comparison: Comparison) -> dict[str, Any]:
    """Return the form of ``calrig plan --json``."""
    return {
        "candidates": [_document(one) for one in comparison.candidates],
        "chosen": comparison.chosen,
        "front": list(comparison.front),
        "sensors": comparison.sensors,
        "duration_learned_from": comparison.asked.learned.runs,
        "usage_pitch_deg": list(comparison.asked.usage.pitch_deg),
        "usage_noise_arcsec": comparison.asked.usage.noise_arcsec,
    }


def _document(one: Candidate) -> dict[str, Any]:
    return {
        "points": one.points,
        "replications": one.replications,
        "samples": one.samples,
        "nplc": one.nplc,
        "order": one.order,
        "sensors": one.sensors,
        "hours": one.hours,
        "run_hours": one.run_hours,
        "time_correlation": one.time_correlation,
        "half_width_deg": one.half_width_deg,
        "calibration_half_width_deg": one.calibration_deg,
        "shares_deg": dict(one.shares_deg),
        "half_width_95": dict(one.parameters),
        "design": dict(one.design),
        "sees_lack_of_fit_arcsec": one.sees_lack_of_fit_arcsec,
        "sees_drift_arcsec": one.sees_drift_arcsec,
        "blind_to": list(one.blind_to),
    }


def _scaled(one: Candidate, name: str) -> str:
    factor = small_unit(words_of(name).unit)[1]
    return f"{one.parameters[name] * factor:.3g}" if name in one.parameters else "–"
