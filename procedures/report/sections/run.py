"""The design, the run's own figures and the check set after restarts."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("run", 200, fragment_beside(__file__), lambda _view: {"run": "Run and design"})
