"""``tumble``: the four or six attitudes of the tumble test, or SR's two positions of every axis, up and down."""

from ams.models.registry import takes_levels
from procedures.description.procedure_file import ProcedureDescription
from procedures.kinds.attitudes import AttitudeKind
from procedures.kinds.expected_attitudes import forecast_of_design
from procedures.kinds.expected_lines import forecast_of_points
from procedures.kinds.kind import Forecast
from procedures.kinds.section import SensorPage, section_of
from procedures.plan.plan import Plan
from procedures.solution.beliefs import Pilot
from procedures.solution.by_model import observed, solve_by_model
from procedures.solution.expected_points import by_lines, by_model
from procedures.solution.lines import solve_lines
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription

_UP_AND_DOWN = "up-down"


class Tumble(AttitudeKind):
    """Few attitudes: TP's by its models, SR's by straight lines."""

    name = "tumble"
    is_tumble = True

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        return self.forecast_after(None, rig, procedure, plan)

    def forecast_after(
        self, pilot: Pilot | None, rig: RigDescription, procedure: ProcedureDescription, plan: Plan
    ) -> Forecast:
        if _is_up_and_down(plan):
            return forecast_of_points(rig, plan, by_lines if self._is_of_lines(plan) else by_model)
        return forecast_of_design(rig, procedure, plan, [], pilot)

    def solves_lines(self, model: str, design_kind: str) -> bool:
        return takes_levels(model) and design_kind == _UP_AND_DOWN

    def solve(self, item: SensorRows) -> SolvedSensor:
        observations = observed(item)
        if self._is_of_lines(item.plan):
            return solve_lines(item, observations)
        return solve_by_model(item, observations)

    def section(self, record: RunRecord, solved: SolvedSensor) -> SensorPage | None:
        return section_of(record, solved) if _is_up_and_down(record.plan) else None

    def _is_of_lines(self, plan: Plan) -> bool:
        return self.solves_lines(plan.solve.model, plan.design.kind)


def _is_up_and_down(plan: Plan) -> bool:
    """Tell whether it is SR's: one line an axis, no angles."""
    return plan.design.kind == _UP_AND_DOWN


KIND = Tumble()
