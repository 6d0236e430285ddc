"""Devices, standards and what the rig declares."""

from procedures.report.section import Section, fragment_beside

SECTION = Section("equipment", 600, fragment_beside(__file__), lambda _view: {"equipment": "Equipment"})
