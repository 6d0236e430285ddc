"""Which steps of a plan are one visit to the reference, and under which plateau each stands."""

from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Soak


def visits_of(plan: Plan) -> dict[int, int]:
    """Step to the number of its visit, from 1."""
    found: dict[int, int] = {}
    number, was_reference = 0, False
    for step in plan.steps:
        is_reference = isinstance(step, Dwell) and step.purpose == "reference"
        number += is_reference and not was_reference
        if is_reference:
            found[step.step] = number
        was_reference = is_reference
    return found


def plateau_numbers_of(plan: Plan) -> dict[int, int]:
    """Step to the number of the plateau that it stands under, 0 before the first."""
    found, plateau = {}, 0
    for step in plan.steps:
        plateau = step.plateau if isinstance(step, Soak) else plateau
        found[step.step] = plateau
    return found
