"""What the archive tells, as lines for a person and as plain values for JSON."""

import math
from collections.abc import Iterator, Mapping, Sequence
from datetime import date, datetime
from typing import Any

from ams.archive.due_list import Due
from ams.archive.histories import SensorHistory
from ams.archive.run_search import FoundRun
from ams.archive.sets import ArchivedSet
from ams.archive.sign_offs import AcceptedFinding, SignOff
from ams.parameter_words import words_of
from ams.rounding import signed, significant
from ams.sets.dated_ahead import is_dated_ahead
from ams.sets.stated_verdict import NOT_USABLE
from ams.surveillance.adjustment import Adjustment, Condition
from ams.surveillance.check_chart import LEAST_DIFFERENCES, CheckHistory
from ams.surveillance.compare import AxisChange, Change, Comparison
from ams.surveillance.control_chart import Chart
from ams.units import ARCSEC_PER_DEG, printed
from rig.local_time import at_both


def plain(value: Any) -> Any:
    """Return a value as JSON takes it.

    Moments as ISO 8601, arrays as lists, a number that is not finite as null.
    """
    if isinstance(value, Mapping):
        return {str(name): plain(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    if isinstance(value, datetime | date):
        return value.isoformat()
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def status_in_words(status: str, standing: str, *, is_signed: bool) -> str:
    """Tell whose approval it is: the rig file's is of rig and procedure, a certificate needs that of the set."""
    return "by an approved rig, not signed" if status == "approved" and not is_signed else standing


def set_lines(rows: Sequence[ArchivedSet], conditions: Mapping[str, str], now_utc: datetime) -> Iterator[str]:
    """Yield a line for each archived set; ``conditions``: checksum to what its verdict is without."""
    for row in rows:
        head, simulated = f"{row.sha256[:12]}  {row.sensor:<16} {at_both(row.created_utc)}  {row.model}", row.simulated
        if row.withdrawal is not None:
            yield f"{head}{', simulated' if simulated else ''}, {row.withdrawal}: not to be used"
            continue
        status = status_in_words(row.status, row.standing, is_signed=row.is_signed)
        stamp = f"{status}{', simulated' if simulated else ''}"
        verdicts = [f"{name} {value}" for name, value in (("found", row.as_found), ("left", row.as_left)) if value]
        judged = f", {', '.join(verdicts)}" if verdicts else ""
        without = "" if row.verdict == NOT_USABLE else conditions.get(row.sha256, "")
        judged += f", verdict {row.verdict}{without}" if row.verdict is not None else ""
        judged += ", in quarantine" if row.quarantine else ""
        is_ahead = not row.simulated and is_dated_ahead(row.created_utc, now_utc)
        judged += ", dated in the future by the clock of this computer" if is_ahead else ""
        yield f"{head}, {stamp}{judged}"


def withdrawal_line(sensor: str, signed: SignOff) -> str:
    """Return what whoever looks at a withdrawn set must read first."""
    return f"{sensor}: set {signed.sha256[:12]} is {signed.withdrawal}: it must not be used"


def due_lines(found: Sequence[Due], today: date, *, are_known: bool) -> Iterator[str]:
    """Yield a line for what is due, the earliest first; ``are_known``: whether the archive has anything to be due."""
    for item in found:
        day = "—" if item.due is None else f"{item.due}"
        serial = item.serial or "no serial"
        yield f"{day:<10}  {item.when(today):<14} {item.kind:<9} {item.name} ({serial}), {item.because}"
    if not found:
        yield (
            "nothing is due"
            if are_known
            else "the archive knows no standard and no measured sensor: nothing can be due"
        )


def found_lines(found: Sequence[FoundRun]) -> Iterator[str]:
    """Yield a line for each run, the newest first."""
    for item in found:
        stamp = ", simulated" if item.run.simulated else ""
        standards = f", with {', '.join(item.standards)}" if item.standards else ""
        yield (
            f"{at_both(item.run.started_utc)}  {item.run.run_id}  {item.run.title}: {', '.join(item.sensors)}"
            f"{standards}, by {item.run.operator}{stamp}"
        )


def adjustment_lines(adjustment: Adjustment | None) -> Iterator[str]:
    """Yield the lines on a sensor as found and as left."""
    if adjustment is None:
        yield "as found, as left: not in the archive"
        return
    if adjustment.as_found is None:
        yield f"as found: none ({adjustment.no_as_found})"
    else:
        yield from _condition_lines(adjustment.as_found, None)
        if adjustment.withdrawn_since is not None:
            yield f"  the set that it was found by is {adjustment.withdrawn_since}"
    yield from _condition_lines(adjustment.as_left, adjustment.not_judged)
    if adjustment.as_left.errors:
        yield adjustment.reference.sentence
    if adjustment.acceptance.limits_deg:
        yield f"decision rule: {adjustment.acceptance.rule_text}"


def _condition_lines(condition: Condition, not_judged: str | None) -> Iterator[str]:
    name = condition.kind.replace("-", " ")
    judged = f"not judged, {not_judged}" if not_judged else condition.verdict or "no limit to judge by"
    yield f"{name}: {judged} (set {condition.set_sha256[:12]})"
    for errors in condition.errors.values():
        at = errors.largest
        left_out = f", {errors.left_out} attitudes do not tell it" if errors.left_out else ""
        yield (
            f"  {errors.angle}: at most {signed(errors.error_deg[at], 5)}° with U {errors.expanded_deg[at]:.5f}° "
            f"(k = {errors.coverage_factor[at]:.2f}) at pitch {significant(errors.pitch_deg[at], 6)}°, roll "
            f"{significant(errors.roll_deg[at], 6)}°{left_out}"
        )
    yield from (f"  {angle}: not determined at any attitude of the usage range" for angle in condition.undetermined)
    for level in condition.level_errors.values():
        worst, unit = level.worst, printed(level.unit)
        yield (
            f"  {level.axis}: at most {level.error[worst]:+.3g} {unit} with U {level.expanded[worst]:.2g} {unit} "
            f"(k = {level.coverage_factor[worst]:.2f}) at {level.level[worst]:.4g} {unit}"
        )
    yield from (f"  {judgement.sentence}" for judgement in condition.judgements)


def sign_off_lines(signed: SignOff) -> Iterator[str]:
    """Yield the lines on who signed a set, and which certificates were issued."""
    yield f"set {signed.sha256[:12]}: {signed.standing}"
    for signature in signed.signatures:
        comment = f": {signature.comment}" if signature.comment else ""
        yield f"  {signature.role:<10} {signature.signatory}, {at_both(signature.signed_utc)}{comment}"
    if signed.approver_reviewed:
        yield "  who approved it reviewed it too: nobody else looked at it beside who prepared it"
    yield from _findings_lines(signed)
    for certificate in signed.certificates:
        amends = f", amends {certificate.amends} ({certificate.reason})" if certificate.amends else ""
        yield f"  certificate {certificate.number}, {certificate.issued_by}, {certificate.issued_utc:%Y-%m-%d}{amends}"


def _findings_lines(signed: SignOff) -> Iterator[str]:
    """Yield every significant finding and the verdict with who accepted it, and the quarantine with who released it."""
    words = {acceptance.finding: acceptance for acceptance in signed.acceptances}
    for finding in signed.findings:
        yield f"  finding    {finding.name}: {_accepted(words.get(finding.name))}"
    if signed.verdict == NOT_USABLE:
        yield f"  verdict    {NOT_USABLE}: {_accepted(signed.accepted_verdict)}"
    if signed.quarantine is not None:
        yield f"  quarantine {signed.quarantine}"
    if (done := signed.release) is not None:
        yield f"  released   {done.name}, {at_both(done.released_utc)}: {done.reason}"


def _accepted(word: AcceptedFinding | None) -> str:
    if word is None:
        return "accepted by nobody"
    return f"accepted by {word.name}, {at_both(word.accepted_utc)}: {word.reason}"


def comparison_lines(found: Comparison) -> Iterator[str]:
    """Yield the rotation first, then every axis."""
    yield f"{found.sensor}: {found.old_sha256[:12]} to {found.new_sha256[:12]}, {found.elapsed_days:.1f} days"
    yield from (f"note: {text}" for text in found.notes)
    turns = (f"{axis} {_turn(change)}" for axis, change in found.rotation_deg.items())
    yield f"common rotation of the package (remount): {', '.join(turns)}"
    if found.direction_p_value is not None:
        yield (
            f"what it leaves of the directions: χ² {found.direction_chi_square:.1f} with {found.direction_dof} degrees "
            f"of freedom (p {found.direction_p_value:.2g}, scatter of the two calibrations alone)"
        )
    else:
        yield "a single axis: a change of its direction cannot be told from a remount"
    for axis in found.axes.values():
        yield from _axis_lines(axis, found)
    yield f"the scatter from day to day is not in these uncertainties: calrig archive history {found.sensor} knows it"


def _axis_lines(change: AxisChange, found: Comparison) -> Iterator[str]:
    offset, relative = change.offset_v, change.sensitivity_relative
    yield f"axis {change.axis}"
    unit = printed(found.measured_unit)
    volts = f"{offset.value:+.3e} {unit} (u {offset.standard_uncertainty:.1e})"
    yield (
        f"  offset       {volts}   {_arcsec(change.offset_arcsec)}" if found.unit == "g" else f"  offset       {volts}"
    )
    yield f"  sensitivity  {relative.value * 1e6:+.2f} ppm (u {relative.standard_uncertainty * 1e6:.2f})"
    across = "   ".join(
        f"{axis} {_arcsec(component_arcsec)}" for axis, component_arcsec in change.direction_arcsec.items()
    )
    yield f"  direction    {across}"


def _turn(change: Change | None) -> str:
    return "not told" if change is None else f"{change.value:+.5f}° (u {change.standard_uncertainty:.5f})"


def _arcsec(change: Change) -> str:
    return f"{change.value:+.2f}″ (u {change.standard_uncertainty:.2f})"


def history_lines(found: SensorHistory) -> Iterator[str]:
    """Yield the charts as a table, what was found, advice."""
    history = found.history
    first, last = history.labels[0], history.labels[-1]
    count = len(history.labels)
    if count == 1:
        yield f"{history.sensor}: one calibration, of {first.created_utc:%Y-%m-%d}"
    else:
        yield f"{history.sensor}: {count} calibrations, {first.created_utc:%Y-%m-%d} to {last.created_utc:%Y-%m-%d}"
    yield f"{'characteristic':<28}{'now':>16} {'scatter':>10} {'rate a year':>22}   as an angle"
    yield from (_chart_line(chart) for chart in history.charts)
    if history.conclusion and (found.check is None or found.check.is_judged):
        yield history.conclusion
    for finding in history.findings:
        yield f"{finding.kind}: {finding.sentence}"
        if finding.rig_cause is not None:
            yield f"  but see the check sensor: {finding.rig_cause}"
    yield from (f"not the sensor: {sentence}" for sentence in found.not_its_doing)
    for held in found.in_quarantine:
        yield (
            f"left out: the calibration of {held.created_utc:%Y-%m-%d} (set {held.sha256[:12]}) is in quarantine: "
            f"{held.reason}; calrig archive release lets it count"
        )
    for gone in found.withdrawn:
        yield (
            f"left out: the calibration of {gone.created_utc:%Y-%m-%d} (set {gone.sha256[:12]}) is {gone.withdrawal}; "
            "it is in no mean, no limit and no scatter, and no later one is held against it"
        )
    if found.check is not None:
        yield from _check_lines(found.check)
    if found.advice is not None:
        yield f"next calibration, as advice: {found.advice.sentence}"


def _chart_line(chart: Chart) -> str:
    name, _, axis = chart.name.partition(".")
    label, _, unit = words_of(name)
    rate, spread = chart.rate_per_year, chart.rate_standard_uncertainty
    drift = "" if rate is None or spread is None else f"{rate:+.1e} (u {spread:.0e})"
    scatter = f"{chart.scatter:.1e}" if math.isfinite(chart.scatter) else ""
    angle = f"{chart.scatter * chart.deg_per_unit * ARCSEC_PER_DEG:.2f}″" if scatter else ""
    return f"{f'{label} {axis}, {unit}':<28}{chart.value[-1]:>16.8g} {scatter:>10} {drift:>22}   {angle}"


def _check_lines(check: CheckHistory) -> Iterator[str]:
    if len(check.labels) == 1:
        known = f"0 of {LEAST_DIFFERENCES} differences between runs"
        yield f"check sensor: cannot judge yet ({known}): there is no other run"
    elif not check.is_judged:
        known = f"{min(check.differences, LEAST_DIFFERENCES)} of {LEAST_DIFFERENCES}"
        yield f"check sensor: cannot judge yet ({known} differences between runs); by the certificates' uncertainties:"
        yield from (f"  {text}" for text in check.unexplained or ("nothing changed that they do not explain",))
    elif not check.findings:
        unseen = ", ".join(f"{size:.4f}° of the {whose}" for whose, size in check.unseen_deg.items())
        yield (
            "check sensor: nothing was found of table, meter and the sensor itself; a run that is off by less than "
            f"{unseen} would not be seen at once"
        )
        yield from (f"  more than the certificates explain: {text}" for text in check.unexplained)
    yield from (f"check sensor: {finding.cause}: {finding.sentence}" for finding in check.findings)
