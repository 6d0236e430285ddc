"""What a fit says beyond its numbers, for a person: advice, F-test, H_E and budget, as lines under each axis."""

from collections.abc import Iterator, Mapping
from typing import Any

from procedures.errors import RequestError

MOST_TRIALS = 10_000_000
LEAST_TRIALS = 1_000
NEGLIGIBLE = 1e-3
"""Of the combined uncertainty: a source that puts less than this into every parameter is told as negligible."""


def check_trials(trials: int, *, is_possible: bool) -> None:
    """Raises: RequestError for a number of Monte Carlo trials that says nothing, or that would not end."""
    if trials != 0 and not LEAST_TRIALS <= trials <= MOST_TRIALS:
        raise RequestError(
            f"--monte-carlo: got {trials} trials, allowed {LEAST_TRIALS} to {MOST_TRIALS} (or 0: none); a million "
            "settles two digits"
        )
    if trials != 0 and not is_possible:
        raise RequestError("--monte-carlo: checks the budget of attitude and rate models: not of linear and --joint")


def findings_lines(axis: Mapping[str, Any]) -> Iterator[str]:
    """Of one axis of a document; nothing where the document holds no findings (a stored set)."""
    if "extension" in axis:
        yield _extension(axis["extension"])
    yield from (f"advice: {sentence}" for sentence in axis.get("advice", {}).get("sentences", ()))
    if "residual_curvature" in axis:
        yield _curvature(axis["residual_curvature"])
    if "budget" in axis:
        yield from _budget(axis["budget"])


def _extension(found: Mapping[str, Any]) -> str:
    verdict = "accepted" if found["is_accepted"] else "not needed"
    against = "above" if found["is_accepted"] else "against"
    return (
        f"extended model {verdict}: F = {found['f']:.3g} {against} {found['f_95']:.3g}; standard error "
        f"{found['standard_error_before_v']:.3g} V without and {found['standard_error_after_v']:.3g} V with it"
    )


def _curvature(found: Mapping[str, Any]) -> str:
    ratios = found["standard_uncertainty_ratio"]
    if not any(any(row) for row in found["h_e"]):
        return "H_E is zero: the model is linear in its primary parameters"
    if any(ratio is None for ratio in ratios.values()):
        return "with H_E the answer is no minimum: look for wrong rows"
    changes = ", ".join(f"{name} × {ratio:.4f}" for name, ratio in ratios.items())
    return f"H_E would change the standard uncertainties: {changes}"


def _budget(budget: Mapping[str, Any]) -> Iterator[str]:
    from procedures.cli.coefficients_text import label_and_unit

    combined, expanded = budget["combined_standard_uncertainty"], budget["expanded_uncertainty_95"]
    if len(budget["lines"]) > 1:
        yield "budget (standard uncertainty that each source puts into):"
        headings = [label_and_unit(name) for name in combined]
        yield f"  {'source':<50} {'ν':>5}  " + "  ".join(f"{' '.join(parts):>18}" for parts in headings)
        for line in budget["lines"]:
            yield _budget_line(line, combined)
        yield f"  {'combined':<50} {'':>5}  " + "  ".join(_cell(combined[name]) for name in combined)
        yield f"  {'expanded, 95 %':<50} {'':>5}  " + "  ".join(_cell(expanded[name]) for name in combined)
    if "monte_carlo" in budget:
        check = budget["monte_carlo"]
        missed = [label_and_unit(name)[0] for name, found in check["parameters"].items() if not found["is_confirmed"]]
        verdict = (
            f"differs for {', '.join(missed)}: use its intervals" if missed else "confirms the budget to one digit"
        )
        yield f"Monte Carlo, {check['trials']} trials, seed {check['seed']}: {verdict}"


def _budget_line(line: Mapping[str, Any], combined: Mapping[str, float]) -> str:
    dof = line["degrees_of_freedom"]
    values = line["standard_uncertainty"]
    cells = "  ".join(_cell(values[name], combined[name]) for name in combined)
    return f"  {line['type']} {line['source']:<48} {'∞' if dof is None else f'{dof:.0f}':>5}  {cells}"


def _cell(value: float | None, combined: float | None = None) -> str:
    small = value is None or (combined is not None and value < NEGLIGIBLE * combined)
    return f"{'·' if small else f'{value:.2g}':>18}"
