"""The dwells that were not believed, with their reasons."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("rejected", 500, fragment_beside(__file__), lambda _view: {"rejected": "Rejected dwells"})
