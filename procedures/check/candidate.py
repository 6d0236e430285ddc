"""A calibration that could be made, what is asked of it, and what it is compared with: values of `calrig plan`."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ams.parameter_words import words_of
from ams.units import small_unit
from procedures.description.procedure_file import Order
from procedures.plan.drift_bias import TIME_CONFOUNDED
from procedures.plan.learned_times import LearnedTimes
from procedures.solution.beliefs import Pilot
from procedures.solution.expected import Usage
from rig.description.rig_file import RigDescription

STEEPEST_DEG = 90.0
"""The most that a calibration is planned over, to both sides."""


@dataclass(frozen=True)
class SearchRange:
    """What is tried."""

    grids: tuple[tuple[int, int], ...] = (
        (4, 6),
        (5, 6),
        (7, 6),
        (7, 8),
        (9, 8),
        (9, 12),
        (13, 8),
        (13, 12),
        (19, 12),
        (37, 12),
    )
    """Pitch and roll values."""
    fractions: tuple[tuple[int, int, int], ...] = ((19, 12, 3), (37, 12, 3))
    """Pitch values, roll values, and how much of the interior is left out."""
    optimal: tuple[tuple[int, int, int], ...] = ((19, 12, 72),)
    """Pitch and roll values of a lattice, and how many of its points are taken (I-optimal)."""
    replications: tuple[int, ...] = (3, 4, 6, 10, 15)
    samples: tuple[int, ...] = (5, 10, 20)
    """Readings a dwell, rising; fewer tell their own scatter too badly for a dwell to be judged by it.

    The last is what readings at use are like where nothing is said.
    """
    orders: tuple[Order, ...] = ("there-and-back", "serpentine", "forward-reverse", "neighbours", "seeded")


@dataclass(frozen=True)
class Target:
    """What is asked for: one of the three."""

    half_width_deg: float | None = None
    """U95 of the worst angle of the worst sensor."""
    parameter: tuple[str, float] | None = None
    """Name and 95 % half-width, in its unit, of the worst axis."""
    hours: float | None = None
    """The most that all sensors of the rig may take (p50)."""


def half_in_words(parameter: str, half_width: float) -> str:
    """Tell a half-width of a parameter in the unit that it is readable in."""
    unit, factor = small_unit(words_of(parameter).unit)
    return f"{half_width * factor:.3g} {unit}".rstrip()


@dataclass(frozen=True)
class SearchRequest:
    """What is to be planned."""

    rig: RigDescription
    target: Target
    usage: Usage
    pilot: Pilot | None = None
    space: SearchRange = SearchRange()
    learned: LearnedTimes = field(default_factory=LearnedTimes)
    """How long the parts of a run took on this rig."""


@dataclass(frozen=True)
class Candidate:
    """One calibration that could be made."""

    design: Mapping[str, object]
    """The table ``[design]`` of its procedure."""
    points: int
    replications: int
    samples: int
    nplc: float | None
    """Of the readings; None: the readouts' own."""
    order: Order
    sensors: int
    """On the table at once."""
    hours: float
    """Until all sensors of the rig are calibrated (p50)."""
    run_hours: float
    """Of one run."""
    time_correlation: float
    """Of time with a term of the model, inside a replication: near 1 a drift passes for a parameter."""
    half_width_deg: float
    """U95 of the worst angle of the worst sensor."""
    calibration_deg: float
    """What of it the calibration leaves, readings at use apart."""
    shares_deg: Mapping[str, float]
    """Source to what it takes of U95 of that angle; squares add up."""
    parameters: Mapping[str, float]
    """Parameter to the half-width of its 95 % interval, of the worst axis."""
    sees_lack_of_fit_arcsec: float
    """From which size on the test finds it in half of the runs."""
    sees_drift_arcsec: float
    """Of the offset, between replications, likewise."""
    blind_to: tuple[str, ...]
    """Terms of the sensor that its points do not determine."""

    @property
    def is_confounded(self) -> bool:
        """Return whether the report would hold the order against the result."""
        return self.time_correlation > TIME_CONFOUNDED

    def value(self, target: Target) -> float:
        """Return what the target is about: an angle, or the parameter that it names."""
        return self.half_width_deg if target.parameter is None else self.parameters[target.parameter[0]]


@dataclass(frozen=True)
class Comparison:
    """All candidates, the quickest first, and which is chosen."""

    request: SearchRequest
    candidates: tuple[Candidate, ...]
    chosen: int
    sensors: int
    front: tuple[int, ...] = field(default=())
    """Those that no other beats in hours and in what the target is about."""
