"""How long a design takes in every order, with every setting of the readings and any number of sensors on the table.

The way depends on the order alone and what is read on nothing but the setting and the channels: both are asked of
:mod:`procedures.plan.estimate` once, and added.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ams.models.registry import model_named
from procedures.description.procedure_file import Order, ProcedureDescription
from procedures.plan.adaptive import Reading
from procedures.plan.attitudes import make_design, steps_at_attitudes
from procedures.plan.channels import channels_of
from procedures.plan.designs import Design
from procedures.plan.drift_bias import time_correlation
from procedures.plan.estimate import NOTHING_LEARNED, expected_duration
from procedures.plan.learned_times import LearnedTimes
from procedures.plan.order import visits
from procedures.plan.steps import Dwell, Step
from rig.description.rig_file import RigDescription, Sensor

SHORT_NPLC = 1.0
"""Tried beside the readouts' own integration, with the most readings."""


@dataclass(frozen=True)
class Timed:
    """How long a run takes."""

    first_s: float
    """Everything up to the end of the first replication."""
    further_s: float
    """Each replication after it."""

    def hours(self, replications: int) -> float:
        """Return the duration of a run of so many replications."""
        return (self.first_s + (replications - 1) * self.further_s) / 3600.0


@dataclass(frozen=True)
class Ordered:
    """A design in one order, two replications of it, on a rig."""

    rig: RigDescription
    procedure: ProcedureDescription
    sensors: Mapping[str, Sensor]
    order: Order
    once: Design
    """The design with one point for every attitude."""
    axes: tuple[str, ...]
    learned: LearnedTimes = NOTHING_LEARNED

    @cached_property
    def design(self) -> Design:
        """Return the design with a point of its own for every visit of an attitude."""
        return visits(self.once, self.order)

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        table = self.procedure.design.model_copy(update={"order": self.order})
        reordered = self.procedure.model_copy(update={"design": table})
        return tuple(steps_at_attitudes(reordered, self.design, self.axes, None, table.seed))

    @cached_property
    def time_correlation(self) -> float:
        """Return the largest correlation of time with a term of the model, in the first replication."""
        by_label = {point.label: point for point in self.design.points}
        points = [by_label[step.point] for step in _design_dwells(self.steps) if step.replication == 1]
        sensor = next(iter(self.sensors.values()))
        axis = str(next(iter(sensor.channels)))
        model = model_named(self.procedure.solve.model, axis)
        return time_correlation(model, points, sensor.nominal_v_per_g(axis) or 1.0)

    def timed(self, reading: Reading, sensors: int) -> Timed:
        """Return the durations with the first so many sensors on the table."""
        more_s = self._dwell_s(reading, sensors) - self._dwell_s(self._plain_reading, len(self.sensors))
        first, every = self._dwells
        first_s, every_s = self._plain_s
        first_s, every_s = first_s + first * more_s, every_s + every * more_s
        return Timed(first_s, every_s - first_s)

    @property
    def _plain_reading(self) -> Reading:
        return Reading(self.procedure.dwell.samples, None)

    @cached_property
    def _first(self) -> tuple[Step, ...]:
        return tuple(step for step in self.steps if not isinstance(step, Dwell) or step.replication < 2)

    @cached_property
    def _dwells(self) -> tuple[int, int]:
        first, every = (sum(isinstance(step, Dwell) for step in steps) for steps in (self._first, self.steps))
        return first, every

    @cached_property
    def _plain_s(self) -> tuple[float, float]:
        channels = channels_of(self.rig, self.sensors)
        plain = self._plain_reading.dwell(self.procedure.dwell)
        first, every = (
            expected_duration(self.rig, steps, plain, channels, self.learned).p50_s
            for steps in (self._first, self.steps)
        )
        return first, every

    def _dwell_s(self, reading: Reading, sensors: int) -> float:
        """Return how long one dwell takes, no way to it counted."""
        some = dict(list(self.sensors.items())[:sensors])
        first_dwell = [step for step in self.steps if isinstance(step, Dwell)][:1]
        dwell = reading.dwell(self.procedure.dwell)
        return expected_duration(self.rig, first_dwell, dwell, channels_of(self.rig, some), self.learned).p50_s


def _design_dwells(steps: Sequence[Step]) -> Iterator[Dwell]:
    return (step for step in steps if isinstance(step, Dwell) and step.purpose == "design")


def in_orders(
    rig: RigDescription,
    procedure: ProcedureDescription,
    sensors: Mapping[str, Sensor],
    orders: Sequence[Order],
    learned: LearnedTimes = NOTHING_LEARNED,
) -> list[Ordered]:
    """Return the design of a procedure in every order. Raises: PlanError where it cannot be made."""
    once = make_design(procedure)
    axes = tuple(name for name in ("pitch", "yaw", "roll") if name in rig.axes)
    return [Ordered(rig, procedure, sensors, order, once, axes, learned) for order in orders]


def readings_of(rig: RigDescription, sensors: Mapping[str, Sensor], samples: Sequence[int]) -> list[Reading]:
    """Return readings a dwell and their integration; a short one where every readout has a longer one of its own."""
    nplc = readout_nplc(rig, sensors)
    short = [Reading(samples[-1], SHORT_NPLC)] if nplc is not None and nplc > SHORT_NPLC else []
    return [*(Reading(number, None) for number in samples), *short]


def readout_nplc(rig: RigDescription, sensors: Mapping[str, Sensor]) -> float | None:
    """Return the integration of the readouts, power-line cycles, where all have the same."""
    names = {channel.partition(".")[0] for channel in channels_of(rig, sensors)}
    found = {getattr(rig.readouts[name], "nplc", None) if name in rig.readouts else None for name in names}
    (nplc,) = found if len(found) == 1 else (None,)
    return float(nplc) if isinstance(nplc, int | float) else None
