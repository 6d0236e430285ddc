"""What the kinds share that visit a list of points of their own."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence

from ams.models.registry import takes_levels
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.expected_lines import forecast_of_points
from procedures.kinds.kind import Forecast, PlanRequest, Schedule
from procedures.kinds.section import SensorPage, section_of
from procedures.plan.plan import Plan
from procedures.plan.points import Point, design_of_points, most_samples, steps_of_points
from procedures.solution.expected_points import Solver
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor
from rig.description.rig_file import RigDescription


class PointKind(ABC):
    """A kind whose own table says which points: once a replication each, after one visit to the level attitude."""

    @abstractmethod
    def points(self, request: PlanRequest) -> Sequence[Point]:
        """Return the points in their order. Raises: PlanError for one that this rig cannot do."""

    def schedule(self, request: PlanRequest) -> Schedule:
        points = self.points(request)
        replications = request.procedure.replications
        return Schedule(
            design=design_of_points(points),
            steps=tuple(steps_of_points(request.axes, points, replications)),
            replications=replications,
            most_samples=most_samples(request.rig, points),
        )

    def disagreements(self, procedure: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
        if procedure.solve.joint:
            yield (
                ("solve", "joint"),
                "joint belongs to the kinds grid and tumble, which rest at the attitudes of a [design], not to "
                f'kind = "{procedure.procedure.kind}"; remove it',
            )

    def solves_lines(self, model: str, design_kind: str) -> bool:
        return takes_levels(model)

    def refusals(self, request: PlanRequest, schedule: Schedule) -> Iterator[PlanError]:
        yield from ()

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        return forecast_of_points(rig, plan, self.forecast_solver(plan))

    def forecast_solver(self, plan: Plan) -> Solver | None:
        """Return what tells beforehand how well it will be solved; None where no row is known before it has run."""
        return None

    def section(self, record: RunRecord, solved: SolvedSensor) -> SensorPage | None:
        return section_of(record, solved)
