"""What was tested on the data of every axis, and what was found."""

from procedures.report.section import Section, fragment_beside
from procedures.report.view import RunView


def _has_findings(view: RunView) -> bool:
    return any(axis.findings for sensor in view.sensors for axis in sensor.findings)


SECTION = Section(
    "findings",
    150,
    fragment_beside(__file__),
    lambda view: {"findings": "Findings"} if _has_findings(view) else {},
    _has_findings,
)
