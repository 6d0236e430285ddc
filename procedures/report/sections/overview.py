"""A row a sensor, where a run has several."""

from procedures.report.overview import has_overview
from procedures.report.section import Section, fragment_beside
from procedures.report.view import RunView


def _contents(view: RunView) -> dict[str, str]:
    return {"overview": "Overview"} if has_overview(view) else {}


SECTION = Section("overview", 50, fragment_beside(__file__), _contents, has_overview)
