"""A plan as a pandas table: a row for every step, before anything moves."""

from collections.abc import Mapping

import pandas as pd

from procedures.plan.plan import Plan
from procedures.plan.steps import Dwell, Follow, Rest, Soak, Step, Turn


def steps_table(plan: Plan) -> pd.DataFrame:
    """Return the steps by their place in the plan; what a step has not is empty."""
    rows = [_row(plan, step) for step in plan.steps]
    table = pd.DataFrame(rows, index=pd.Index([step.step for step in plan.steps], name="step"))
    return table.astype({"replication": "Int64", "point": "Int64"})


def _row(plan: Plan, step: Step) -> Mapping[str, object]:
    if isinstance(step, Soak):
        return (
            {"what": "soak", "purpose": "", "replication": None, "point": None}
            | {f"{axis}_deg": float("nan") for axis in plan.axes}
            | {"temperature_degc": step.setpoint_degc, "field_ut": float("nan"), "seconds": step.soak_s}
        )
    return {
        "what": _what(step),
        "purpose": step.purpose,
        "replication": step.replication,
        "point": step.point,
        **{f"{axis}_deg": step.targets_deg.get(axis, float("nan")) for axis in plan.axes},
        "temperature_degc": float("nan"),
        "field_ut": float("nan") if step.applied is None else step.applied.field_ut,
        "seconds": _seconds(step),
    }


def _what(dwell: Dwell) -> str:
    match dwell.motion:
        case None:
            return "dwell"
        case Turn():
            return f"turn {dwell.motion.turned_axis} at {dwell.motion.rate_dps:+g} °/s"
        case Follow():
            return dwell.motion.shape
        case Rest():
            return "rest"


def _seconds(dwell: Dwell) -> float:
    match dwell.motion:
        case None:
            return float("nan")
        case Turn() | Follow():
            return dwell.motion.seconds
        case Rest():
            return dwell.motion.rest_seconds
