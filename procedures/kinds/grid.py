"""``grid``: packages of accelerometers at the attitudes of a design, on a table or a gimbal."""

from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.attitudes import AttitudeKind
from procedures.kinds.expected_attitudes import advice_on_usage, forecast_of_design
from procedures.kinds.kind import Forecast
from procedures.kinds.section import SensorPage
from procedures.plan.plan import Plan
from procedures.solution.beliefs import Pilot
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription


class Grid(AttitudeKind):
    """A design of attitudes, visited in replications."""

    name = "grid"

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        return self.forecast_after(None, rig, procedure, plan)

    def forecast_after(
        self, pilot: Pilot | None, rig: RigDescription, procedure: ProcedureDescription, plan: Plan
    ) -> Forecast:
        return forecast_of_design(rig, procedure, plan, advice_on_usage(plan), pilot)

    def solve(self, item: SensorRows) -> SolvedSensor:
        return solve_by_model(item, observed(item))

    def section(self, record: RunRecord, solved: SolvedSensor) -> SensorPage | None:
        return None


KIND = Grid()
