"""The content of ``calrig check``: what would be done, how long and how well, told before anything moves."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.check.evaluation import judge_design
from procedures.check.expected import ExpectedAxis, expected_uncertainties
from procedures.description.procedure_file import ProcedureDescription
from procedures.plan.order import travel_deg
from procedures.plan.plan import Plan
from procedures.plan.planner import make_plan
from procedures.plan.refusals import basis, model_parameters
from rig.description.rig_file import RigDescription

LEAST_REPLICATIONS = 6
"""TP, recommendation 6."""
CALIBRATION_OVER_USAGE = 1.5
"""TP, recommendation 1."""
BYTES_PER_SAMPLE, BYTES_PER_DWELL = 8, 4096
"""Of the journal: float64 samples, and the rest of a dwell with its events; the sum is told with half as much again."""


@dataclass(frozen=True)
class AxisUse:
    """What a plan asks of one axis, degrees."""

    limits_deg: tuple[float, float]
    reached_deg: tuple[float, float]
    travel_deg: float


@dataclass(frozen=True)
class CheckReport:
    """Everything that can be said beforehand."""

    rig: str
    plan: Plan
    axes: Mapping[str, AxisUse]
    parameters: tuple[str, ...]
    rank: int
    degrees_of_freedom: int
    figure_of_merit_sqrt: float
    usage_figure_of_merit_sqrt: float | None
    time_correlation: float
    """The largest correlation, without sign, of time within a replication with a term of the model."""
    expected: tuple[ExpectedAxis, ...]
    journal_bytes: int
    advice: tuple[str, ...]


def check(rig: RigDescription, procedure: ProcedureDescription, fresh_seed: int | None = None) -> CheckReport:
    """Plan and judge. Raises: PlanError for everything that the planner refuses."""
    plan = make_plan(rig, procedure, fresh_seed)
    judged = judge_design(plan.design, plan.usage_pitch_deg)
    parameters = model_parameters(procedure)
    columns = basis(plan.solve.model, plan.design.points)
    return CheckReport(
        rig=rig.rig.name,
        plan=plan,
        axes={axis: _use(rig, plan, axis) for axis in plan.axes},
        parameters=parameters,
        rank=int(np.linalg.matrix_rank(columns)) + len(parameters) - columns.shape[1],
        degrees_of_freedom=len(plan.design_dwells) - len(parameters),
        figure_of_merit_sqrt=judged.figures.figure_of_merit_sqrt,
        usage_figure_of_merit_sqrt=judged.figures.usage_figure_of_merit_sqrt,
        time_correlation=time_correlation(plan),
        expected=expected_uncertainties(rig, procedure, plan),
        journal_bytes=_journal_bytes(plan),
        advice=tuple(_advice(plan)),
    )


def time_correlation(plan: Plan) -> float:
    """Of time in the first replication with the terms of the model: near 1, a drift passes for a parameter."""
    by_label = {point.label: point for point in plan.design.points}
    points = [by_label[dwell.point] for dwell in plan.design_dwells if dwell.replication == 1]
    terms = basis(plan.solve.model, points)[:, 1:]
    time = np.arange(len(points)) - (len(points) - 1) / 2.0
    varying = terms - terms.mean(axis=0)
    with_time = np.abs(time @ varying) / (np.linalg.norm(time) * np.maximum(np.linalg.norm(varying, axis=0), 1e-12))
    return float(with_time.max())


def to_document(report: CheckReport) -> dict[str, Any]:
    """The form of ``calrig check --json``."""
    plan = report.plan
    return {
        "rig": report.rig,
        "title": plan.title,
        "kind": plan.kind,
        "plan_sha256": plan.sha256,
        "design": plan.design.kind,
        "points": len(plan.design.points),
        "order": plan.order,
        "seed": plan.seed,
        "replications": plan.replications,
        "dwells_planned": len(plan.dwells),
        "design_dwells": len(plan.design_dwells),
        "axes": {name: _axis_document(use) for name, use in report.axes.items()},
        "duration_s": {"p50": plan.expected.p50_s, "p90": plan.expected.p90_s},
        "parameters": list(report.parameters),
        "rank": report.rank,
        "degrees_of_freedom": report.degrees_of_freedom,
        "figure_of_merit_sqrt": report.figure_of_merit_sqrt,
        "usage_figure_of_merit_sqrt": report.usage_figure_of_merit_sqrt,
        "time_correlation": report.time_correlation,
        "expected_standard_uncertainty": _expected_document(report.expected),
        "journal_bytes": report.journal_bytes,
        "advice": list(report.advice),
    }


def _axis_document(use: AxisUse) -> dict[str, Any]:
    return {
        "limits_deg": list(use.limits_deg),
        "reached_deg": list(use.reached_deg),
        "travel_deg": use.travel_deg,
    }


def _expected_document(expected: tuple[ExpectedAxis, ...]) -> dict[str, Any]:
    document: dict[str, Any] = {}
    for axis in expected:
        document.setdefault(axis.sensor, {})[axis.axis] = {
            "noise_v": axis.noise_v,
            "noise_source": axis.noise_source,
            "parameters": dict(axis.standard_uncertainty),
        }
    return document


def _use(rig: RigDescription, plan: Plan, axis: str) -> AxisUse:
    angles = [dwell.targets_deg[axis] for dwell in plan.dwells]
    return AxisUse(rig.axes[axis].limits_deg, (min(angles), max(angles)), travel_deg([[angle] for angle in angles])[0])


def _journal_bytes(plan: Plan) -> int:
    samples = BYTES_PER_SAMPLE * plan.dwell.samples * len(plan.channels)
    return int(1.5 * len(plan.dwells) * (samples + BYTES_PER_DWELL))


def _advice(plan: Plan) -> Iterator[str]:
    """Where TP's recommendations are not followed."""
    if plan.replications < LEAST_REPLICATIONS:
        yield (
            f"{plan.replications} replication{'s' if plan.replications > 1 else ''}: drift and lack of fit want "
            f"{LEAST_REPLICATIONS} or more (TP recommendation 6)"
        )
    if plan.kind == "tumble":
        yield "a tumble test is not recommended for laboratory calibration (TP recommendation 7)"
        return
    if plan.design.has_roll and max(plan.design.roll_values_deg) - min(plan.design.roll_values_deg) < 270.0:
        yield "roll should cover the full circle (TP recommendation 2)"
    yield from _advice_on_usage(plan)


def _advice_on_usage(plan: Plan) -> Iterator[str]:
    if plan.usage_pitch_deg is None:
        return
    low, high = min(plan.design.pitch_values_deg), max(plan.design.pitch_values_deg)
    if not low <= plan.usage_pitch_deg[0] < plan.usage_pitch_deg[1] <= high:
        yield (
            f"the usage range {plan.usage_pitch_deg[0]:g}° to {plan.usage_pitch_deg[1]:g}° reaches beyond the "
            f"calibration, {low:g}° to {high:g}°: nothing is validated there"
        )
    elif high - low < CALIBRATION_OVER_USAGE * (plan.usage_pitch_deg[1] - plan.usage_pitch_deg[0]) - 1e-9:
        yield "the calibration range should be 150 % of the usage range (TP recommendation 1)"
