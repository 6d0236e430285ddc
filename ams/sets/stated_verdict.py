"""What a set states of its own calibration in one word, and what an approval over that word is called everywhere."""

from dataclasses import dataclass
from typing import Final

from ams.sets.canonical import Document, listed, table

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
    exceeded = any(
        table(finding)["significant"] and "stated_uncertainties" in table(finding)
        for section in table(document["axes"]).values()
        for finding in listed(table(section).get("findings", []))
    )
    return NOT_USABLE if exceeded else None


def standing_in_words(status: str, verdict: str | None, accepted: AcceptedVerdict | None) -> str:
    """Return a status as every text has it: an approval over the verdict ``not usable`` tells who answers for it."""
    if status != "approved" or verdict != NOT_USABLE:
        return status
    by = "nobody" if accepted is None else f"{accepted.name}: {accepted.reason}"
    return f"approved though not usable, accepted by {by}"
