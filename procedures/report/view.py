"""One run as one plain value: what every screen draws and nothing a screen must work out for itself.

Made from the journal by :mod:`procedures.report.assemble`; the page, the terminal summary and the figures only read it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from ams.analysis.diagnostics.low_order import PPM
from ams.archive.histories import SensorHistory
from ams.archive.sign_offs import SignOff
from ams.arrays import FloatArray, IntArray
from ams.calibration_result import AxisCalibration, SensorVerdict
from ams.findings import Finding
from ams.frames import wrap_deg
from ams.gravity import Gravity
from ams.observations import Observations
from ams.rounding import two_digits
from ams.sets.stated_verdict import unsigned_status
from ams.surveillance.adjustment import Adjustment
from ams.units import ARCSEC_PER_RAD, small_unit
from procedures.journal.audit.audit_trail import Interruption, Note
from procedures.kinds.section import SensorPage
from procedures.plan.order import attitudes_in_words
from procedures.solution.budget_view import BudgetView

Trust = Literal["sound", "reserved", "unusable"]


@dataclass(frozen=True)
class ParameterRow:
    """One parameter as it is printed: its unit stands in ``unit`` and holds for every number of the row."""

    name: str
    """As in the coefficient set, such as ``offset_v``."""
    label: str
    symbol: str
    unit: str
    value: float | None
    standard_uncertainty: float | None
    degrees_of_freedom: float | None
    """Effective, of the standard uncertainty."""
    coverage_factor: float | None
    """k of the 95 % interval, from Student's t at these degrees of freedom."""
    expanded_uncertainty: float | None
    interval_95: tuple[float, float] | None
    tp_standard_uncertainty: float | None
    in_other_terms: str
    """The expanded uncertainty as an angle or in parts per million."""
    truth: float | None
    """What the twin's sensor really is; None at the bench."""

    @property
    def holds_truth(self) -> bool | None:
        """Whether the 95 % interval holds the truth; None where there is no truth or no interval."""
        if self.truth is None or self.interval_95 is None:
            return None
        return self.interval_95[0] <= self.truth <= self.interval_95[1]

    @property
    def misses_truth_by(self) -> float:
        """How far the value is from a truth that its interval does not hold, in expanded uncertainties; else 0."""
        if self.holds_truth is not False or self.truth is None or self.value is None or not self.expanded_uncertainty:
            return 0.0
        away = self.value - self.truth
        return abs(wrap_deg(away) if self.unit == "°" else away) / self.expanded_uncertainty


@dataclass(frozen=True)
class TestRow:
    """One test of the replication analysis with its conclusion in plain words."""

    __test__ = False
    subject: str
    parameter: str
    """The parameter it is about; empty for the lack of fit."""
    t: float
    f_95: float
    p_value: float
    dof: tuple[float, float]
    is_significant: bool
    """Among all tests of the run (Holm, each axis with its share)."""
    size: str
    """How large the effect is, as an angle or in parts per million."""
    conclusion: str
    tp_t: float
    """The same test as TP 8 has it, and its limit."""
    tp_f_95: float
    is_explained: bool = False
    """Whether it is plain against precision alone, and the table or what else is known explains it."""


@dataclass(frozen=True)
class AxisView:
    """One sensor axis: its solution and what is said about it."""

    axis: str
    channel: str
    calibration: AxisCalibration
    sensitivity_v_per_g: float
    """Magnitude of the sensitive axis; turns volts into angles."""
    parameters: tuple[ParameterRow, ...]
    tests: tuple[TestRow, ...]
    """Empty where there was one replication."""
    remarks: tuple[str, ...]
    """Further results, a sentence each."""
    advice: tuple[str, ...] = ()
    """What repeats in the residuals and what drifts, a sentence each."""
    budget: BudgetView | None = None
    """What each source of uncertainty puts into each parameter; None where the sources are not known."""


@dataclass(frozen=True)
class AxisFindings:
    """What was tested on one axis."""

    axis: str
    channel: str
    findings: tuple[Finding, ...]
    measured_unit: str = "V"
    """Of the channel, as a person reads it."""

    def size_of(self, finding: Finding) -> str:
        """Return how large a term that is not significant came out ± twice its uncertainty; empty elsewhere."""
        size, uncertainty = finding.details.get("size"), finding.details.get("standard_uncertainty")
        if not isinstance(size, float) or not isinstance(uncertainty, float):
            return ""
        unit = str(finding.details.get("unit", ""))
        if unit == "rad":
            shown, factor = "″", ARCSEC_PER_RAD
        elif unit == PPM:
            shown, factor = PPM, 1.0
        else:
            shown, factor = small_unit(unit if unit.startswith("V") else f"{self.measured_unit} {unit}".rstrip())
        sign = shown if shown == "″" else f" {shown}"
        return f"{two_digits(factor * size)} ± {two_digits(2.0 * factor * uncertainty)}{sign}".replace("-", "−")


@dataclass(frozen=True)
class SensorView:
    """One package: what it is, what was seen, what came out."""

    name: str
    model: str
    mount: str
    is_check_sensor: bool
    observations: Observations | None
    axes: tuple[AxisView, ...]
    warnings: tuple[str, ...]
    failure: str | None
    """Why there is no solution; None where there is one."""
    number: int
    """1-based among the sensors of the run."""
    remarks: tuple[str, ...] = ()
    """What a reader should know of the solution; no reservation."""
    adjustment: Adjustment | None = None
    """As found and as left; None where there is no solution or its model tells no angles."""
    history: SensorHistory | None = None
    """Its calibrations up to this one; None where this is the first that the archive knows."""
    findings: tuple[AxisFindings, ...] = ()
    """Axis by axis; empty where nothing was solved."""
    verdict: SensorVerdict = "not usable"
    """Of this sensor alone; the run's own says more."""
    signed: SignOff | None = None
    """Who signed its set and accepted its findings; None where no archive knows it."""
    section: SensorPage | None = None
    """Of a sensor that is told by its readings, not by angles; it has no ``axes`` then."""

    def is_approved_by(self, approved_by: str) -> bool:
        """Return whether who approved the rig, or a signature, approves this result: as list and archive have it."""
        is_signed = self.signed is not None and self.signed.state == "approved"
        return is_signed or unsigned_status("approved" if approved_by else "engineering", self.verdict) == "approved"

    @property
    def slug(self) -> str:
        """Unique among the sensors and safe in a file name and an anchor."""
        letters = (letter.lower() if letter.isascii() and letter.isalnum() else "-" for letter in self.name)
        return f"{self.number}-{''.join(letters)}"


@dataclass(frozen=True)
class Past:
    """What the archive says of the sensors of a run, by their names."""

    adjustments: Mapping[str, Adjustment] = field(default_factory=dict)
    histories: Mapping[str, SensorHistory] = field(default_factory=dict)
    signed: Mapping[str, SignOff] = field(default_factory=dict)
    """As it is when the page is made: `calrig solve` makes it again, with what was signed since."""


@dataclass(frozen=True)
class DesignView:
    """The design points in the order of the first replication's visits."""

    kind: str
    order: str
    replications: int
    point: IntArray
    pitch_deg: FloatArray
    roll_deg: FloatArray

    @property
    def points(self) -> int:
        return int(self.point.size)

    @property
    def attitudes_in_words(self) -> str:
        """How many attitudes, and how often a replication visits each."""
        return attitudes_in_words(self.points, self.order)


@dataclass(frozen=True)
class Counts:
    """Dwells by what became of them."""

    planned: int
    accepted: int
    rejected: int
    """Or taken back."""
    rejected_and_repeated: int
    """Of these, whose step was measured again, whatever came of it."""
    design_planned: int
    design_accepted: int
    moves_made_again: int = 0


@dataclass(frozen=True)
class TemperatureTrace:
    """One environment over the run, a value a dwell."""

    name: str
    hours: FloatArray
    temperature_degc: FloatArray


@dataclass(frozen=True)
class ReferenceTrace:
    """One channel at the reference attitude, over the run."""

    label: str
    hours: FloatArray
    change: FloatArray
    """Against the first visit, in ``unit``."""
    sensitivity_v_per_g: float
    """0 where nothing turns the reading into an angle."""
    unit: str = "v"


@dataclass(frozen=True)
class CheckComparison:
    """The check set of a later epoch against that of the first, one channel."""

    epoch: int
    label: str
    attitudes: int
    mean_change: float
    """In ``unit``, as the two that follow."""
    largest_change: float
    largest_at: str
    scatter: float
    """Standard uncertainty of one change, from the samples of both dwells (root mean square over the attitudes)."""
    sensitivity_v_per_g: float
    """0 where nothing turns the reading into an angle."""
    unit: str = "v"
    is_step: bool = False
    """Whether some attitude changed beyond its limit; the verdict tells of exactly these."""
    departure: float = 0.0
    """Of the attitude that departs most from its limit: Student's t over the limit."""
    departed_by: float = 0.0
    """The change there, in ``unit``."""
    departed_at: str = ""
    cause: str = ""
    """Whose doing the change of the whole check set is, as all sensors together show it; empty: none is told."""


@dataclass(frozen=True)
class Verdict:
    """Is it trustworthy: one sentence and what stands behind it."""

    trust: Trust
    sentence: str
    grounds: tuple[str, ...]


@dataclass(frozen=True)
class RunView:
    """The whole run."""

    title: str
    run_id: str
    state: str
    operator: str
    rig: str
    gravity: Gravity
    is_simulated: bool
    approved_by: str | None
    began_utc: datetime
    """When the run was begun: homing, soaks and checks come before the first dwell."""
    started_utc: datetime
    """Of the first dwell: the time that figures count from."""
    ended_utc: datetime | None
    verdict: Verdict
    design: DesignView
    counts: Counts
    sensors: tuple[SensorView, ...]
    interruptions: tuple[Interruption, ...]
    notes: tuple[Note, ...]
    temperature: tuple[TemperatureTrace, ...]
    reference: tuple[ReferenceTrace, ...]
    checks: tuple[CheckComparison, ...]
    missing: tuple[str, ...] = ()
    """What the laboratory lacked for a calibration when the run began; of a run on twins nothing is asked."""
    of_sections: Mapping[str, object] = field(default_factory=dict)
    """Section of the page to what it brings for itself (:class:`procedures.report.section.Section`)."""

    @property
    def stamps(self) -> tuple[str, ...]:
        """What must be read before any number is."""
        return (("SIMULATED",) if self.is_simulated else ()) + (("ENGINEERING",) if self.why_engineering else ())

    @property
    def why_engineering(self) -> str:
        """Why nothing of it is a calibration as it stands; empty where it is one."""
        if not self.approved_by:
            return "Not approved."
        if self.missing:
            return "Something is missing for a calibration."
        unsigned = [sensor.name for sensor in self.sensors if not sensor.is_approved_by(self.approved_by)]
        return f"Not usable, and nobody signed for it: {', '.join(unsigned)}." if unsigned else ""
