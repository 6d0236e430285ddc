"""What a run's visits say, handed to the sensors that it concerns: the table and the meter to all, a change to its own.

Every axis carries the findings; the significant ones stand among its warnings and those of its package.
"""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ams.calibration_result import Calibration
from ams.findings import ALL_AFTER, ON_ONE_SIDE, Finding, significant_texts
from ams.inputs.known_of_run import GAIN, OFFSET, DwellLabels, ProvedChange
from ams.surveillance.common_mode import CommonMode
from ams.surveillance.common_mode_columns import ROTATIONS
from procedures.common_mode.visit_watch import Judged
from procedures.common_mode.ways_out import meter_way_out
from procedures.records.dwells import DwellRecord
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor

_OF_METER: Final = frozenset({"meter-gain", "meter-offset"})
"""Also of what moves the axes of one name in all sensors alike."""


def run_findings(record: RunRecord) -> tuple[Finding, ...]:
    """Return what reference visits and check sets say of table, meter and sensors together.

    A sensor that creeps is no reservation where the solution has a term for it.
    """
    has_term = record.plan.solve.time_term == "linear"
    return tuple(
        replace(finding, is_significant=False)
        if has_term and judged_visit.is_slow and finding.kind == "sensor-change"
        else _with_way_out(finding, judged_visit, record)
        for judged_visit in record.judged_visits
        for finding in judged_visit.findings
    )


def _with_way_out(finding: Finding, judged: Judged, record: RunRecord) -> Finding:
    """Return a change of the meter with the dwells that it leaves in doubt, and the commands; any other as it is."""
    if not finding.is_significant or finding.kind not in _OF_METER:
        return finding
    run = shlex.quote(record.run_id)
    way_out = meter_way_out(judged.doubtful, judged.since, judged.until, record.dwells, record.plan, run)
    return replace(finding, text=f"{finding.text}; {way_out}")


def proved_changes(record: RunRecord) -> tuple[ProvedChange, ...]:
    """Return the changes of table or meter in mid-run that visits proved, with the dwells of the design on either side.

    What crept, what a single sensor may have done as well, and what all dwells stand on one side of is none.
    """
    design = [dwell for dwell in record.dwells if dwell.accepted and dwell.purpose == "design"]
    found = []
    for judged in record.judged_visits:
        if judged.is_slow or not any(_is_proved(finding) for finding in judged.findings):
            continue
        before = frozenset(_labels(dwell) for dwell in design if (dwell.epoch, dwell.ended_s) <= judged.since)
        after = frozenset(_labels(dwell) for dwell in design if (dwell.epoch, dwell.started_s) >= judged.until)
        found.append(ProvedChange(before, after, _parts(judged.common)))
    return tuple(found)


def _labels(dwell: DwellRecord) -> DwellLabels:
    return dwell.replication, dwell.point


def _is_proved(finding: Finding) -> bool:
    """Return whether a finding is one of the table, or of what all channels share."""
    if not finding.is_significant or any(finding.details.get(key) for key in (ON_ONE_SIDE, ALL_AFTER)):
        return False
    same = {word.strip() for word in str(finding.details.get("confounded_with") or "").split(",")} - {""}
    return not same if finding.kind == "table-rotation" else finding.kind in _OF_METER and same <= _OF_METER


def _parts(common: CommonMode) -> tuple[str, ...]:
    """Return what is told of table and meter, and the turns about one axis that look the same at the visits."""
    stated = {part for cause in common.stated if cause.kind == "table-rotation" for part in cause.parts}
    same = {
        cause.parts[0] for cause in common.also
        if stated and cause.kind == "table-rotation" and len(cause.parts) == 1
    }  # fmt: skip
    turns = tuple(name for name in ROTATIONS if name in stated | same)
    return (*turns, GAIN, OFFSET) if any(cause.kind in _OF_METER for cause in common.stated) else turns


def of_sensor(findings: Sequence[Finding], sensor: str) -> tuple[Finding, ...]:
    """Return the findings that concern a sensor."""
    return tuple(finding for finding in findings if finding.details.get("sensor", sensor) == sensor)


def with_run_findings(solved: SolvedSensor, findings: Sequence[Finding]) -> SolvedSensor:
    """Return the sensor with the findings on every axis, the significant ones among the warnings."""
    if solved.calibration is None:
        return solved
    return replace(solved, calibration=with_findings(solved.calibration, findings))


def with_findings(calibration: Calibration, findings: Sequence[Finding]) -> Calibration:
    """Return a calibration with findings on every axis, as :func:`with_run_findings` has them."""
    if not findings:
        return calibration
    sentences = significant_texts(findings)
    axes = {
        label: replace(axis, findings=(*axis.findings, *findings), warnings=(*axis.warnings, *sentences))
        for label, axis in calibration.axes.items()
    }
    return replace(calibration, axes=axes, warnings=(*calibration.warnings, *sentences))
