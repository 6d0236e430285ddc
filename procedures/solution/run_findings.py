"""What a run's visits say, handed to the sensors that it concerns: the table and the meter to all, a change to its own.

Every axis carries the findings; the significant ones stand among its warnings and those of its package.
"""

from collections.abc import Sequence
from dataclasses import replace

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
    if solved.calibration is None or not findings:
        return solved
    sentences = significant_texts(findings)
    axes = {
        label: replace(axis, findings=(*axis.findings, *findings), warnings=(*axis.warnings, *sentences))
        for label, axis in solved.calibration.axes.items()
    }
    calibration = replace(solved.calibration, axes=axes, warnings=(*solved.calibration.warnings, *sentences))
    return replace(solved, calibration=calibration)
