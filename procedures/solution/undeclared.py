"""What nobody declared of a rig: remarks of a result, and findings beside the tests of its data."""

from collections.abc import Mapping
from dataclasses import dataclass

from ams.finding_kinds import FindingKind
from ams.findings import Finding, Said


@dataclass(frozen=True)
class Undeclared:
    """Of each kind what is to be said, and where it is declared."""

    level: tuple[Said, ...] = ()
    """Of the base, where attitudes are counted from it."""
    meter: tuple[Said, ...] = ()
    rates: tuple[Said, ...] = ()
    """Of a standard of them."""
    gravity: tuple[Said, ...] = ()
    """Of its uncertainty, where sensitivities are per local g."""
    table: tuple[Said, ...] = ()
    """Of the indices of its axes, where attitudes are told by them."""

    directions: tuple[Said, ...] = ()
    """Of its axes, where gyros turned about them."""
    crosstalk: tuple[Said, ...] = ()
    """Of the scanner before the meter."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """All of them as sentences."""
        every = (*self.level, *self.table, *self.meter, *self.crosstalk, *self.rates, *self.directions, *self.gravity)
        return tuple(said.text for said in every)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Each as a finding that no test made."""
        kinds: Mapping[FindingKind, tuple[Said, ...]] = {
            "level-undeclared": self.level,
            "table-undeclared": (*self.table, *self.directions),
            "meter-undeclared": (*self.meter, *self.crosstalk),
            "rate-undeclared": self.rates,
            "gravity-undeclared": self.gravity,
        }
        return tuple(
            Finding(kind, said.fact, is_significant=False, what_to_do=said.what_to_do)
            for kind, every in kinds.items()
            for said in every
        )
