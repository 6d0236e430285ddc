"""Hashes, versions and how uncertainties are stated."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("provenance", 700, fragment_beside(__file__), lambda _view: {"provenance": "Provenance"})
