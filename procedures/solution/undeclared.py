"""What nobody declared of a rig: remarks of a result, and findings beside the tests of its data."""

from collections.abc import Mapping
from dataclasses import dataclass

from ams.findings import Finding, FindingKind


@dataclass(frozen=True)
class Undeclared:
    """Sentences, of each kind those that are to be said."""

    level: tuple[str, ...] = ()
    """Of the base, where attitudes are counted from it."""
    meter: tuple[str, ...] = ()
    rates: tuple[str, ...] = ()
    """Of a standard of them."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.level, *self.meter, *self.rates)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Each as a finding that no test made."""
        kinds: Mapping[FindingKind, tuple[str, ...]] = {
            "level-undeclared": self.level,
            "meter-undeclared": self.meter,
            "rate-undeclared": self.rates,
        }
        return tuple(Finding(kind, text, is_significant=False) for kind, texts in kinds.items() for text in texts)
