"""What was tested on many channels, a row a test: the tables of each sensor stand in its own document."""

from collections.abc import Iterator
from dataclasses import dataclass

from ams.analysis.diagnostics.low_order import SYMBOLS
from ams.findings import Finding
from procedures.report.overview import SharedStatement, shared_statements
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
    """Return what the tables call a finding: a term's symbol, a test's own name, or the kind."""
    name = str(finding.details.get("test", finding.kind.replace("-", " ")))
    return SYMBOLS.get(name, name)


def tests_in_short(view: RunView) -> list[ChannelsTested]:
    """Return a row a test, in the order in which the first channel was tested."""
    found: dict[str, list[tuple[str, Finding]]] = {}
    for sensor, axis, finding in _findings(view):
        found.setdefault(test_name(finding), []).append((f"{sensor.name} {axis.axis}", finding))
    return [_in_short(name, of_channels) for name, of_channels in found.items()]


@dataclass(frozen=True)
class SharedFinding:
    """What somebody must read, with all of whom it is true."""

    about: str
    name: str
    least_p: float | None
    text: str


def significant_findings(view: RunView) -> list[SharedFinding]:
    """Return what somebody must read, what is alike on several channels as one row."""
    found = [entry for entry in _findings(view) if entry[2].is_significant]
    shared = shared_statements(
        ((sensor.name, axis.axis, finding.text) for sensor, axis, finding in found),
        [sensor.name for sensor in view.sensors],
    )
    return [_shared(statement, [found[index][2] for index in statement.members]) for statement in shared]


def _shared(statement: SharedStatement, findings: list[Finding]) -> SharedFinding:
    rated = [finding.p_value for finding in findings if finding.p_value is not None]
    return SharedFinding(statement.about, test_name(findings[0]), min(rated, default=None), statement.text)


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
