"""A kind of run of your own: a rest a little before, at and behind one pitch, again and again (docs/files.md).

For a sensor that is only ever used near one attitude: its offset and its slope there, and nothing else of it.
"""

from collections.abc import Sequence

from procedures.kinds.kind import Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.plan.points import Point
from procedures.plan.steps import Rest
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.device_settings import Positive
from rig.toml_file import StrictTable


class Lean(StrictTable):
    """``[lean]``: the pitch, how far beside it, and how long each rest lasts."""

    pitch_deg: float
    by_deg: Positive
    rest_s: Positive = 10.0


class Leaning(PointKind):
    """Three points a replication; what is refused of every kind is refused of these."""

    name = "leaning"
    table: tuple[str, type[StrictTable]] | None = ("lean", Lean)
    models: tuple[str, ...] = ("linear",)

    def measures(self, model: str) -> tuple[str, ...]:
        return ("acceleration",)

    def key_of_angle(self, axis: str) -> Key:
        return "lean", f"{axis}_deg"

    def points(self, request: PlanRequest) -> Sequence[Point]:
        lean = request.procedure.table_of(Lean)
        assert lean is not None
        pitches_deg = (lean.pitch_deg - lean.by_deg, lean.pitch_deg, lean.pitch_deg + lean.by_deg)
        return [({"pitch": pitch_deg}, Rest(lean.rest_s), None) for pitch_deg in pitches_deg]

    def solve(self, item: SensorRows) -> SolvedSensor:
        return solve_by_model(item, observed(item))


LEANING = Leaning()
