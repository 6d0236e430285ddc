"""The content of ``calrig check`` for what moves, for fields and rests: what would be done, how long, how well.

The uncertainty to expect is that of ordinary least squares at the planned rates or levels, from the twin's noise where
there is a twin; at the bench nothing is guessed.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import timedelta
from math import sqrt
from typing import Any

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from ams.arrays import FloatArray
from procedures.description.procedure_file import ProcedureDescription
from procedures.plan.plan import Plan
from procedures.plan.planner import make_plan
from procedures.plan.profiles import range_deg
from procedures.plan.rotations import UP, body_axis, to_stage
from procedures.plan.steps import Dwell, Follow, Rest, Turn
from procedures.run.watch.disk_space import needed_bytes
from rig.description.rig_file import RigDescription, Sensor

AXES = ("pitch", "yaw", "roll")
FEWEST_REPLICATIONS = 4
"""Below, intervals rest on so few degrees of freedom that they are wide."""


@dataclass(frozen=True)
class MotionCheck:
    """Everything that can be said beforehand."""

    rig: str
    plan: Plan
    reached: Mapping[str, tuple[float, float]]
    """Axis to the lowest and highest angle that a dwell begins or sweeps at, degrees."""
    turns: Mapping[str, float]
    """Axis to the most revolutions of one dwell."""
    expected: Mapping[str, Mapping[str, Mapping[str, float]]]
    """Sensor, axis, parameter to the standard uncertainty from noise alone; empty where no noise is known."""
    journal_bytes: int
    advice: tuple[str, ...]


def check_motion(rig: RigDescription, procedure: ProcedureDescription) -> MotionCheck:
    """Plan and judge. Raises: PlanError for everything that the planner refuses."""
    plan = make_plan(rig, procedure)
    return MotionCheck(
        rig=rig.rig.name,
        plan=plan,
        reached={axis: _reached(plan, axis) for axis in plan.axes},
        turns=_turns(plan),
        expected={name: dict(_expected(rig, plan, name, sensor)) for name, sensor in plan.sensors.items()},
        journal_bytes=int(needed_bytes(plan, len(plan.dwells))),
        advice=(*_advice(plan), *_unguarded(rig, plan)),
    )


def to_document(report: MotionCheck) -> dict[str, Any]:
    """The form of ``calrig check --json``."""
    plan = report.plan
    return {
        "rig": report.rig,
        "title": plan.title,
        "kind": plan.kind,
        "plan_sha256": plan.sha256,
        "points": len(plan.design.points),
        "replications": plan.replications,
        "dwells_planned": len(plan.dwells),
        "design_dwells": len(plan.design_dwells),
        "steps": [_told(dwell) for dwell in plan.design_dwells if dwell.replication == 1],
        "axes": {
            axis: {"reached_deg": list(reached), "most_revolutions": report.turns.get(axis, 0.0)}
            for axis, reached in report.reached.items()
        },
        "duration_s": {"p50": plan.expected.p50_s, "p90": plan.expected.p90_s},
        "model": plan.solve.model,
        "expected_standard_uncertainty": report.expected,
        "journal_bytes": report.journal_bytes,
        "advice": list(report.advice),
    }


def render(report: MotionCheck) -> Group:
    """Everything of the report, to be printed on a rich console."""
    plan = report.plan
    facts = Table(box=None, show_header=False)
    facts.add_column(style="bold")
    facts.add_column()
    duration = (str(timedelta(seconds=round(seconds))) for seconds in (plan.expected.p50_s, plan.expected.p90_s))
    for name, told in (
        ("rig", report.rig),
        ("procedure", plan.title),
        ("kind", f"{plan.kind}, model {plan.solve.model}"),
        ("sensors", ", ".join(plan.sensors)),
        ("dwells", f"{len(plan.design_dwells)} in {plan.replications} replications"),
        ("duration", "{} (p50), {} (p90)".format(*duration)),
        ("journal", f"about {report.journal_bytes / 1e6:.1f} MB"),
    ):
        facts.add_row(name, Text(told))
    steps = Table("point", "what", box=None)
    for dwell in (dwell for dwell in plan.design_dwells if dwell.replication == 1):
        steps.add_row(str(dwell.point), Text(_told(dwell)))
    expected = Table("sensor", "parameter", "u (noise alone)", box=None)
    for name, axes in report.expected.items():
        for axis, values in axes.items():
            for parameter, value in values.items():
                expected.add_row(Text(f"{name} {axis}"), parameter, f"{value:.2g}")
    further = (expected, "") if expected.row_count else ()
    advice = [Text(f"! {line}", style="yellow") for line in report.advice]
    return Group(facts, "", steps, "", *further, *advice)


def _told(dwell: Dwell) -> str:
    """One dwell in words."""
    parts = [f"{name} {angle:g}°" for name, angle in dwell.targets_deg.items() if angle]
    at = f"at {', '.join(parts)}" if parts else "level"
    applied = "" if dwell.applied is None else f", {dwell.applied.coil} {dwell.applied.field_ut:g} µT"
    match dwell.motion:
        case Turn(sweep_deg=None):
            turn = dwell.motion
            return (
                f"{turn.turned_axis} at {turn.rate_dps:+g} °/s, {turn.revolutions} revolutions in {turn.seconds:.4g} s"
            )
        case Turn():
            turn = dwell.motion
            return f"{turn.turned_axis} at {turn.rate_dps:+g} °/s, {turn.sweeps} sweeps, read for {turn.seconds:.4g} s"
        case Follow():
            axes = ", ".join(f"{name} {span:g}°" for name, span in dwell.motion.span_deg.items())
            return f"{dwell.motion.shape} motion of {axes} for {dwell.motion.seconds:g} s"
        case Rest():
            return f"at rest {at}{applied} for {dwell.motion.rest_seconds:g} s"
    return f"{at}{applied}"


def _reached(plan: Plan, axis: str) -> tuple[float, float]:
    angles = [dwell.targets_deg[axis] for dwell in plan.dwells]
    for dwell in plan.dwells:
        motion = dwell.motion
        if isinstance(motion, Turn) and motion.turned_axis == axis and motion.sweep_deg is not None:
            angles += motion.sweep_deg
        if isinstance(motion, Follow) and axis in motion.span_deg:
            angles += range_deg(motion, axis)
    return min(angles), max(angles)


def _turns(plan: Plan) -> dict[str, float]:
    turns: dict[str, float] = {}
    for dwell in plan.dwells:
        if isinstance(dwell.motion, Turn) and dwell.motion.sweep_deg is None:
            axis = dwell.motion.turned_axis
            turns[axis] = max(turns.get(axis, 0.0), float(dwell.motion.revolutions))
    return turns


def _led_by_a_rate(dwell: Dwell) -> Iterable[str]:
    """Axes whose last command is a rate while the dwell lasts."""
    match dwell.motion:
        case Turn(sweep_deg=None):
            return (dwell.motion.turned_axis,)
        case Follow():
            return dwell.motion.span_deg
    return ()


def _unguarded(rig: RigDescription, plan: Plan) -> Iterator[str]:
    """Axes that turn on and on and that nothing stops when the computer dies; a sweep ends at its target."""
    turned = {name for dwell in plan.dwells for name in _led_by_a_rate(dwell)}
    for name in plan.axes:
        if name in turned and getattr(rig.axes[name], "watchdog_s", None) is None:
            yield (
                f"axes.{name} has no watchdog_s: if this computer dies while it turns, it turns on; keep the machine's "
                "stop button within reach"
            )


def _advice(plan: Plan) -> Iterator[str]:
    if plan.replications < FEWEST_REPLICATIONS and plan.static is None:
        yield (
            f"{plan.replications} replication{'s' if plan.replications > 1 else ''}: intervals rest on few degrees of "
            f"freedom; {FEWEST_REPLICATIONS} or more make them much narrower"
        )
    if plan.static is not None and plan.static.duration_s < 4.0 * plan.static.use_s:
        yield (
            f"a rest of {plan.static.duration_s:g} s says little about a use of {plan.static.use_s:g} s: the verdict "
            "rests on a handful of neighbouring means; rest for ten times as long"
        )
    if plan.levels is not None and plan.levels.method == "magnet-difference":
        yield "the magnet's field is taken from the sensor itself: this tells symmetry and offset, no absolute scale"


def _expected(rig: RigDescription, plan: Plan, name: str, sensor: Sensor) -> Iterator[tuple[str, dict[str, float]]]:
    """Of every axis whose noise the twin knows and whose rows can be told beforehand."""
    truths = {} if rig.twin is None else {str(axis): truth for axis, truth in rig.twin.truth.get(name, {}).items()}
    if plan.kind in ("profile", "static") or plan.solve.model not in ("gyro", "linear"):
        return
    rates = np.array([_rates_dps(dwell) for dwell in plan.design_dwells])
    for axis in map(str, sensor.channels):
        truth = truths.get(axis)
        if truth is None or truth.noise == 0.0:
            continue
        columns: list[FloatArray] = [np.ones(len(plan.design_dwells))]
        names: tuple[str, ...]
        if plan.solve.model == "gyro":
            columns += [rates[:, place] for place in range(3)]
            names = ("offset_v", "k_x_v_per_dps", "k_y_v_per_dps", "k_z_v_per_dps")
        else:
            columns.append(_levels(rig, plan, sensor, axis, rates))
            names = ("reading at zero", "reading per unit")
        noise = np.array([truth.noise / sqrt(_samples(rig, plan, dwell, sensor, axis)) for dwell in plan.design_dwells])
        scaled = np.stack(columns, axis=-1) / noise[:, None]
        covariance = np.linalg.pinv(scaled.T @ scaled)
        yield axis, {key: sqrt(float(value)) for key, value in zip(names, np.diag(covariance), strict=True)}


def _rates_dps(dwell: Dwell) -> tuple[float, float, float]:
    """Angular velocity in package axes: one axis turns by itself, the others stand at 0."""
    about = {"roll": 0, "pitch": 1, "yaw": 2}
    rates = [0.0, 0.0, 0.0]
    if isinstance(dwell.motion, Turn):
        rates[about[dwell.motion.turned_axis]] = dwell.motion.rate_dps
    return rates[0], rates[1], rates[2]


def _levels(rig: RigDescription, plan: Plan, sensor: Sensor, axis: str, rates: FloatArray) -> FloatArray:
    along = body_axis(sensor, axis)
    if sensor.measures == "rate":
        return np.asarray(rates @ along)
    levels = []
    for dwell in plan.design_dwells:
        angles = [np.deg2rad(dwell.targets_deg.get(name, 0.0)) for name in AXES]
        if sensor.measures == "acceleration":
            levels.append(float(along @ to_stage(*angles) @ UP))
            continue
        assert plan.levels is not None
        assert dwell.applied is not None
        coil = np.array(rig.field[dwell.applied.coil].direction)
        beside = np.array(plan.levels.surroundings_ut or (0.0, 0.0, 0.0))
        level = beside + dwell.applied.field_ut * coil / np.linalg.norm(coil)
        levels.append(float(along @ to_stage(*angles) @ level))
    return np.array(levels)


def _samples(rig: RigDescription, plan: Plan, dwell: Dwell, sensor: Sensor, axis: str) -> float:
    """How many readings of one channel a dwell takes."""
    name = {str(key): channel for key, channel in sensor.channels.items()}[axis].partition(".")[0]
    if name in rig.readouts:
        return float(plan.dwell.samples)
    seconds = dwell.motion.seconds if isinstance(dwell.motion, Turn) else _rest_s(dwell.motion)
    return max(seconds * rig.streams[name].samples_hz(), 1.0)


def _rest_s(motion: object) -> float:
    return motion.rest_seconds if isinstance(motion, Rest) else 0.0
