"""What a run's visits say, handed to the sensors that it concerns: the table and the meter to all, a change to its own.

Every axis carries the findings; the significant ones stand among its warnings and those of its package.
"""

from collections.abc import Sequence
from dataclasses import replace

from ams.calibration_result import Calibration
from ams.findings import Finding, significant_texts
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor


def run_findings(record: RunRecord) -> tuple[Finding, ...]:
    """Return what reference visits and check sets say of table, meter and sensors together.

    A sensor that creeps is no reservation where the solution has a term for it.
    """
    has_term = record.plan.solve.time_term == "linear"
    return tuple(
        replace(finding, is_significant=False)
        if has_term and judged_visit.is_slow and finding.kind == "sensor-change"
        else finding
        for judged_visit in record.judged_visits
        for finding in judged_visit.findings
    )


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
