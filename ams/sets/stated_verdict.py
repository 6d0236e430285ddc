"""What a set states of its own calibration in one word, and what an approval over that word is called everywhere."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from ams.findings import UNUSABLE_AXIS, is_left_to_a_person
from ams.sets.canonical import Document
from ams.sets.findings_by_axis import findings_by_axis

NOT_USABLE: Final = "not usable"
"""The verdict over which nothing is approved unless a person accepts it by this name."""
NOBODY_ACCEPTED: Final = "nobody has accepted the verdict 'not usable' of the calibration"


@dataclass(frozen=True)
class AcceptedVerdict:
    """One person's word that a set may be used though its calibration is not usable, and why."""

    name: str
    reason: str


def stated_verdict(document: Document) -> str | None:
    """Return the verdict of a set's document; None where it tells none.

    Sets of before the key tell theirs by a finding that exceeds the stated uncertainties.
    """
    if "verdict" in document:
        return str(document["verdict"])
    return NOT_USABLE if _named(document, _exceeds) else None


def verdict_in_words(document: Document) -> str | None:
    """Return the verdict of a set or of a fit with its ground, such as ``not usable: … (x: sensor-change)``.

    None where the document tells none.
    """
    verdict = stated_verdict(document)
    if verdict is None:
        return None
    if verdict == NOT_USABLE:
        exceeded = _named(document, _exceeds)
        if exceeded:
            return f"{verdict}: the stated uncertainties do not hold what the data show ({exceeded})"
        forbidding = _named(
            document,
            lambda finding: finding["kind"] in (*UNUSABLE_AXIS, "table-rotation") and not is_left_to_a_person(finding),
        )
        return f"{verdict}: nothing rests on what the data show ({forbidding})" if forbidding else verdict
    return f"{verdict}: {'the warnings must be read first' if verdict == 'usable' else 'nothing speaks against it'}"


def no_conformity(verdict: str | None, *, is_in_quarantine: bool) -> str | None:
    """Return why no limit is judged of a sensor as left: its stated uncertainties do not hold; else None."""
    if verdict == NOT_USABLE:
        return "the calibration is not usable"
    return "the set was put in quarantine" if is_in_quarantine else None


def _exceeds(finding: Document) -> bool:
    return "stated_uncertainties" in finding


def _named(document: Document, is_meant: Callable[[Document], bool]) -> str:
    """Return the significant findings that are meant, by axis and kind, each once."""
    found = (
        f"{axis}: {finding['kind']}"
        for axis, finding in findings_by_axis(document)
        if finding["significant"] and is_meant(finding)
    )
    return ", ".join(dict.fromkeys(found))


def unsigned_status(status: str, verdict: str | None) -> str:
    """Return the status of a set that nobody signed: not usable, an approved rig does not make it approved."""
    return "engineering" if verdict == NOT_USABLE else status


def standing_in_words(status: str, verdict: str | None, accepted: AcceptedVerdict | None) -> str:
    """Return a status as every text has it: an approval over the verdict ``not usable`` tells who answers for it."""
    if status != "approved" or verdict != NOT_USABLE:
        return status
    by = "nobody" if accepted is None else f"{accepted.name}: {accepted.reason}"
    return f"approved though not usable, accepted by {by}"
