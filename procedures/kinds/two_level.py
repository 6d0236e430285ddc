"""``two-level``: magnetometers along and against a known field, first without it, then with it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ams.arrays import FloatArray
from ams.frames import ANGLES
from procedures.description.kind_tables import Levels
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Forecast, Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.plan.plan import Plan
from procedures.plan.points import Point
from procedures.plan.rotations import body_axis, to_stage
from procedures.plan.steps import Applied, Rest
from procedures.solution.by_model import observed
from procedures.solution.expected_points import Solver, by_lines
from procedures.solution.levels import levels_of
from procedures.solution.lines import solve_lines
from procedures.solution.request import SensorRows, SolvedSensor
from rig.abilities.targets import broken_rules
from rig.description.rig_file import RigDescription, Sensor
from rig.toml_file import StrictTable

ALONG = 0.999
"""Cosine of the angle within which an axis stands along a field."""


class TwoLevel(PointKind):
    """Each axis of each sensor in both senses."""

    name = "two-level"
    table: tuple[str, type[StrictTable]] | None = ("levels", Levels)
    models: tuple[str, ...] = ("linear",)

    def measures(self, model: str) -> tuple[str, ...]:
        return ("field",)

    def points(self, request: PlanRequest) -> Sequence[Point]:
        rig, procedure, sensors = request.rig, request.procedure, request.sensors
        levels = procedure.table_of(Levels)
        assert levels is not None
        known = ", ".join(rig.field) or "none"
        name = levels.coil or (next(iter(rig.field)) if len(rig.field) == 1 else None)
        if name is None or name not in rig.field:
            raise procedure.error(("levels", "coil"), f"got {levels.coil!r}, the rig has the fields: {known}")
        coil = name
        settings = rig.field[coil]
        for field_ut in levels.applied_ut:
            if not settings.limits_ut[0] <= field_ut <= settings.limits_ut[1]:
                raise procedure.error(
                    ("levels", "applied_ut"),
                    f"got {field_ut:g} µT, allowed {settings.limits_ut[0]:g} to {settings.limits_ut[1]:g} µT "
                    f"(field.{coil}.limits_ut)",
                )
        attitudes = _attitudes_along(rig, procedure, sensors, np.array(settings.direction))
        rest = Rest(levels.rest_s)
        fields = (0.0, *levels.applied_ut)
        return [(attitude, rest, Applied(coil, field_ut)) for field_ut in fields for attitude in attitudes]

    def key_of_angle(self, axis: str) -> Key:
        return ("levels",)

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        forecast = super().forecast(rig, procedure, plan)
        levels = levels_of(plan)
        if levels is None or levels.method != "magnet-difference":
            return forecast
        sentence = (
            "the magnet's field is taken from the sensor itself: this tells symmetry and offset, no absolute scale"
        )
        return replace(forecast, advice=(*forecast.advice, sentence))

    def forecast_solver(self, plan: Plan) -> Solver:
        return by_lines

    def solve(self, item: SensorRows) -> SolvedSensor:
        return solve_lines(item, observed(item))


def _attitudes_along(
    rig: RigDescription, procedure: ProcedureDescription, sensors: Mapping[str, Sensor], direction: FloatArray
) -> list[dict[str, float]]:
    """Return two attitudes for every axis of every sensor: along the field and against it, each the least turned."""
    unit = direction / np.linalg.norm(direction)
    reachable = [[angle for angle in (0.0, 90.0, -90.0, 180.0, -180.0) if _can_go(rig, name, angle)] for name in ANGLES]
    attitudes = sorted(product(*reachable), key=lambda angles: (sum(map(abs, angles)), angles))
    chosen: list[dict[str, float]] = []
    for serial, sensor in sensors.items():
        for axis, sense in product(sensor.channels, (1.0, -1.0)):
            found = next(
                (attitude for attitude in attitudes if _component(sensor, str(axis), attitude, unit) * sense > ALONG),
                None,
            )
            if found is None:
                raise procedure.error(
                    ("levels",),
                    f"{serial}.{axis} cannot be laid {'along' if sense > 0.0 else 'against'} the field by attitudes of "
                    "90° within the limits of the axes; turn the coil, or widen limits_deg",
                )
            attitude = {name: angle for name, angle in zip(ANGLES, found, strict=True) if name in rig.axes}
            if attitude not in chosen:
                chosen.append(attitude)
    return chosen


def _component(sensor: Sensor, axis: str, attitude_deg: tuple[float, ...], level: FloatArray) -> float:
    """Return the component of a level vector along a body axis of the package."""
    return float(body_axis(sensor, axis) @ to_stage(*np.deg2rad(attitude_deg)) @ level)


def _can_go(rig: RigDescription, axis: str, angle_deg: float) -> bool:
    """Tell whether an axis reaches an angle; one that the rig does not have stands at 0."""
    settings = rig.axes.get(axis)
    if settings is None:
        return angle_deg == 0.0
    table_deg = settings.table_deg(angle_deg)
    return not any(
        broken_rules(
            angle_deg,
            table_deg,
            settings.limits_deg,
            settings.increment_deg,
            settings.approach_deg,
            settings.miswritten(),
        )
    )


KIND = TwoLevel()
