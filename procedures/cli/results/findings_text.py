"""What a fit says beyond its numbers, for a person: advice, F-test, H_E and budget, as lines under each axis."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from ams.parameter_words import words_of
from ams.statistics.budget import NEGLIGIBLE
from ams.units import dof_words
from procedures.errors import RequestError

_BY: Final = "standard uncertainty by"
_TABLE_WIDTH, _CELL_WIDTH = 74, 9
"""Of the table of a budget, which stands six letters from the left of a terminal of 80."""
MOST_TRIALS = 10_000_000
LEAST_TRIALS = 1_000


def check_trials(trials: int, *, is_possible: bool) -> None:
    """Check the number of Monte Carlo trials.

    Raises: RequestError for a number that says nothing, or that would not end.
    """
    if trials != 0 and not LEAST_TRIALS <= trials <= MOST_TRIALS:
        raise RequestError(
            f"--monte-carlo: got {trials} trials, allowed {LEAST_TRIALS} to {MOST_TRIALS} (or 0: none); a million "
            "settles two digits"
        )
    if trials != 0 and not is_possible:
        raise RequestError("--monte-carlo: checks the budget of attitude and rate models: not of linear and --joint")


def findings_lines(axis: Mapping[str, Any]) -> Iterator[str]:
    """Yield the findings of one axis of a document; nothing where it holds none (a stored set)."""
    if "extension" in axis:
        found = axis["extension"]
        verdict = "significant" if found["is_accepted"] else "not significant"
        against = "above" if found["is_accepted"] else "against"
        yield (
            f"{found['terms']} {verdict}: F = {found['f']:.3g} {against} {found['f_95']:.3g}; standard error "
            f"{found['standard_error_before_v']:.3g} V without and {found['standard_error_after_v']:.3g} V with them"
        )
    yield from (f"advice: {sentence}" for sentence in axis.get("advice", {}).get("sentences", ()))
    if "residual_curvature" in axis:
        yield _curvature(axis["residual_curvature"])
    if "budget" in axis:
        yield from _budget(axis["budget"])


def _curvature(found: Mapping[str, Any]) -> str:
    ratios = found["standard_uncertainty_ratio"]
    if not any(any(row) for row in found["h_e"]):
        return "H_E is zero: the model is linear in its primary parameters"
    if any(ratio is None for ratio in ratios.values()):
        return "with H_E the answer is no minimum: look for wrong rows"
    changes = ", ".join(f"{words_of(name).label} × {ratio:.4f}" for name, ratio in ratios.items())
    return f"H_E would change the standard uncertainties: {changes}"


def _budget(budget: Mapping[str, Any]) -> Iterator[str]:
    """Yield an uncertainty budget: its sources, numbered, then a row for each parameter.

    A row says what each source puts into the parameter, and what all make.
    """
    lines, combined = budget["lines"], budget["combined_standard_uncertainty"]
    if len(lines) > 1:
        yield "uncertainty budget:"
        yield from (f"  {number} {_source(line)}" for number, line in enumerate(lines, start=1))
        yield from (f"  {line}" for line in _table(lines, combined, budget["expanded_uncertainty_95"]))
    if "monte_carlo" in budget:
        check = budget["monte_carlo"]
        missed = {name: found for name, found in check["parameters"].items() if not found["is_confirmed"]}
        verdict = "its 95 % intervals differ for" if missed else "confirms the 95 % intervals to one digit of u"
        yield f"Monte Carlo, {check['trials']} trials, seed {check['seed']}: {verdict}"
        for name, found in missed.items():
            label, _, unit = words_of(name)
            low, high = found["interval_95"]
            yield f"  {f'{label} {unit}':<32}{low:.9g} to {high:.9g}"


def _table(
    lines: Sequence[Mapping[str, Any]], combined: Mapping[str, float], expanded: Mapping[str, float | None]
) -> Iterator[str]:
    """Yield a row for each parameter, a column for each source and for what all make; below each other what is wide."""
    labels = {name: f"{words_of(name).label} {words_of(name).unit}" for name in combined}
    width = max(map(len, (_BY, *labels.values())))
    columns = [
        (str(number), {name: _cell(line["standard_uncertainty"][name], combined[name]) for name in combined})
        for number, line in enumerate(lines, start=1)
    ]
    columns += [
        (heading, {name: _number(found[name]) for name in combined})
        for heading, found in (("combined", combined), ("95 %", expanded))
    ]
    side_by_side = max(1, (_TABLE_WIDTH - width) // _CELL_WIDTH)
    for first in range(0, len(columns), side_by_side):
        part = columns[first : first + side_by_side]
        yield f"{_BY:<{width}}" + "".join(f"{heading:>{_CELL_WIDTH}}" for heading, _ in part)
        for name, label in labels.items():
            yield f"{label:<{width}}" + "".join(f"{cells[name]:>{_CELL_WIDTH}}" for _, cells in part)


def _number(value: float | None) -> str:
    """Return an uncertainty; what has none, such as a known coefficient without one, counts as exact."""
    return "exact" if not value else f"{value:.2g}"


def _source(line: Mapping[str, Any]) -> str:
    dof = "" if line["degrees_of_freedom"] is None else f", {dof_words(line['degrees_of_freedom'])}"
    stated = f" ({line['stated']})" if line["stated"] else ""
    return f"type {line['type']}: {line['source']}{stated}{dof}"


def _cell(value: float | None, combined: float) -> str:
    is_small = value is None or value < NEGLIGIBLE * combined
    return "·" if is_small else f"{value:.2g}"
