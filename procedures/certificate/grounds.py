"""What a certificate stands on, and what is missing for one: every gap is named at once, before anything is written.

Source: ISO/IEC 17025:2017, 7.8.2.1 (contents), 7.8.4.1 (calibration), 7.8.6 (conformity), 7.8.8 (amendments).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date

from ams.archive.sign_offs import SignOff
from ams.archive.signatures import how_to_close
from ams.finding_kinds import FindingKind
from ams.findings import Said
from ams.sets.canonical import Json, listed, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_findings import NO_CERTIFICATE_WITH, StatedFinding, findings_of_set
from ams.sets.stated_verdict import NOBODY_ACCEPTED, NOT_USABLE
from ams.sets.verdict_conditions import NO_COEFFICIENTS_U, NO_METER, NO_THERMOMETER, REFERENCE_NOT_MEASURED
from ams.surveillance.adjustment import Adjustment
from procedures.errors import RequestError
from procedures.records.declared_gaps import (
    NOBODY_APPROVED,
    OF_A_TWIN,
    VOLTS,
    Declared,
    declared_gaps,
    undeclared_gravity,
)
from procedures.report.overview import shared_statements
from rig.local_time import local_day

METER_UNDECLARED: FindingKind = "meter-undeclared"
GRAVITY_UNDECLARED: FindingKind = "gravity-undeclared"

NO_READINGS = "neither the run nor the file that the readings came from is on record"


@dataclass(frozen=True)
class Amendment:
    """The certificate that this one replaces, and why. Source: ISO/IEC 17025, 7.8.8."""

    number: str
    reason: str


@dataclass(frozen=True)
class Grounds:
    """Everything a certificate says comes from here."""

    number: str
    issued: date
    coefficients: CoefficientSet
    adjustment: Adjustment | None
    """As found and as left; None where the model tells no angles."""
    signed: SignOff
    """Who stands behind the set, and for which of its findings."""
    amends: Amendment | None = None
    is_specimen: bool = False
    """To look at, never to be sent: stamped on every page, and gaps are printed instead of refused."""

    @property
    def laboratory(self) -> Mapping[str, Json]:
        return table(self.coefficients.provenance["laboratory"] or {})

    @property
    def job(self) -> Mapping[str, Json]:
        return table(self.coefficients.provenance["job"] or {})

    @property
    def is_not_usable(self) -> bool:
        """Whether the calibration itself says that its stated uncertainties do not hold what was found."""
        return self.coefficients.verdict == NOT_USABLE

    @property
    def standards(self) -> tuple[Mapping[str, Json], ...]:
        return tuple(table(standard) for standard in listed(self.coefficients.provenance["standards"]))


def check_grounds(grounds: Grounds) -> None:
    """Check that a certificate can be issued on these grounds; a specimen is never refused.

    Raises: RequestError naming everything that is missing or forbids a certificate, a line each.
    """
    gaps = () if grounds.is_specimen else tuple(gaps_of(grounds))
    if gaps:
        raise RequestError(
            f"{grounds.coefficients.sensor}: certificate {grounds.number}: cannot be issued, nothing was written:\n"
            + "".join(f"  - {gap}\n" for gap in gaps)
            + "complete the rig file's [laboratory], [job] and [standards] and calibrate, or have the set signed and "
            "its findings accepted (calrig archive sign, accept); --specimen prints one to look at"
        )


def gaps_of(grounds: Grounds) -> Iterator[str]:
    """Yield what a certificate would lack, each with what the laboratory does about it."""
    yield from (gap.text for gap in _gaps(grounds))


def printed_gaps(grounds: Grounds) -> Iterator[str]:
    """Yield the same as a page has it, without the commands and keys of the laboratory."""
    yield from (gap.fact for gap in _gaps(grounds))


def _gaps(grounds: Grounds) -> Iterator[Said]:
    if grounds.coefficients.is_simulated:
        yield Said(OF_A_TWIN)
    calibrated = grounds.coefficients.created_utc.date()
    if grounds.issued < calibrated:
        yield Said(f"it is issued on {grounds.issued}, before the calibration ended on {calibrated} (UTC)")
    if grounds.signed.is_in_quarantine:
        yield Said(f"the set is in quarantine: {_quarantine(grounds.signed)}")
    if grounds.signed.withdrawal is not None:
        yield Said(f"the set is {grounds.signed.withdrawal}", "calibrate again")
    if grounds.signed.by("approved") is None:
        yield Said(NOBODY_APPROVED)
    provenance = grounds.coefficients.provenance
    if provenance["run_id"] is None and not provenance.get("readings"):
        yield Said(NO_READINGS, "solve the file again with this version of calrig fit, and archive that set")
    yield from declared_gaps(
        Declared(
            laboratory=grounds.laboratory,
            job=grounds.job,
            level=table(grounds.coefficients.provenance["level"] or {}),
            has_standards=bool(grounds.standards),
            senses_gravity=grounds.coefficients.senses_gravity,
            references=(
                *gravity_undeclared(grounds),
                *meters_undeclared(grounds),
                *(said for kind in _kinds_of_set(grounds) for said in _stated(grounds, kind)),
            ),
        )
    )
    stated = map(str, listed(grounds.coefficients.document["warnings"]))
    gaps = (*NO_CERTIFICATE_WITH, NO_THERMOMETER, NO_COEFFICIENTS_U, REFERENCE_NOT_MEASURED)
    yield from (Said(word) for word in stated if word.startswith(gaps))
    if grounds.is_not_usable and grounds.signed.accepted_verdict is None:
        yield Said(NOBODY_ACCEPTED, how_to_close(grounds.signed))
    yield from _unaccepted(grounds.signed.unaccepted)
    yield from (Said(_overdue(standard, grounds)) for standard in grounds.standards if _is_overdue(standard, grounds))


def _quarantine(signed: SignOff) -> str:
    """Return why the set is in quarantine, without what is said of its axes."""
    left = str(signed.quarantine)
    for said in (text for finding in signed.unaccepted for text in (finding.text, finding.fact)):
        left = left.replace(said, "")
    left = "; ".join(part.strip() for part in left.split(";") if part.strip())
    return left or "what its findings say"


def _unaccepted(findings: Sequence[StatedFinding]) -> Iterator[Said]:
    """Yield each finding that nobody has accepted once, with every axis that shows it and its names."""
    for shared in shared_statements((("", finding.axis, finding.fact) for finding in findings), ()):
        alike = [findings[index] for index in shared.members]
        axes = list(dict.fromkeys(finding.axis for finding in alike))
        about = f"{'axis' if len(axes) == 1 else 'axes'} {', '.join(axes)}"
        names = ", ".join(finding.name for finding in alike)
        yield Said(
            f"{about}: {shared.text} ({names}, which nobody has accepted)",
            "; ".join(dict.fromkeys(finding.text.removeprefix(finding.fact).lstrip("; ") for finding in alike)),
        )


def meters_undeclared(grounds: Grounds) -> tuple[Said, ...]:
    """Return what is to be said of volts that no standard is behind; nothing where no output is in volts.

    A set says it itself. Of one that does not, such as an earlier one, it is read from its standards.
    """
    stated = _stated(grounds, METER_UNDECLARED)
    is_in_volts = any(numbers.form.measured_unit == VOLTS for numbers in grounds.coefficients.axes.values())
    is_counted = any("uncertainty_v" in table(standard["uncertainty"] or {}) for standard in grounds.standards)
    if stated or is_counted or not is_in_volts:
        return stated
    fact = (
        f"{NO_METER}: none of the standards states it, so that what the zero and the gain of the meter are wrong by is "
        "in no figure stated here"
    )
    return (Said(fact, "declare readouts.NAME.standard, and uncertainty_v of that standard"),)


def gravity_undeclared(grounds: Grounds) -> tuple[Said, ...]:
    """Return what is to be said of a gravity without an uncertainty, where the coefficients are per local g.

    A set says it itself. Of one that does not, such as an earlier one, it is read from its unit of acceleration.
    """
    stated, gravity = _stated(grounds, GRAVITY_UNDECLARED), grounds.coefficients.gravity
    if stated or gravity.standard_uncertainty_mps2 or not grounds.coefficients.senses_gravity:
        return stated
    return (undeclared_gravity(gravity.value_mps2),)


def _kinds_of_set(grounds: Grounds) -> tuple[FindingKind, ...]:
    """Return of what nobody declared what a set alone tells; the level under gravity is asked of its rig file."""
    of_level: tuple[FindingKind, ...] = () if grounds.coefficients.senses_gravity else ("level-undeclared",)
    return (*of_level, "table-undeclared", "rate-undeclared", "field-undeclared")


def _stated(grounds: Grounds, kind: FindingKind) -> tuple[Said, ...]:
    """Return what a set's findings of one kind say, each once."""
    findings = findings_of_set(grounds.coefficients)
    return tuple(dict.fromkeys(Said(finding.fact, finding.what_to_do) for finding in findings if finding.kind == kind))


def _is_overdue(standard: Mapping[str, Json], grounds: Grounds) -> bool:
    due = standard["due"]
    return due is not None and date.fromisoformat(str(due)) < local_day(grounds.coefficients.created_utc)


def _overdue(standard: Mapping[str, Json], grounds: Grounds) -> str:
    ended = local_day(grounds.coefficients.created_utc)
    return f"standard {standard['name']} was due on {standard['due']}, before the calibration of {ended}"
