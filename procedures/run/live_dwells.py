"""What an epoch is doing, in the words of ``live.json``."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from procedures.journal.sidecar.live import Figure, LiveFile, Target
from procedures.numbers import finite
from procedures.plan.learned_times import PartTime
from procedures.plan.plan import Plan
from procedures.plan.step_times import MOVE, SETTLE, reading_name, step_parts
from procedures.plan.steps import Dwell, Soak, Step
from procedures.records.dwells import Measurement
from procedures.run.context import RunContext
from rig.description.rig_file import RigDescription


@dataclass(frozen=True, slots=True)
class LiveDwells:
    """The epoch's side of the file: one method for each thing that it does."""

    live: LiveFile
    parts: Mapping[str, PartTime] = field(default_factory=dict)
    """How long each part of a step is expected to take, in rig seconds."""
    factor: float = 1.0
    """Rig seconds in a second of the person who looks."""
    moves_s: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    """Step to how long the way to it usually and seldom takes, in the order of the plan, in rig seconds."""

    @classmethod
    def of(cls, context: RunContext) -> "LiveDwells":
        """Return the file of a run with what its plan expects."""
        plan, rig = context.plan, context.services.described
        moves_s = {} if rig is None else usual_moves_s(rig, plan)
        return cls(context.live, plan.expected.parts, context.rig.clock.factor, moves_s)

    def phase(self, phase: str, dwell: Dwell | None = None) -> None:
        """Tell a phase of a dwell, and how long it usually and seldom takes."""
        name = SETTLE if phase == "settling" else "" if dwell is None else reading_name(dwell)
        part = self.parts.get(name)
        if part is None:
            self.live.tell(phase)
        else:
            self.live.tell(phase, usual_s=part.each_p50_s / self.factor, seldom_over_s=part.each_p90_s / self.factor)

    def homes(self, axis: str) -> None:
        self.live.tell("homing", now=None, next=None, waiting_for=f"{axis} to find its home")

    def warms_up(self, channel: str) -> None:
        self.live.tell("warming up", waiting_for=f"{channel} to come to rest")

    def moves(self, dwell: Dwell, left: Iterable[Step]) -> None:
        """``left``: what comes after the dwell."""
        following = next((step for step in left if isinstance(step, Dwell)), None)
        taken = dict(zip(("usual_s", "seldom_over_s"), self.moves_s.get(dwell.step, ()), strict=False))
        expected = {name: seconds / self.factor for name, seconds in taken.items()}
        target = None if following is None else _target(following)
        self.live.tell("moving", now=_target(dwell), next=target, **expected)

    def rests_at(self, positions_deg: Mapping[str, float]) -> None:
        self.live.tell(positions_deg=dict(positions_deg))

    def saw(self, measured: Measurement) -> None:
        readings = {
            channel: Figure(finite(reading.mean), reading.unit) for channel, reading in measured.readings.items()
        }
        self.live.tell(readings=readings, temperature_degc=dict(measured.after.temperature_degc))

    def soaks(self, step: Soak) -> Callable[[float, float], None]:
        """Return what hears the temperature and the seconds left."""
        setpoint_degc = {step.environment: step.setpoint_degc}
        self.live.tell(
            "soaking", now=None, next=None, setpoint_degc=setpoint_degc, soak_left_s=step.soak_s / self.factor
        )

        def tell(degc: float, left_s: float) -> None:
            self.live.tell(temperature_degc={step.environment: degc}, soak_left_s=left_s / self.factor)

        return tell


def usual_moves_s(rig: RigDescription, plan: Plan) -> dict[int, tuple[float, float]]:
    """Return, by step, how long the way to it usually and seldom takes; none for a step whose axes stand there."""
    found: dict[int, tuple[float, float]] = {}
    for part in step_parts(rig, plan.steps, plan.dwell, plan.channels):
        each = plan.expected.parts.get(part.name)
        if part.step is not None and part.name.startswith(MOVE) and each is not None:
            usual_s, seldom_s = found.get(part.step, (0.0, 0.0))
            found[part.step] = usual_s + each.each_p50_s, seldom_s + each.each_p90_s
    return found


def _target(dwell: Dwell) -> Target:
    return Target(dwell.step, dwell.purpose, dwell.replication, dict(dwell.targets_deg))
