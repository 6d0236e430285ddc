"""What is missing for a calibration."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("missing", 300, fragment_beside(__file__), is_shown=lambda view: bool(view.missing))
