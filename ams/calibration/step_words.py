"""Between which dwells a change was, and how the dwells in doubt are measured again, in words."""

import numpy as np

from ams.analysis.diagnostics.step_scan import Change, Course
from ams.analysis.diagnostics.wording import dwell_words
from ams.observations import Observations


def when(change: Change, course: Course, rows: Observations) -> str:
    """Return between which dwells it changed, or from which to which it was changed."""
    order = course.time_order
    if change.end is None:
        before, first = (dwell_words(rows, int(row)) for row in order[change.index - 1 : change.index + 1])
        return f"between {before} and {first}"
    first, last = (dwell_words(rows, int(order[index])) for index in (change.index, change.end - 1))
    return f"from {first} to {last}, and back"


def doubted_steps(change: Change, course: Course, rows: Observations) -> tuple[int, ...]:
    """Return the steps of the run that are in it; none where the rows have no steps."""
    return () if rows.step is None else tuple(sorted(int(step) for step in rows.step[course.during(change)]))


def doubt(change: Change, course: Course, rows: Observations) -> str:
    """Return how many dwells are in it, and what can be done about them."""
    changed = course.during(change)
    where, which = ("since", "of one side") if change.end is None else ("in between", "outside")
    return (
        f"; {int(changed.sum())} of {changed.size} dwells were measured {where}, and the result is a mixture of both: "
        f"measure them again{_command(change, course, rows)}, or solve those {which}"
    )


def _command(change: Change, course: Course, rows: Observations) -> str:
    steps = doubted_steps(change, course, rows)
    if not steps:
        return ""
    if change.end is None:
        return f" (calrig void --from {min(steps)})"
    touched = np.unique(rows.replication[course.during(change)])
    return f" ({', '.join(f'calrig redo --replication {label}' for label in touched)})"
