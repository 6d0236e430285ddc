"""Sets of a run that is solved again: one that differs in its last digits alone is the set that is there already.

Sums over many rows end otherwise on another processor, or with another number of threads. A second set of the same
result would have another checksum, stand before the one that was signed, and be signed by nobody.
"""

from collections.abc import Mapping

from ams.archive.sets import Search, list_sets, show
from ams.errors import ArchiveDamaged, ArchiveError, SetError
from ams.sets.coefficients import CoefficientSet
from ams.sets.findings_by_axis import findings_by_axis
from procedures.delivery.number_changes import number_changes


def kept_sets(archive_url: str, sets: Mapping[str, CoefficientSet]) -> dict[str, CoefficientSet]:
    """Return sensor to the archived set of the same run that its set repeats; a sensor without one is missing.

    One that was withdrawn comes with that: what a person withdrew does not stand again under other last digits.

    An archive that is not there, or cannot be read now, keeps nothing: that it cannot be written is told where the sets
    are published.

    Raises: ArchiveDamaged; what a damaged archive holds of the run is not known, and nothing is published to it.
    """
    found: dict[str, CoefficientSet] = {}
    runs = {made.provenance["run_id"] for made in sets.values()}
    try:
        for run_id in runs:
            entries = list_sets(archive_url, search=Search(run_id=run_id)) if isinstance(run_id, str) else ()
            for entry in entries:  # of several that are alike the newest
                made = sets.get(entry.sensor)
                if made is None:
                    continue
                archived = show(archive_url, entry.sha256)
                if _is_repeated(archived, made):
                    found[entry.sensor] = archived
    except ArchiveDamaged:
        raise
    except (ArchiveError, SetError):
        pass
    return found


def _is_repeated(archived: CoefficientSet, made: CoefficientSet) -> bool:
    old, new = archived.document, made.document
    alike = ("format", "version", "sensor", "model", "convention", "method_version", "verdict", "provenance")
    if any(old.get(name) != new.get(name) for name in alike) or _found_kinds(archived) != _found_kinds(made):
        return False
    return not any(number_changes(made.sensor, old, new))


def _found_kinds(coefficients: CoefficientSet) -> dict[str, list[tuple[str, bool]]]:
    """Return axis to the kinds of its findings, and whether each is significant."""
    found: dict[str, list[tuple[str, bool]]] = {}
    for axis, finding in findings_by_axis(coefficients.document):
        found.setdefault(axis, []).append((str(finding["kind"]), bool(finding["significant"])))
    return found
