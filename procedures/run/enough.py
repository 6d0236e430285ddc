"""The rule of ``[stop] half_width_deg`` while a run goes on: asked after each whole replication, told, journalled."""

from collections import Counter
from collections.abc import Iterable, Sequence
from operator import attrgetter

from procedures.errors import PlanError
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord
from procedures.run.context import RunContext

ENOUGH = "enough"


def is_enough_measured(context: RunContext, plan: Plan, dwells: Iterable[DwellRecord]) -> bool:
    """Return whether nothing more needs to be measured; False in the middle of a replication.

    ``plan``: of the sensors that remain. ``dwells``: with their readings where the plan is sequential. The same dwells
    give the same answer, so a resumed run ends where an uninterrupted one does.

    Raises: PlanError where nobody can judge, AmsError where the replications cannot be solved.
    """
    if plan.sequential is None:
        return False
    design = sorted((dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"), key=attrgetter("step"))
    whole = whole_replications(plan, design)
    if len(design) != whole * len(plan.design.points):
        return False
    if not plan.sequential.least_replications <= whole < plan.replications:
        return False
    services = context.services
    if services.enough is None or services.described is None:
        raise PlanError("[stop] half_width_deg: nothing here can judge it; run the procedure by calrig run")
    found = services.enough(services.described, plan, design)
    context.progress_log.event(ENOUGH, found.detail)
    context.progress_log.tell(ENOUGH, found.text)
    return found.is_enough


def whole_replications(plan: Plan, dwells: Sequence[DwellRecord]) -> int:
    """Return how many replications, from the first on, have every point of the design."""
    points = Counter(dwell.replication for dwell in dwells)
    missing = (label for label in range(1, plan.replications + 1) if points[label] < len(plan.design.points))
    return next(missing, plan.replications + 1) - 1
