"""What a kind of run is: one object of these members, one file, one entry point ``calrig.kinds``.

Everything that all kinds share (reading the file, refusing what cannot be reached, estimating, judging, solving by
model or by lines, budgets, check, report) asks the kind for its own part and knows none of them by name.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from ams.frames import ANGLES
from procedures.description.procedure_file import CheckPlan, EnvironmentPlan, Order, ProcedureDescription
from procedures.errors import PlanError
from procedures.kinds.expected import ExpectedAxis
from procedures.kinds.recommendations import Recommendation
from procedures.kinds.section import SensorPage
from procedures.plan.designs import Design
from procedures.plan.plan import Plan
from procedures.plan.steps import Step
from procedures.solution.beliefs import Pilot
from procedures.solution.expected import ExpectedAngle
from procedures.solution.record import RunRecord
from procedures.solution.request import SensorRows, SolvedSensor
from rig.description.rig_file import RigDescription, Sensor
from rig.toml_file import StrictTable

Key = Sequence[object]


@dataclass(frozen=True)
class PlanRequest:
    """What a plan is made of."""

    rig: RigDescription
    procedure: ProcedureDescription
    sensors: Mapping[str, Sensor]
    channels: tuple[str, ...]
    fresh_seed: int | None = None
    """For the order ``random``; None: drawn."""

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes of the rig from outside in: the order in which they move."""
        return tuple(name for name in ANGLES if name in self.rig.axes)


@dataclass(frozen=True)
class Schedule:
    """Which attitudes, in which steps."""

    design: Design
    steps: tuple[Step, ...]
    replications: int
    order: Order = "raster"
    seed: int | None = None
    usage_pitch_deg: tuple[float, float] | None = None
    environment: EnvironmentPlan | None = None
    reference: CheckPlan | None = None
    most_samples: int = 0


@dataclass(frozen=True)
class DesignFigures:
    """A design of attitudes judged beforehand: what it can determine and how well."""

    parameters: tuple[str, ...]
    rank: int
    degrees_of_freedom: int
    figure_of_merit_sqrt: float
    usage_figure_of_merit_sqrt: float | None
    time_correlation: float
    """The largest correlation, without sign, of time within a replication with a term of the model."""
    drift_bias: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Order to primary parameter to its bias by a drift of one volt over a replication."""
    roll_errors_alike_every_deg: float | None = None
    """Errors of the roll axis with this period pass for a turn of the package; None: rolls lie in no even steps."""


@dataclass(frozen=True)
class Forecast:
    """What a kind can say of its plan before anything moves."""

    expected: tuple[ExpectedAxis, ...] = ()
    advice: tuple[str, ...] = ()
    design: DesignFigures | None = None
    """None where the points are no design over attitudes."""
    turns: Mapping[str, float] = field(default_factory=dict)
    """Axis to the most revolutions of one dwell."""
    angles: Mapping[str, Mapping[str, ExpectedAngle]] = field(default_factory=dict)
    """Sensor to the angles that it will tell at use."""
    usage_pitch_deg: tuple[float, float] | None = None
    """The pitch range that the angles are judged over."""
    reservations: tuple[str, ...] = ()
    """What the report will hold against the result, however well the run goes."""
    remarks: tuple[str, ...] = ()
    """What the report will say beside the result and not hold against it, in the same words."""
    judged_by: str = ""
    """Key of the procedure file that its sensors are held to; empty: the limits of the rig file, as calibrations."""
    recommendations: tuple[Recommendation, ...] = ()
    """TP's ten, where the kind is one that they are about."""


@runtime_checkable
class Kind(Protocol):
    """One kind of run."""

    @property
    def name(self) -> str:
        """As ``procedure.kind`` has it."""

    @property
    def table(self) -> tuple[str, type[StrictTable]] | None:
        """Name and form of its own table in ``procedure.toml``; None where ``[design]`` says everything."""

    @property
    def models(self) -> tuple[str, ...]:
        """Models that it is solved with, as ``solve.model`` has them."""

    def disagreements(self, procedure: ProcedureDescription) -> Iterator[tuple[tuple[str, ...], str]]:
        """Tell the tables of its file that do not go together: key and what is wrong."""

    def measures(self, model: str) -> tuple[str, ...]:
        """Return what the sensors that it calibrates measure."""

    def key_of_angle(self, axis: str) -> Key:
        """Return the key of the file that asks for the attitudes of an axis."""

    def schedule(self, request: PlanRequest) -> Schedule:
        """Lay out its steps. Raises: PlanError for what leaves nothing to lay out."""

    def refusals(self, request: PlanRequest, schedule: Schedule) -> Iterator[PlanError]:
        """Tell what of the schedule this rig cannot do or the design cannot determine, beyond what every kind tells."""

    def forecast(self, rig: RigDescription, procedure: ProcedureDescription, plan: Plan) -> Forecast:
        """Judge the plan beforehand."""

    def solves_lines(self, model: str, design_kind: str) -> bool:
        """Tell whether each axis is a straight line of known levels to it, not a sensor by its attitudes or rates."""

    def solve(self, item: SensorRows) -> SolvedSensor:
        """Solve one sensor from its dwells. Raises: AmsError or JournalError where it cannot be solved."""

    def section(self, record: RunRecord, solved: SolvedSensor) -> SensorPage | None:
        """Return what the report says of one sensor; None where it is told as angles of attitude."""


@runtime_checkable
class LearnsFromPilot(Protocol):
    """A kind whose forecast takes what a run before has shown."""

    def forecast_after(
        self, pilot: Pilot | None, rig: RigDescription, procedure: ProcedureDescription, plan: Plan
    ) -> Forecast:
        """Judge the plan beforehand, by a pilot where there is one."""
