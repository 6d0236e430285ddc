"""What was tested on many channels, a row a test: the tables of each sensor stand in its own document."""

from collections.abc import Iterator
from dataclasses import dataclass

from ams.findings import Finding
from procedures.report.view import AxisFindings, RunView, SensorView


@dataclass(frozen=True)
class ChannelsTested:
    """One test over all channels."""

    name: str
    channels: int
    significant: int
    smallest_p: float | None
    where: str
    """Sensor and axis of the smallest p."""


def test_name(finding: Finding) -> str:
    """Return what the tables call a finding: the test's own name, or its kind."""
    return str(finding.details.get("test", finding.kind.replace("-", " ")))


def tests_in_short(view: RunView) -> list[ChannelsTested]:
    """Return a row a test, in the order in which the first channel was tested."""
    found: dict[str, list[tuple[str, Finding]]] = {}
    for sensor, axis, finding in _findings(view):
        found.setdefault(test_name(finding), []).append((f"{sensor.name} {axis.axis}", finding))
    return [_in_short(name, of_channels) for name, of_channels in found.items()]


def significant_findings(view: RunView) -> list[tuple[SensorView, AxisFindings, Finding]]:
    """Return what somebody must read, sensor by sensor."""
    return [found for found in _findings(view) if found[2].is_significant]


def _findings(view: RunView) -> Iterator[tuple[SensorView, AxisFindings, Finding]]:
    for sensor in view.sensors:
        for axis in sensor.findings:
            for finding in axis.findings:
                yield sensor, axis, finding


def _in_short(name: str, of_channels: list[tuple[str, Finding]]) -> ChannelsTested:
    rated = [(finding.p_value, where) for where, finding in of_channels if finding.p_value is not None]
    smallest_p, where = min(rated, default=(None, ""))
    significant = sum(finding.is_significant for _, finding in of_channels)
    return ChannelsTested(name, len(of_channels), significant, smallest_p, where)
