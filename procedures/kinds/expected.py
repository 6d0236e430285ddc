"""What to expect of one sensor axis before anything is measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ExpectedAxis:
    """One axis and the uncertainty that a plan should reach."""

    sensor: str
    axis: str
    noise_v: float
    """Standard deviation of a dwell's mean."""
    noise_source: str
    """Where the figure comes from."""
    coning_deg: float
    standard_uncertainty: Mapping[str, float | None]
    """Parameter to standard uncertainty in its own unit; None where it will not be determined."""
    half_width_95: Mapping[str, float | None] = field(default_factory=dict)
    """Parameter to the half-width of its 95 % interval; empty where it is not told."""
