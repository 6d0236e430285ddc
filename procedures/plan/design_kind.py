"""What a kind of design is: its name, its keys in ``[design]`` and how its attitudes are made from them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from procedures.description import procedure_file
from procedures.description.described_designs import DescribedDesign
from procedures.description.procedure_file import AngleSet, Range
from procedures.errors import PlanError
from procedures.plan import designs
from procedures.plan.designs import Design
from rig.registry import Registry


@dataclass(frozen=True)
class Wanted:
    """What a kind makes its attitudes from."""

    table: procedure_file.Design
    """``[design]``, or the options of ``calrig design`` as such a table; of the kind's own form where it has one."""
    with_roll: bool
    """Whether the model of the procedure knows roll."""
    folder: Path
    """What paths in the table are relative to."""

    @property
    def pitch_deg(self) -> tuple[float, ...]:
        assert self.table.pitch_deg is not None, "the kind does not say that it needs pitch_deg"
        return values_of(self.table.pitch_deg)

    @property
    def roll_deg(self) -> tuple[float, ...]:
        """With +180° at its end where ``repeat_roll`` says so; 0° where there is no roll."""
        roll = (0.0,) if self.table.roll_deg is None else values_of(self.table.roll_deg)
        return designs.with_repeated_roll(roll) if self.table.repeat_roll else roll


@dataclass(frozen=True, kw_only=True)
class DesignKind(DescribedDesign):
    """One kind of design, registered under ``calrig.designs``."""

    make: Callable[[Wanted], Design]
    """Raises: PlanError."""

    def made(self, wanted: Wanted) -> Design:
        """Return the design, at every yaw that the table names. Raises: PlanError."""
        design = self.make(wanted)
        return design if wanted.table.yaw_deg is None else designs.with_yaw(design, values_of(wanted.table.yaw_deg))


DESIGNS: Registry[DesignKind] = Registry("calrig.designs", DesignKind, PlanError)


def values_of(angles: AngleSet) -> tuple[float, ...]:
    """Return the angles of a range or a list."""
    return angles.values() if isinstance(angles, Range) else tuple(angles)
