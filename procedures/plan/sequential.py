"""Whether a run may end when it has measured enough, and what "enough" is about."""

from collections.abc import Iterator

from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.plan.designs import Design
from procedures.plan.plan import Plan, SequentialStop

RULE = (
    "the rule looks at the precision inside the replications and at the lack of fit, not at the spread between "
    "replications that the intervals are made from: they keep their coverage"
)
CALIBRATION_OVER_USAGE = 1.5
"""TP, recommendation 1."""


def usage_pitch_deg(procedure: ProcedureDescription, design: Design) -> tuple[float, float]:
    """Return the pitch range of later use: as stated, else two thirds of the calibrated one."""
    if procedure.design.usage_pitch_deg is not None:
        return procedure.design.usage_pitch_deg
    low, high = min(design.pitch_values_deg), max(design.pitch_values_deg)
    middle, half = 0.5 * (low + high), 0.5 * (high - low) / CALIBRATION_OVER_USAGE
    return middle - half, middle + half


def sequential_of(procedure: ProcedureDescription, design: Design, *, is_at_rest: bool) -> SequentialStop | None:
    """Return the rule of ``[stop]``; None where every replication is measured."""
    stop = procedure.stop
    if stop is None or stop.half_width_deg is None or stop.least_replications is None or not is_at_rest:
        return None
    usage = usage_pitch_deg(procedure, design)
    return SequentialStop(stop.half_width_deg, stop.least_replications, usage, procedure.design.usage_noise_arcsec)


def sequential_refusals(procedure: ProcedureDescription, *, is_at_rest: bool) -> Iterator[PlanError]:
    """Tell what the rule cannot go with."""
    stop = procedure.stop
    if stop is None or stop.half_width_deg is None:
        return
    key = ("stop", "half_width_deg")
    if not is_at_rest:
        yield procedure.error(key, f"angles are told by grids and tumbles, not by kind {procedure.procedure.kind!r}")
    if procedure.environment is not None and len(procedure.environment.plateaus_degc) > 1:
        yield procedure.error(
            key, "replications are counted at one temperature; give one plateau, or leave the rule out"
        )
    if "replications" in procedure.procedure.model_fields_set:
        yield procedure.error(
            ("procedure", "replications"),
            "[stop] most_replications says how many there are at most; leave this one out",
        )


def stopped_in_words(plan: Plan, replications: int) -> str | None:
    """Tell of a run that ended by the rule, or could have; None without a rule."""
    rule = plan.sequential
    if rule is None:
        return None
    low, high = rule.usage_pitch_deg
    return (
        f"sequential: {replications} of at most {plan.replications} replications, measured until U95 of every angle "
        f"over pitch {low:g}° to {high:g}° is {rule.half_width_deg:g}° ([stop]); {RULE}"
    )
