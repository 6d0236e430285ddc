"""The content of ``calrig check``: what would be done, how long and how well, told before anything moves."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from procedures.check.foiled import foiled
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Forecast, LearnsFromPilot
from procedures.kinds.planner import make_plan
from procedures.kinds.registry import KINDS
from procedures.plan.adaptive import longest_readings
from procedures.plan.estimate import NOTHING_LEARNED, expected_duration
from procedures.plan.learned_times import LearnedTimes
from procedures.plan.order import travel_deg
from procedures.plan.plan import Expectation, Plan
from procedures.plan.profiles import range_deg
from procedures.plan.steps import Dwell, Follow, Rest, Turn
from procedures.run.watch.disk_space import needed_bytes
from procedures.solution.beliefs import Pilot
from rig.description.rig_file import RigDescription


@dataclass(frozen=True)
class AxisUse:
    """What a plan asks of one axis, degrees."""

    limits_deg: tuple[float, float]
    reached_deg: tuple[float, float]
    """Lowest and highest angle that a dwell begins, sweeps or follows at."""
    travel_deg: float
    """On the ways between dwells."""
    most_revolutions: float
    """Of one dwell."""


@dataclass(frozen=True)
class CheckReport:
    """Everything that can be said beforehand."""

    rig: str
    plan: Plan
    axes: Mapping[str, AxisUse]
    forecast: Forecast
    journal_bytes: int
    longest: Expectation | None = None
    """The duration where every adaptive dwell goes to its limits; None where ``[dwell]`` says how many readings."""
    earliest: Expectation | None = None
    """How long the run takes where ``[stop]`` ends it after the least replications; None without such a rule."""

    @property
    def advice(self) -> tuple[str, ...]:
        return self.forecast.advice


def check(
    rig: RigDescription,
    procedure: ProcedureDescription,
    fresh_seed: int | None = None,
    pilot: Pilot | None = None,
    learned: LearnedTimes = NOTHING_LEARNED,
    past: Pilot | None = None,
) -> CheckReport:
    """Plan and judge, by how long past runs of the rig took and what they showed; a pilot run that is named goes first.

    Raises: PlanError for everything that the planner refuses, and for a pilot that its kind has no use for.
    """
    plan = make_plan(rig, procedure, fresh_seed, learned)
    kind = KINDS[plan.kind]
    shown = pilot or past
    if shown is not None and isinstance(kind, LearnsFromPilot):
        forecast = kind.forecast_after(shown, rig, procedure, plan)
    elif pilot is None:
        forecast = kind.forecast(rig, procedure, plan)
    else:
        raise procedure.error(("procedure", "kind"), f"{plan.kind!r} takes nothing from a pilot run; leave it out")
    reservations = (*forecast.reservations, *foiled(rig, plan, forecast))
    return CheckReport(
        rig=rig.rig.name,
        plan=plan,
        axes={axis: _use(rig, plan, axis, forecast) for axis in plan.axes},
        forecast=replace(forecast, reservations=reservations),
        journal_bytes=int(needed_bytes(plan, len(plan.dwells))),
        longest=_longest(rig, plan, learned),
        earliest=_earliest(rig, procedure, plan, learned),
    )


def _longest(rig: RigDescription, plan: Plan, learned: LearnedTimes) -> Expectation | None:
    readings = longest_readings(rig, plan.dwell, plan.sensors)
    return expected_duration(rig, plan.steps, plan.dwell, plan.channels, learned, readings) if readings else None


def _earliest(
    rig: RigDescription, procedure: ProcedureDescription, plan: Plan, learned: LearnedTimes
) -> Expectation | None:
    """Return the duration of the plan of the least replications: homing and soaks are not shared out over them."""
    if plan.sequential is None or procedure.stop is None:
        return None
    rule = procedure.stop.model_copy(update={"most_replications": plan.sequential.least_replications})
    return make_plan(rig, procedure.model_copy(update={"stop": rule}), plan.seed, learned).expected


def to_document(report: CheckReport) -> dict[str, Any]:
    """Return the form of ``calrig check --json``: what all kinds have, then a design's figures or the steps."""
    plan = report.plan
    return {
        "rig": report.rig,
        "title": plan.title,
        "kind": plan.kind,
        "plan_sha256": plan.sha256,
        "points": len(plan.design.points),
        "order": plan.order,
        "seed": plan.seed,
        "replications": plan.replications,
        "dwells_planned": len(plan.dwells),
        "design_dwells": len(plan.design_dwells),
        "axes": {name: _axis_document(use) for name, use in report.axes.items()},
        "duration_s": _duration_document(plan.expected),
        **({} if report.longest is None else {"duration_at_most_samples_s": _duration_document(report.longest)}),
        "duration_parts_s": {
            name: {
                "count": part.count,
                "p50": part.p50_s,
                "p90": part.p90_s,
                "each_p50": part.each_p50_s,
                "each_p90": part.each_p90_s,
            }
            for name, part in plan.expected.parts.items()
        },
        "earliest_duration_s": None if report.earliest is None else _duration_document(report.earliest),
        "duration_learned_from": plan.expected.learned_from,
        "model": plan.solve.model,
        "journal_bytes": report.journal_bytes,
        "advice": list(report.advice),
        "reservations": list(report.forecast.reservations),
        "remarks": list(report.forecast.remarks),
        "recommendations": [
            {
                "number": recommendation.number,
                "text": recommendation.text,
                "reason": recommendation.reason,
                "followed": recommendation.is_followed,
            }
            for recommendation in report.forecast.recommendations
        ],
        **(_design_document(report) if report.forecast.design else _points_document(report)),
    }


def _duration_document(expected: Expectation) -> dict[str, float]:
    return {"p50": expected.p50_s, "p90": expected.p90_s}


def _axis_document(use: AxisUse) -> dict[str, Any]:
    return {
        "limits_deg": list(use.limits_deg),
        "reached_deg": list(use.reached_deg),
        "travel_deg": use.travel_deg,
        "most_revolutions": use.most_revolutions,
    }


def _design_document(report: CheckReport) -> dict[str, Any]:
    figures = report.forecast.design
    assert figures is not None
    expected: dict[str, Any] = {name: {} for name in report.plan.sensors}
    for axis in report.forecast.expected:
        expected[axis.sensor][axis.axis] = {
            "noise_v": axis.noise_v,
            "noise_source": axis.noise_source,
            "parameters": dict(axis.standard_uncertainty),
            "half_width_95": dict(axis.half_width_95),
        }
    return {
        "design": report.plan.design.kind,
        "parameters": list(figures.parameters),
        "rank": figures.rank,
        "degrees_of_freedom": figures.degrees_of_freedom,
        "figure_of_merit_sqrt": figures.figure_of_merit_sqrt,
        "usage_figure_of_merit_sqrt": figures.usage_figure_of_merit_sqrt,
        "time_correlation": figures.time_correlation,
        "drift_bias": {order: dict(bias) for order, bias in figures.drift_bias.items()},
        "roll_errors_alike_every_deg": figures.roll_errors_alike_every_deg,
        "expected_standard_uncertainty": expected,
        "usage_pitch_deg": list(report.forecast.usage_pitch_deg or ()),
        "expected_angle_half_width_deg": {
            serial: {name: angle.u95_deg for name, angle in angles.items()}
            for serial, angles in report.forecast.angles.items()
        },
        "expected_angle_shares_deg": {
            serial: {name: dict(angle.shares_deg) for name, angle in angles.items()}
            for serial, angles in report.forecast.angles.items()
        },
    }


def _points_document(report: CheckReport) -> dict[str, Any]:
    expected: dict[str, Any] = {name: {} for name in report.plan.sensors}
    for axis in report.forecast.expected:
        expected[axis.sensor][axis.axis] = dict(axis.standard_uncertainty)
    return {"steps": [words for _, words in steps_in_words(report.plan)], "expected_standard_uncertainty": expected}


def _use(rig: RigDescription, plan: Plan, axis: str, forecast: Forecast) -> AxisUse:
    angles = [dwell.targets_deg[axis] for dwell in plan.dwells]
    ways_deg = travel_deg([[angle] for angle in angles])[0]
    for dwell in plan.dwells:
        motion = dwell.motion
        if isinstance(motion, Turn) and motion.turned_axis == axis and motion.sweep_deg is not None:
            angles += motion.sweep_deg
        if isinstance(motion, Follow) and axis in motion.span_deg:
            angles += range_deg(motion, axis)
    reached_deg = (min(angles), max(angles))
    return AxisUse(rig.axes[axis].limits_deg, reached_deg, ways_deg, forecast.turns.get(axis, 0.0))


def steps_in_words(plan: Plan) -> list[tuple[int, str]]:
    """Return the points of the first replication in words, each with its label."""
    return [(dwell.point, _in_words(dwell)) for dwell in plan.design_dwells if dwell.replication == 1]


def _in_words(dwell: Dwell) -> str:
    """Describe one dwell in words."""
    parts = [f"{name} {angle:g}°" for name, angle in dwell.targets_deg.items() if angle]
    at = f"at {', '.join(parts)}" if parts else "level"
    applied = "" if dwell.applied is None else f", {dwell.applied.coil} {dwell.applied.field_ut:g} µT"
    match dwell.motion:
        case Turn(sweep_deg=None):
            turn = dwell.motion
            turns = "1 revolution" if turn.revolutions == 1 else f"{turn.revolutions} revolutions"
            return f"{turn.turned_axis} at {turn.rate_dps:+g} °/s, {turns} in {turn.seconds:.4g} s"
        case Turn():
            turn = dwell.motion
            return f"{turn.turned_axis} at {turn.rate_dps:+g} °/s, {turn.sweeps} sweeps, read for {turn.seconds:.4g} s"
        case Follow():
            axes = ", ".join(f"{name} {span:g}°" for name, span in dwell.motion.span_deg.items())
            return f"{dwell.motion.shape} motion of {axes} for {dwell.motion.seconds:g} s"
        case Rest():
            return f"at rest {at}{applied} for {dwell.motion.rest_seconds:g} s"
    return f"{at}{applied}"
