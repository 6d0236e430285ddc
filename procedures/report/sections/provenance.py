"""Hashes, versions and how uncertainties are stated."""

from collections.abc import Mapping
from dataclasses import dataclass

from procedures.report.section import Section, SectionSource, fragment_beside


@dataclass(frozen=True)
class Provenance:
    """What the section brings."""

    hashes: Mapping[str, str]
    """What was hashed to its SHA-256."""
    versions: Mapping[str, str]
    """Software to its version."""


def provenance(source: SectionSource) -> Provenance:
    """Return the hashes and versions of a run, as its record has them."""
    return Provenance(source.record.hashes, source.record.versions)


SECTION = Section(
    "provenance", 700, fragment_beside(__file__), lambda _view: {"provenance": "Provenance"}, data=provenance
)
