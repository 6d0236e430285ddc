"""A comparison of calibrations for a person, as a table and as a document."""

from collections.abc import Iterator, Sequence, Sized
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from ams.calibration.layout_warnings import few_replications
from ams.parameter_words import words_of
from ams.units import ARCSEC_PER_DEG, small_unit
from procedures.check.candidate import Candidate, Comparison
from procedures.check.candidate_file import cannot_see, hours_source, left_open, target_in_words, what_holds_it
from procedures.plan.drift_bias import TIME_CONFOUNDED

AXES = ("pitch", "roll")
SHOWN = ("offset_v", "sensitivity_v_per_g")
MOST_ROWS = 14


def render_comparison(comparison: Comparison) -> Group:
    """Return the candidates that no other beats, and what the chosen one cannot see."""
    chosen = comparison.candidates[comparison.chosen]
    names = [name for name in SHOWN if name in chosen.parameters]
    halves = [f"{words_of(name).symbol} ±\n({small_unit(words_of(name).unit)[0]})" for name in names]
    table = Table(
        "",
        "points ×\nrepl. ×\nreadings",
        "NPLC",
        "design",
        "order",
        "hours",
        "U95\n(″)",
        "calibra-\ntion (″)",
        *halves,
        box=None,
    )
    for index in _shown(comparison):
        candidate = comparison.candidates[index]
        table.add_row(
            "→" if index == comparison.chosen else "",
            f"{candidate.points}×{candidate.replications}{_mark(candidate)}×{candidate.samples}",
            _nplc(candidate),
            _design(candidate),
            candidate.order,
            f"{candidate.hours:.2f}",
            f"{candidate.half_width_deg * ARCSEC_PER_DEG:.3g}",
            f"{candidate.calibration_deg * ARCSEC_PER_DEG:.3g}",
            *(_scaled(candidate, name) for name in names),
        )
    low, high = comparison.request.usage.pitch_deg
    each = f", {chosen.hours / comparison.sensors:.2g} h each of {comparison.sensors}" if comparison.sensors > 1 else ""
    return Group(
        table,
        f"{len(comparison.candidates)} calibrations compared; shown are some that no other beats. →: "
        f"{target_in_words(comparison.request.target)}: {chosen.hours:.2f} h{each}",
        *_few([comparison.candidates[index] for index in _shown(comparison)]),
        f"repl.: replications; hours: half of such runs take longer (p50), by {hours_source(comparison)}; NPLC: own is "
        f"the readout's; {_halves_in_words(names)}",
        f"U95: rms of the 95 % half-width of one future angle over pitch {low:g}° to {high:g}° and every roll, at "
        f"{comparison.request.usage.noise_arcsec:.2g}″ a reading; the worst angle of the worst sensor",
        "",
        _otherwise(comparison, chosen),
        "time: correlation of time with a term of the model; an order above "
        f"{TIME_CONFOUNDED:g} lets a drift pass for a parameter, the report says so, and none is chosen",
        *cannot_see(chosen),
        *map(escape, left_open(comparison.request.rig)),
        *what_holds_it(comparison, chosen),
    )


def _halves_in_words(names: Sequence[str]) -> str:
    phrases = (f"{words_of(name).symbol} the {words_of(name).label}" for name in names)
    return f"±: 95 % half-width ({', '.join(phrases)})"


def _otherwise(comparison: Comparison, chosen: Candidate) -> Table:
    """Return the chosen calibration in the other orders, and with fewer sensors on the table at once."""
    table = Table(
        "the same in order", "points", "sensors at once", "hours a run", "for all", "U95\n(″)", "time", box=None
    )
    for candidate in comparison.candidates:
        is_other_order = candidate.sensors == chosen.sensors and candidate.order != chosen.order
        if _but_order(candidate) == _but_order(chosen) and (is_other_order or candidate.order == chosen.order):
            table.add_row(
                f"{'→ ' if candidate is chosen else ''}{candidate.order}",
                str(candidate.points),
                str(candidate.sensors),
                f"{candidate.run_hours:.2f}",
                f"{candidate.hours:.2f}",
                f"{candidate.half_width_deg * ARCSEC_PER_DEG:.3g}",
                f"{candidate.time_correlation:.2f}",
            )
    return table


def _but_order(candidate: Candidate) -> object:
    return {**candidate.design, "order": None}, candidate.replications, candidate.samples, candidate.nplc


def _mark(candidate: Candidate) -> str:
    return "*" if any(few_replications(candidate.replications)) else ""


def _few(shown: Sequence[Candidate]) -> Iterator[str]:
    """Yield what `check` will hold against rows with an asterisk."""
    counts = sorted({candidate.replications for candidate in shown})
    yield from (f"*: a reservation of check and report: {text}" for count in counts for text in few_replications(count))


def _design(candidate: Candidate) -> str:
    """Tell designs of as many points apart: their kind, and their pitch and roll values."""
    sizes = (len(angles) if isinstance(angles := candidate.design.get(f"{name}_deg"), Sized) else None for name in AXES)
    grid = "×".join(str(size) for size in sizes if size is not None)
    return f"{candidate.design['kind']} {grid}" if grid else str(candidate.design["kind"])


def _nplc(candidate: Candidate) -> str:
    return "own" if candidate.nplc is None else f"{candidate.nplc:g}"


def _shown(comparison: Comparison) -> list[int]:
    """Return the chosen one with its neighbours, and the ends: a front may have forty places."""
    front, most = list(comparison.front), MOST_ROWS
    index = front.index(comparison.chosen)
    first = min(max(index - most // 2, 0), max(len(front) - most, 0))
    return sorted({front[0], *front[first : first + most], front[-1]})


def comparison_document(comparison: Comparison) -> dict[str, Any]:
    """Return the form of ``calrig plan --json``."""
    return {
        "candidates": [_document(candidate) for candidate in comparison.candidates],
        "chosen": comparison.chosen,
        "front": list(comparison.front),
        "sensors": comparison.sensors,
        "duration_learned_from": comparison.request.learned.runs,
        "usage_pitch_deg": list(comparison.request.usage.pitch_deg),
        "usage_noise_arcsec": comparison.request.usage.noise_arcsec,
    }


def _document(candidate: Candidate) -> dict[str, Any]:
    return {
        "points": candidate.points,
        "replications": candidate.replications,
        "samples": candidate.samples,
        "nplc": candidate.nplc,
        "order": candidate.order,
        "sensors": candidate.sensors,
        "hours": candidate.hours,
        "run_hours": candidate.run_hours,
        "time_correlation": candidate.time_correlation,
        "half_width_deg": candidate.half_width_deg,
        "calibration_half_width_deg": candidate.calibration_deg,
        "shares_deg": dict(candidate.shares_deg),
        "half_width_95": dict(candidate.parameters),
        "design": dict(candidate.design),
        "sees_lack_of_fit_arcsec": candidate.sees_lack_of_fit_arcsec,
        "sees_drift_arcsec": candidate.sees_drift_arcsec,
        "blind_to": list(candidate.blind_to),
    }


def _scaled(candidate: Candidate, name: str) -> str:
    factor = small_unit(words_of(name).unit)[1]
    return f"{candidate.parameters[name] * factor:.3g}" if name in candidate.parameters else "–"
