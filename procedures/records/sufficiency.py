"""Whether a run has measured enough, as it is told after a replication."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Sufficiency:
    """What the rule of ``[stop] half_width_deg`` says after so many replications."""

    replications: int
    is_enough: bool
    text: str
    half_width_deg: Mapping[str, float]
    """Sensor to U95 of its worst angle, as the precision so far lets it be foreseen."""

    @property
    def detail(self) -> dict[str, object]:
        """As it is journalled."""
        return {
            "replications": self.replications,
            "enough": self.is_enough,
            "text": self.text,
            "half_width_deg": dict(self.half_width_deg),
        }
