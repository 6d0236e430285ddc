"""What a run's visits say, handed to the sensors that it concerns: the table and the meter to all, a change to its own.

Every axis carries the findings; the significant ones stand among its warnings and those of its package.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ams.analysis.predictions import model_of_solution
from ams.calibration_result import AxisCalibration, Calibration, with_findings
from ams.finding_kinds import OF_THE_METER
from ams.findings import ALL_AFTER, ON_ONE_SIDE, SHOWN_BY, Finding
from ams.inputs.known_of_run import GAIN, OFFSET, DwellLabels, ProvedChange
from ams.observations import Observations
from ams.surveillance.common_mode import CommonMode
from ams.surveillance.turns import FIXTURE, ROLL, ROTATIONS
from ams.units import ARCSEC_PER_DEG
from procedures.common_mode.visit_watch import Judged
from procedures.common_mode.ways_out import meter_way_out
from procedures.records.dwells import DwellRecord
from procedures.solution.lost_record import lost_record
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor

_OF_95_PERCENT: Final = 1.96


def run_findings(record: RunRecord) -> tuple[Finding, ...]:
    """Return what the record, reference visits and check sets say of table, meter and sensors together.

    A sensor that creeps is no reservation where the solution has a term for it.
    """
    return tuple(finding for finding, _ in _of_run(record))


def findings_beside_dwells(record: RunRecord, solved: Mapping[str, SolvedSensor]) -> tuple[Finding, ...]:
    """Return the findings of a run but for turns of the table that the dwells of every solved sensor tell better."""
    by_dwells = [shown_by_dwells(sensor.calibration) for sensor in solved.values() if sensor.calibration is not None]
    by_all = frozenset.intersection(*by_dwells) if by_dwells else frozenset()
    return tuple(finding for finding, turned in _of_run(record) if turned not in by_all)


def findings_of_sensor(record: RunRecord, sensor: SolvedSensor) -> tuple[Finding, ...]:
    """Return what is said of the run that concerns a sensor.

    A turn of the table that its own dwells tell is told by these; of another, whether its uncertainties hold it. What
    turned about roll alone did not turn a sensor that roll does not reach.
    """
    rolls = record.plan.sensors[sensor.name].rolls
    if sensor.calibration is None:
        return tuple(each for each in of_sensor(run_findings(record), sensor.name) if rolls or not _is_of_roll(each))
    by_dwells = shown_by_dwells(sensor.calibration)
    return tuple(
        replace(finding, is_held=_holds(sensor, finding)) if _is_turn(finding) else finding
        for finding, turned in _of_run(record)
        if turned not in by_dwells
        and finding.details.get("sensor", sensor.name) == sensor.name
        and (rolls or not _is_of_roll(finding))
    )


def shown_by_dwells(calibration: Calibration) -> frozenset[str]:
    """Return between which visits a turn was proved that the dwells of a calibration tell."""
    found = (finding.details.get(SHOWN_BY) for axis in calibration.axes.values() for finding in axis.findings)
    return frozenset(between for shown in found if shown for between in str(shown).split("; "))


def _of_run(record: RunRecord) -> Iterator[tuple[Finding, str]]:
    """Yield what the record, visits and check sets say; of a turn that did not creep also between which visits."""
    if (lost := lost_record(record.events)) is not None:
        yield lost, ""
    has_term = record.plan.solve.time_term == "linear"
    for judged in record.judged_visits:
        for finding in judged.findings:
            if has_term and judged.is_slow and finding.kind == "sensor-change":
                yield replace(finding, is_significant=False), ""
                continue
            is_step = _is_turn(finding) and not judged.is_slow
            yield _with_way_out(finding, judged, record), judged.between if is_step else ""


def _is_turn(finding: Finding) -> bool:
    return finding.kind == "table-rotation" and _is_proved(finding)


def _is_of_roll(finding: Finding) -> bool:
    """Return whether it is a slip of roll, or a turn of the fixture that roll carries."""
    cause = finding.details.get("cause")
    return cause == ROLL or (cause == FIXTURE and f"{ROLL}_arcsec" in finding.details)


def _holds(sensor: SolvedSensor, finding: Finding) -> bool:
    """Return whether what a turn may do at most is within the 95 % of every fitted output at every attitude."""
    assert sensor.calibration is not None
    turned_rad = float(np.deg2rad(float(finding.details.get("turned_arcsec") or np.inf) / ARCSEC_PER_DEG))
    return all(
        turned_rad * float(np.linalg.norm(axis.sensitive_axis_v_per_g)) <= _least_halfwidth(axis, sensor.observations)
        for axis in sensor.calibration.axes.values()
    )


def _least_halfwidth(axis: AxisCalibration, rows: Observations) -> float:
    """Return the smallest half-width of 95 % of the fitted output at any attitude, in the unit of the output."""
    directions = model_of_solution(axis).jacobian(axis.primary, rows)
    variances = np.einsum("ni,ij,nj->n", directions, axis.primary_covariance, directions)
    return _OF_95_PERCENT * float(np.sqrt(variances.min()))


def _with_way_out(finding: Finding, judged: Judged, record: RunRecord) -> Finding:
    """Return a change of the meter with the dwells that it leaves in doubt, and the commands; any other as it is."""
    if not finding.is_significant or finding.kind not in OF_THE_METER:
        return finding
    return finding.adding(*meter_way_out(judged.doubtful, judged.since, judged.until, record.dwells, record.run))


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
        found.append(ProvedChange(before, after, _parts(judged.common), judged.between))
    return tuple(found)


def _labels(dwell: DwellRecord) -> DwellLabels:
    return dwell.replication, dwell.point


def _is_proved(finding: Finding) -> bool:
    """Return whether a finding is one of the table, or of what all channels share."""
    if not finding.is_significant or any(finding.details.get(key) for key in (ON_ONE_SIDE, ALL_AFTER)):
        return False
    same = {word.strip() for word in str(finding.details.get("confounded_with") or "").split(",")} - {""}
    return not same if finding.kind == "table-rotation" else finding.kind in OF_THE_METER and same <= OF_THE_METER


def _parts(common: CommonMode) -> tuple[str, ...]:
    """Return what is told of table and meter, and the turns about one axis that look the same at the visits."""
    stated = {part for cause in common.stated if cause.kind == "table-rotation" for part in cause.parts}
    same = {
        cause.parts[0] for cause in common.also
        if stated and cause.kind == "table-rotation" and len(cause.parts) == 1
    }  # fmt: skip
    turns = tuple(name for name in ROTATIONS if name in stated | same)
    return (*turns, GAIN, OFFSET) if any(cause.kind in OF_THE_METER for cause in common.stated) else turns


def of_sensor(findings: Sequence[Finding], sensor: str) -> tuple[Finding, ...]:
    """Return the findings that concern a sensor."""
    return tuple(finding for finding in findings if finding.details.get("sensor", sensor) == sensor)


def with_run_findings(solved: SolvedSensor, findings: Sequence[Finding]) -> SolvedSensor:
    """Return the sensor with the findings on every axis, the significant ones among the warnings."""
    if solved.calibration is None:
        return solved
    return replace(solved, calibration=with_findings(solved.calibration, findings))
