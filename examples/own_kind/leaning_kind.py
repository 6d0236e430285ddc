"""A kind of run of your own: a rest a little before, at and behind one pitch, again and again (docs/files.md).

For a sensor that is only ever used near one attitude: its offset and its slope there, and nothing else of it. Its first
replications may be for warming up: they are measured, and left out of the solution.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

from pydantic import Field

from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.kind import Key, PlanRequest
from procedures.kinds.points import PointKind
from procedures.plan.points import Point
from procedures.plan.steps import Rest
from procedures.solution.by_model import observed
from procedures.solution.lines import solve_lines
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.device_settings import Positive
from rig.toml_file import StrictTable


class Lean(StrictTable):
    """``[lean]``: the pitch, how far beside it, how long each rest lasts, and how many replications warm up."""

    pitch_deg: float
    by_deg: Positive
    rest_s: Positive = 10.0
    warming_up: Annotated[int, Field(ge=0)] = 0


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

    def disagreements(self, procedure: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
        yield from super().disagreements(procedure)
        lean = procedure.table_of(Lean)
        if lean is not None and lean.warming_up >= procedure.replications:
            yield (
                ("lean", "warming_up"),
                f"got {lean.warming_up}: nothing is left to solve of {procedure.replications} replications; give less",
            )

    def solve(self, item: SensorRows) -> SolvedSensor:
        """Solve by the table that the run was planned with: the plan keeps it, the file may have changed since."""
        lean = item.plan.kind_table("lean", Lean)
        assert lean is not None, "a plan of this kind has its table"
        warm = replace(item, dwells=tuple(dwell for dwell in item.dwells if dwell.replication > lean.warming_up))
        return solve_lines(warm, observed(warm))


LEANING = Leaning()
