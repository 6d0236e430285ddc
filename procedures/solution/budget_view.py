"""The uncertainty budget of an axis as every page prints it: sources, what they combine to, and with which factor."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ams.analysis.calibration_budget import AxisBudget
from ams.models.rate_terms import LOW_ORDER_NAMES
from ams.parameter_words import words_of
from ams.rounding import two_digits
from ams.statistics.budget import NEGLIGIBLE
from ams.statistics.intervals import degrees_of_freedom
from ams.units import small_unit

COMBINED = "combined"
FORMS = (
    "Standard uncertainty that each source alone would leave in each parameter; a dot where it is below a thousandth "
    "of the combined one. The combined one has effective degrees of freedom (Welch-Satterthwaite), and times the "
    "coverage factor k of Student’s t it is the expanded uncertainty. Type A: from the scatter of this calibration. "
    "Type B: as certificates and readings state it (GUM 4.3)."
)


@dataclass(frozen=True)
class BudgetRow:
    """One source of uncertainty, or what all combine to."""

    source: str
    type: str
    """``A``, ``B``, or empty for the sums."""
    degrees_of_freedom: float | None
    cells: tuple[str, ...]
    """Standard uncertainty put into each parameter, as printed; a dot where it is negligible."""
    stated: str


@dataclass(frozen=True)
class BudgetView:
    """The uncertainty budget of one axis."""

    headings: tuple[tuple[str, str], ...]
    """Label and unit of each parameter."""
    rows: tuple[BudgetRow, ...]


def budget_view(budget: AxisBudget) -> BudgetView:
    """Return the budget as it is printed: sources, what they combine to, and the expanded uncertainty.

    The terms of second and third order have theirs among the parameters: a page has no room for twelve columns.
    """
    names = [name for name in budget.combined if name not in LOW_ORDER_NAMES]

    def cells(values: Mapping[str, float]) -> tuple[str, ...]:
        return tuple(
            "·"
            if values[name] < NEGLIGIBLE * budget.combined[name]
            else two_digits(small_unit(words_of(name).unit)[1] * values[name])
            for name in names
        )

    def of_all(source: str, values: Mapping[str, float], printed: Callable[[float], str]) -> BudgetRow:
        return BudgetRow(source, "", None, tuple(printed(values[name]) for name in names), "")

    sources = [
        BudgetRow(line.source, line.type, line.degrees_of_freedom, cells(line.contributions), line.stated)
        for line in budget.lines
    ]
    sums = (
        BudgetRow(COMBINED, "", None, cells(budget.combined), ""),
        of_all("effective degrees of freedom", budget.effective_degrees_of_freedom, degrees_of_freedom),
        of_all("coverage factor k", budget.coverage_factor_95, "{:.2f}".format),
        BudgetRow("expanded (95 %)", "", None, cells(budget.expanded_95), ""),
    )
    headings = tuple((words_of(name).label, small_unit(words_of(name).unit)[0]) for name in names)
    return BudgetView(headings, (*sources, *sums))
