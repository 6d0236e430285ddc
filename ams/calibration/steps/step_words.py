"""Between which dwells a change was, and how the dwells in doubt are measured again, in words."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.steps.step_scan import Change, Course
from ams.analysis.diagnostics.take_back import ways_back_of
from ams.arrays import BoolArray
from ams.findings import Finding, Said
from ams.observations import Observations
from ams.rounding import significant
from ams.units import signed

OFFSET_LIMIT: Final = "largest_offset_shift_v"
SENSITIVITY_LIMIT: Final = "largest_sensitivity_shift"
_LIMIT_OF: Final = {"own_offset": OFFSET_LIMIT, "own_sensitivity": SENSITIVITY_LIMIT}
_UNCERTAINTY: Final = "_standard_uncertainty"
"""How numbers are called in what the diagnosis of two visits tells of a lone sensor."""


@dataclass(frozen=True)
class Step:
    """A step of the offset of a sensor, in the unit of its output, or of its sensitivity, as a part of it."""

    key: str
    """Of the limit of such a step in the rig file."""
    size: float
    standard_uncertainty: float
    limit: float
    """Declared; 0 where none is."""

    @property
    def is_within(self) -> bool:
        """Whether a step of the size of the limit may be estimated so: 98 of 100 are."""
        return self.limit > 0.0 and abs(self.size) <= self.limit + 2.0 * self.standard_uncertainty


def step_of(finding: Finding, axis: str, limits: Mapping[str, float]) -> Step | None:
    """Return the step of the offset or the sensitivity of an axis that a finding tells; None where it tells another."""
    changes = [name for name in finding.details if _is_of_output(name)]
    if finding.kind != "sensor-change" or len(changes) != 1 or not changes[0].endswith(f"_{axis}"):
        return None
    key = next((key for part, key in _LIMIT_OF.items() if changes[0].startswith(part)), None)
    if key is None:
        return None
    size, u = finding.details[changes[0]], finding.details[f"{changes[0]}{_UNCERTAINTY}"]
    return Step(key, float(size or 0.0), float(u or 0.0), limits.get(key, 0.0))


def _is_of_output(name: str) -> bool:
    return name.startswith("own_") and not name.endswith(_UNCERTAINTY)


def when(change: Change, course: Course, rows: Observations) -> str:
    """Return between which dwells it changed, or from which to which it was changed."""
    order = course.time_order
    if change.end is None:
        before, first = (dwell_words(rows, int(row)) for row in order[change.index - 1 : change.index + 1])
        return f"between {before} and {first}"
    first, last = (dwell_words(rows, int(order[index])) for index in (change.index, change.end - 1))
    return f"from {first} to {last}, and back"


def what_changed(change: Change, course: Course, rows: Observations) -> str:
    """Return what stepped or turned, and when."""
    what = f"a turn about {change.what}" if change.is_of_table else f"a step of the {change.what}"
    return f"{what} {when(change, course, rows)}"


def doubted_steps(change: Change, course: Course, rows: Observations) -> tuple[int, ...]:
    """Return the steps of the run that are in it; none where the rows have no steps."""
    return () if rows.step is None else tuple(sorted(int(step) for step in rows.step[course.during(change)]))


def doubt(change: Change, course: Course, rows: Observations) -> Said:
    """Return how many dwells are in it, and what can be done: either side can be measured again.

    No command solves a part of a run, and which side stands as it should is not known here.
    """
    changed = course.during(change)
    where, which, others = (
        ("since", "of one side", "before") if change.end is None else ("in between", "outside", "outside")
    )
    fact = f"{int(changed.sum())} of {changed.size} dwells were measured {where}"
    if rows.step is None:
        return Said(fact, f"measure them again, or solve those {which}")
    as_others = ", with the table as it stood for the other" if change.is_of_table else ""
    sides = [*_side(changed, where, rows), *_side(~changed, others, rows)]
    return Said(fact, f"measure one side again{as_others}: {', or '.join(sides)}" if sides else "measure all again")


def with_size(finding: Finding, step: Step, unit: str) -> Finding:
    """Return what is said of a step with its size and the declared limit; within it, no mixture is to be mended."""
    if step.key == SENSITIVITY_LIMIT:
        factor, name = 1e6, "ppm"
    else:
        factor, name = (1e6, "µV") if unit == "v" else (1.0, unit)
    size = f"by {signed(factor * step.size, 3)} ± {significant(2.0 * factor * step.standard_uncertainty)} {name}"
    limit = f"the declared {step.key} of {significant(factor * step.limit, 4)} {name}"
    if step.is_within:
        return as_held(finding, f"{size}, within {limit}")
    beyond = f", beyond {limit}" if step.limit > 0.0 else ""
    return replace(finding.adding(f"{size}{beyond}"), is_held=False)


def as_held(finding: Finding, within: str) -> Finding:
    """Return a change that the stated uncertainties hold: nothing is measured again."""
    held = finding.adding(f"{within}, which the stated uncertainties hold")
    return replace(held, is_held=True, what_to_do="")


def as_stated(finding: Finding) -> Finding:
    """Return a change as it is stated: where nothing holds it, the result is a mixture."""
    return finding if finding.is_held else finding.adding("the result is a mixture of both")


def _side(which: BoolArray, where: str, rows: Observations) -> Iterator[str]:
    """Yield how the dwells of one side are measured again; nothing where that takes back every dwell of the run."""
    for way in ways_back_of(which, rows)[:1]:
        if way.dwells < rows.rows:
            yield f"the {int(which.sum())} {where} ({way.text})"
