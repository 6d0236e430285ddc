"""The dwells that were not believed, and the moves that were made again, with their reasons."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("rejected", 500, fragment_beside(__file__), lambda _view: {"rejected": "Rejected dwells"})
