"""As found and as left: how wrong a sensor was with the set it was used with, and how good it is with the new one.

*As found* is the previous set applied to the data of the new run, before anything is adjusted: what users of the sensor
got until now. *As left* is the new set applied to the same data. Both are errors of inferred angles over the usage
range, judged against the limits that the rig file accepts (``[acceptance]``) by a stated decision rule.

Decision rules, U being the expanded uncertainty of the error (95 %):

- guard band (ISO 14253-1, ILAC-G8:09/2019 4.2.3): *pass* where |error| + U is inside the limit at every point; *fail*
  where |error| − U is beyond it at any; *conditional* between, where the uncertainty leaves it open;
- simple (ILAC-G8:09/2019 4.2.1): *pass* where |error| is inside the limit at every point, else *fail*.

U is no smaller than the capability that the laboratory states (ILAC-P14:09/2020 5.4): what a certificate prints is what
it judges by.

Points at which the axes do not determine an angle are counted beside its judgement. An angle with a limit that none of
them determines is *conditional* by either rule: nothing shows that it is inside.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Literal

import numpy as np

from ams.arrays import FloatArray
from ams.errors import OutsideValidity
from ams.observations import Observations
from ams.rounding import signed, significant
from ams.sets.canonical import Document, Json, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.stated_verdict import Withdrawal, no_conformity
from ams.surveillance.attitude_errors import AngleErrors, angles_of, errors_of
from ams.surveillance.level_errors import LevelErrors, level_errors_of
from ams.surveillance.level_errors import from_document as read_level_errors
from ams.surveillance.level_errors import to_document as level_errors_document
from ams.surveillance.reference_attitude import NOTHING_DECLARED, ReferenceAttitude, ReferenceInWords
from ams.surveillance.reference_attitude import from_document as read_reference
from ams.surveillance.reference_attitude import to_document as reference_document

Verdict = Literal["pass", "conditional", "fail"]
Rule = Literal["guard-band", "simple"]

RULES: Mapping[str, str] = {
    "guard-band": (
        "pass where |error| + U is inside the limit at every attitude, fail where |error| − U is beyond it at any, "
        "conditional between; U is the expanded uncertainty of the error, 95 %, and the guard band: at an attitude a "
        "false accept, and a false reject where it fails, has a probability of 2.5 % at most (ISO 14253-1, "
        "ILAC-G8:09/2019)"
    ),
    "simple": (
        "pass where |error| is inside the limit at every attitude, else fail; the uncertainty is stated and not "
        "subtracted: without a guard band a false accept at an attitude has a probability of up to 50 % (simple "
        "acceptance, ILAC-G8:09/2019)"
    ),
}
_ORDER: tuple[Verdict, ...] = ("pass", "conditional", "fail")


@dataclass(frozen=True)
class Acceptance:
    """What the sensor must meet."""

    limits_deg: Mapping[str, float]
    """Angle (``pitch``, ``roll``) to the largest error allowed; an angle without a limit is not judged."""
    rule: Rule = "guard-band"
    capability_deg: float = 0.0
    """Of the laboratory: no expanded uncertainty is taken to be smaller; 0 where none is stated."""

    @property
    def rule_text(self) -> str:
        return RULES[self.rule]


@dataclass(frozen=True)
class Judgement:
    """One angle against its limit."""

    angle: str
    limit_deg: float
    verdict: Verdict
    error_deg: float
    """At the attitude that decides: where the error and its uncertainty together are largest. NaN, and no attitude,
    where the angle is not determined.
    """
    expanded_deg: float
    pitch_deg: float
    roll_deg: float
    sentence: str


@dataclass(frozen=True)
class Condition:
    """A sensor as found or as left."""

    kind: Literal["as-found", "as-left"]
    set_sha256: str
    """Of the set that was applied."""
    set_created_utc: datetime
    errors: Mapping[str, AngleErrors]
    judgements: tuple[Judgement, ...]
    level_errors: Mapping[str, LevelErrors] = field(default_factory=dict)
    """Of straight lines, by axis, in the unit of what they sense: a declared limit is an angle and judges none."""
    undetermined: tuple[str, ...] = ()
    """Angles that the axes of the set tell in general and at no attitude of the usage range."""

    @property
    def verdict(self) -> Verdict | None:
        """The worst of all angles; None where no limit is declared."""
        return max((judgement.verdict for judgement in self.judgements), key=_ORDER.index, default=None)

    @property
    def largest_error_deg(self) -> float | None:
        """Of any angle, in size; None where no attitude tells any."""
        return max((float(np.abs(error.error_deg).max()) for error in self.errors.values()), default=None)


@dataclass(frozen=True)
class Adjustment:
    """As found and as left of one sensor in one run."""

    sensor: str
    usage_pitch_deg: tuple[float, float] | None
    """None: the whole range of the run."""
    acceptance: Acceptance
    as_found: Condition | None
    no_as_found: str | None
    """Why there is none."""
    as_left: Condition
    reference: ReferenceInWords = NOTHING_DECLARED
    """What of the reference attitude the uncertainties of the errors count."""
    not_judged: str | None = None
    """Why the limits that are declared are not judged as left; None where they are, or where there is none."""
    withdrawn_since: Withdrawal | None = None
    """Who withdrew the set that the sensor was found by, as the archive knows now; None where nobody did."""


def adjust(
    previous: CoefficientSet | None,
    new: CoefficientSet,
    observations: Observations,
    acceptance: Acceptance,
    usage_pitch_deg: tuple[float, float] | None = None,
    run_at_fault: str | None = None,
    reference: ReferenceAttitude | None = None,
    *,
    is_in_quarantine: bool = False,
) -> Adjustment:
    """Judge a sensor as found by the previous set and as left by the new one, both on the data of the new run.

    ``run_at_fault``: why this run says nothing of how a sensor was found (:mod:`ams.archive.run_at_fault`).
    Limits are not judged as left of a set in quarantine, nor where the new calibration is not usable.
    ``reference``: what its attitudes are wrong by; None: not declared, and not in the uncertainties.

    Of straight lines the errors are those of what they sense.

    Raises: OutsideValidity where even the new set tells no angle (gyros, CR's packages).
    """
    as_left = _condition("as-left", new, new, observations, acceptance, usage_pitch_deg, reference)
    as_found, why = None, "first calibration in this archive" if previous is None else None
    if run_at_fault is not None:
        why = f"not judged, this run does not tell: {run_at_fault}"
    elif previous is not None:
        try:
            as_found = _condition("as-found", previous, new, observations, acceptance, usage_pitch_deg, reference)
        except OutsideValidity as error:
            why = str(error)
    in_words = NOTHING_DECLARED if reference is None else reference.in_words
    found = Adjustment(new.sensor, usage_pitch_deg, acceptance, as_found, why, as_left, in_words)
    return without_conformity(found, no_conformity(new.verdict, is_in_quarantine=is_in_quarantine))


def without_conformity(adjustment: Adjustment, why: str | None) -> Adjustment:
    """Return the adjustment with its errors as left and no judgement of them, where there is a reason for that.

    A decision rule rests on U: where the calibration says that U does not hold, nothing is inside a limit by it.
    """
    if why is None or not adjustment.acceptance.limits_deg:
        return adjustment
    return replace(adjustment, as_left=replace(adjustment.as_left, judgements=()), not_judged=why)


def acceptance_of(provenance: Mapping[str, Json]) -> Acceptance:
    """Return what a set's ``provenance`` states: the rig file's ``[acceptance]`` and the laboratory's capability."""
    capability = table(provenance.get("laboratory") or {}).get("capability_deg")
    return _acceptance(table(provenance.get("acceptance") or {}), capability)


def _acceptance(declared: Mapping[str, Json], capability_deg: Json) -> Acceptance:
    limits = {
        angle: number(value) for angle in ("pitch", "roll") if (value := declared.get(f"{angle}_limit_deg")) is not None
    }
    rule: Rule = "simple" if declared.get("decision_rule") == "simple" else "guard-band"
    return Acceptance(limits, rule, 0.0 if capability_deg is None else number(capability_deg))


def judge(errors: AngleErrors, limit_deg: float, rule: Rule, capability_deg: float = 0.0) -> Judgement:
    """Judge one angle against its limit by the rule."""
    size, expanded = np.abs(errors.error_deg), np.maximum(errors.expanded_deg, capability_deg)
    worst = int(np.argmax(size + expanded))
    if rule == "simple":
        index = int(np.argmax(size))
        verdict: Verdict = "pass" if size[index] <= limit_deg else "fail"
    else:
        index = worst if (size + expanded).max() <= limit_deg else int(np.argmax(size - expanded))
        verdict = _guarded(float((size + expanded).max()), float((size - expanded).max()), limit_deg)
        index = worst if verdict == "conditional" else index
    decisive = float(errors.error_deg[index]), float(expanded[index])
    where = float(errors.pitch_deg[index]), float(errors.roll_deg[index])
    sentence = _sentence(errors.angle, verdict, decisive, limit_deg, where)
    if expanded[index] > errors.expanded_deg[index]:
        sentence += "; U is the capability"
    if errors.left_out:
        sentence += f"; not determined at {errors.left_out} of {errors.left_out + size.size} attitudes"
    return Judgement(errors.angle, limit_deg, verdict, *decisive, *where, sentence)


def _judged(
    errors: Mapping[str, AngleErrors], undetermined: tuple[str, ...], acceptance: Acceptance
) -> tuple[Judgement, ...]:
    return tuple(
        judge(errors[angle], limit, acceptance.rule, acceptance.capability_deg)
        if angle in errors
        else _not_determined(angle, limit)
        for angle, limit in acceptance.limits_deg.items()
        if angle in errors or angle in undetermined
    )


def _not_determined(angle: str, limit_deg: float) -> Judgement:
    sentence = (
        f"{angle} conditional: its axes determine it at no attitude of the usage range, so that nothing shows whether "
        f"it is inside the limit of {limit_deg:g}°"
    )
    return Judgement(angle, limit_deg, "conditional", np.nan, np.nan, np.nan, np.nan, sentence)


def _guarded(most_deg: float, least_deg: float, limit_deg: float) -> Verdict:
    if most_deg <= limit_deg:
        return "pass"
    return "fail" if least_deg > limit_deg else "conditional"


def _sentence(
    angle: str, verdict: Verdict, decisive: tuple[float, float], limit_deg: float, where: tuple[float, float]
) -> str:
    error, expanded = decisive
    side = "inside" if abs(error) <= limit_deg else "beyond"
    reservation = f", but by less than its uncertainty of {expanded:.4f}°" if verdict == "conditional" else ""
    return (
        f"{angle} {verdict}: error {signed(error, 4)}° with U {expanded:.4f}° at pitch {significant(where[0], 6)}°, "
        f"roll {significant(where[1], 6)}° is {side} the limit of {limit_deg:g}°{reservation}"
    )


def _condition(
    kind: Literal["as-found", "as-left"],
    applied: CoefficientSet,
    new: CoefficientSet,
    observations: Observations,
    acceptance: Acceptance,
    usage_pitch_deg: tuple[float, float] | None,
    reference: ReferenceAttitude | None,
) -> Condition:
    if new.is_of_lines:
        return Condition(kind, applied.sha256, applied.created_utc, {}, (), level_errors_of(applied, new))
    errors = errors_of(applied, new, observations, usage_pitch_deg, reference)
    undetermined = tuple(angle for angle in angles_of(applied) if angle not in errors)
    judged = _judged(errors, undetermined, acceptance)
    return Condition(kind, applied.sha256, applied.created_utc, errors, judged, undetermined=undetermined)


def to_document(adjustment: Adjustment) -> Document:
    """Return the adjustment as plain JSON values."""
    return {
        "sensor": adjustment.sensor,
        "usage_pitch_deg": None if adjustment.usage_pitch_deg is None else list(adjustment.usage_pitch_deg),
        "acceptance": {
            "limits_deg": dict(adjustment.acceptance.limits_deg),
            "rule": adjustment.acceptance.rule,
            "capability_deg": adjustment.acceptance.capability_deg,
        },
        "as_found": None if adjustment.as_found is None else _condition_document(adjustment.as_found),
        "no_as_found": adjustment.no_as_found,
        "as_left": _condition_document(adjustment.as_left),
        **({"not_judged": adjustment.not_judged} if adjustment.not_judged else {}),
        "reference": reference_document(adjustment.reference),
    }


def from_document(document: Document, acceptance: Acceptance | None = None) -> Adjustment:
    """Return the adjustment back from :func:`to_document`.

    ``acceptance``: what it is judged by; None: as is stored, which may know of no capability.
    """
    usage, accepted = document["usage_pitch_deg"], table(document["acceptance"])
    if acceptance is None:
        limits = {f"{angle}_limit_deg": limit for angle, limit in table(accepted["limits_deg"]).items()}
        acceptance = _acceptance({**limits, "decision_rule": accepted["rule"]}, accepted.get("capability_deg"))
    found, why, not_judged = document["as_found"], document["no_as_found"], document.get("not_judged")
    read = Adjustment(
        str(document["sensor"]),
        None if usage is None else (number(listed(usage)[0]), number(listed(usage)[1])),
        acceptance,
        None if found is None else _read_condition("as-found", table(found), acceptance),
        None if why is None else str(why),
        _read_condition("as-left", table(document["as_left"]), acceptance),
        read_reference(document.get("reference")),
    )
    return without_conformity(read, None if not_judged is None else str(not_judged))


def _condition_document(condition: Condition) -> Document:
    levels: Document = {axis: level_errors_document(errors) for axis, errors in condition.level_errors.items()}
    return {
        "set_sha256": condition.set_sha256,
        "set_created_utc": condition.set_created_utc.isoformat(),
        "verdict": condition.verdict,
        "errors": {angle: _errors_document(errors) for angle, errors in condition.errors.items()},
        **({"level_errors": levels} if levels else {}),
        **({"undetermined": list(condition.undetermined)} if condition.undetermined else {}),
    }


def _errors_document(errors: AngleErrors) -> Document:
    columns = ("pitch_deg", "roll_deg", "error_deg", "standard_uncertainty_deg", "coverage_factor")
    return {
        **{name: [float(value) for value in getattr(errors, name)] for name in columns},
        "left_out": errors.left_out,
        "parts_deg": {name: [float(value) for value in part] for name, part in errors.parts_deg.items()},
    }


def _read_condition(kind: Literal["as-found", "as-left"], document: Document, acceptance: Acceptance) -> Condition:
    errors = {angle: _read_errors(angle, table(entry)) for angle, entry in table(document["errors"]).items()}
    undetermined = tuple(map(str, listed(document.get("undetermined", []))))
    judged = _judged(errors, undetermined, acceptance)
    created = datetime.fromisoformat(str(document["set_created_utc"]))
    levels = {
        axis: read_level_errors(axis, table(entry)) for axis, entry in table(document.get("level_errors", {})).items()
    }
    return Condition(kind, str(document["set_sha256"]), created, errors, judged, levels, undetermined)


def _column(values: Json) -> FloatArray:
    return np.array([number(value) for value in listed(values)], dtype=float)


def _coverage_factors(document: Document, points: int) -> FloatArray:
    """Return a factor for every point; documents of before had one for all."""
    stated = document["coverage_factor"]
    values = [number(value) for value in listed(stated)] if isinstance(stated, list) else [number(stated)] * points
    return np.array(values, dtype=float)


def _read_errors(angle: str, document: Document) -> AngleErrors:
    def column(name: str) -> FloatArray:
        return _column(document[name])

    return AngleErrors(
        angle,
        column("pitch_deg"),
        column("roll_deg"),
        column("error_deg"),
        column("standard_uncertainty_deg"),
        _coverage_factors(document, len(column("error_deg"))),
        int(number(document["left_out"])),
        {name: _column(values) for name, values in table(document.get("parts_deg", {})).items()},
    )
