"""Every stop of the run, and the notes."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("interruptions", 400, fragment_beside(__file__), lambda _view: {"interruptions": "Interruptions"})
