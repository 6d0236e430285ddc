"""What came out of each sensor."""

from procedures.report.section import Section, fragment_beside
from procedures.report.view import RunView


def _contents(view: RunView) -> dict[str, str]:
    return {f"sensor-{sensor.slug}": sensor.name for sensor in view.sensors}


SECTION = Section("sensors", 100, fragment_beside(__file__), _contents)
