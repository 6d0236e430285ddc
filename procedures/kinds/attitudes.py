"""The schedule of a kind that is a design of attitudes."""

from procedures.kinds.kind import PlanRequest, Schedule
from procedures.plan.attitudes import environment_of, make_design, plateaus_of, seed_of, steps_at_attitudes
from procedures.plan.order import visits

OF_ATTITUDES = ("pitch-roll", "pitch-only", "pitch-yaw-roll", "linear")
"""calrig's own models that attitudes at rest determine."""


def schedule_of_attitudes(request: PlanRequest) -> Schedule:
    """Return the design in the order asked for, at every plateau. Raises: PlanError for a design that cannot be."""
    procedure = request.procedure
    design = visits(make_design(procedure), procedure.design.order)
    environment = environment_of(request.rig, procedure)
    seed = seed_of(procedure, request.fresh_seed)
    return Schedule(
        design=design,
        steps=tuple(steps_at_attitudes(procedure, design, request.axes, environment, seed)),
        replications=procedure.procedure.replications * len(plateaus_of(environment)),
        order=procedure.design.order,
        seed=seed,
        usage_pitch_deg=procedure.design.usage_pitch_deg,
        environment=environment,
        reference=procedure.check,
    )
