"""The kinds of design that are installed, and which keys of ``[design]`` each takes.

A kind is one object and one entry point ``calrig.designs`` (:class:`procedures.plan.design_kind.DesignKind`, which adds
how its attitudes are made).
"""

from dataclasses import dataclass, field

from procedures.errors import PlanError
from rig.registry import Registry
from rig.toml_file import StrictTable

SETS = frozenset({"pitch_deg", "roll_deg", "yaw_deg"})


@dataclass(frozen=True, kw_only=True)
class DescribedDesign:
    """What a procedure file needs to know of a kind of design."""

    name: str
    takes: frozenset[str] = SETS | {"repeat_roll"}
    """Of the keys that several kinds have: ``pitch_deg``, ``roll_deg``, ``yaw_deg``, ``repeat_roll``, ``fractional``,
    ``file``."""
    needs: dict[str, str] = field(default_factory=lambda: {"pitch_deg": ""})
    """Keys that it cannot do without, each with an example to show."""
    table: type[StrictTable] | None = None
    """A subclass of :class:`procedures.description.procedure_file.Design` with the keys that only this kind has."""
    is_tumble: bool = False
    """Whether it is for procedures of the kind ``tumble``, and only for them."""
    is_thinned: bool = False
    """Whether it leaves out attitudes of the lattice that its angles span."""
    is_on_command_line: bool = True
    """Whether ``calrig design --kind`` makes it."""


DESCRIBED_DESIGNS: Registry[DescribedDesign] = Registry("calrig.designs", DescribedDesign, PlanError)
