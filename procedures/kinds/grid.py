"""``grid``: packages of accelerometers at the attitudes of a design, on a table or a gimbal."""

from collections.abc import Iterator

from ams.models.registry import own_models_at_rest
from procedures.description.design_kinds import DESIGNS
from procedures.description.procedure_file import ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.attitudes import OF_ATTITUDES, schedule_of_attitudes
from procedures.kinds.expected_attitudes import advice_on_ranges, forecast_of_design
from procedures.kinds.kind import Forecast, Key, PlanRequest, Schedule
from procedures.kinds.section import Section
from procedures.plan.plan import Plan
from procedures.plan.refusals import design_refusals
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription
from rig.toml_file import StrictTable


class Grid:
    """A design of attitudes, visited in replications."""

    name = "grid"
    table: tuple[str, type[StrictTable]] | None = None

    @property
    def models(self) -> tuple[str, ...]:
        return (*OF_ATTITUDES, *own_models_at_rest())

    def disagreements(self, procedure: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
        if DESIGNS[procedure.design.kind].is_tumble:
            yield ("design", "kind"), 'kind = "tumble" goes with a design of kind "T", and only with it (or "up-down")'

    def measures(self, model: str) -> tuple[str, ...]:
        return ("acceleration",)

    def key_of_angle(self, axis: str) -> Key:
        return "design", f"{axis}_deg"

    def schedule(self, request: PlanRequest) -> Schedule:
        return schedule_of_attitudes(request)

    def refusals(self, request: PlanRequest, schedule: Schedule) -> Iterator[PlanError]:
        yield from design_refusals(request.rig, request.procedure, request.sensors, schedule.design)

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        return forecast_of_design(rig, procedure, plan, advice_on_ranges(plan))

    def solve(self, item: SensorRows) -> SolvedSensor:
        return solve_by_model(item, observed(item))

    def section(self, record: RunRecord, solved: SolvedSensor) -> Section | None:
        return None
