"""Who calibrated, checked and approved."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("signatures", 800, fragment_beside(__file__), lambda _view: {"signatures": "Signatures"})
