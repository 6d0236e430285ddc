"""The findings that a document states, of a set or of a fit."""

from collections.abc import Iterator

from ams.sets.canonical import Document, listed, table


def findings_by_axis(document: Document) -> Iterator[tuple[str, Document]]:
    """Yield axis and finding, axis by axis; sets of before version 3 have none."""
    for axis, section in table(document["axes"]).items():
        for finding in listed(table(section).get("findings", [])):
            yield axis, table(finding)
