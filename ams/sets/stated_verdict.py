"""What a set states of its own calibration in one word, and what an approval over that word is called everywhere."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from itertools import product
from typing import Final

from ams.finding_kinds import UNUSABLE_AXIS
from ams.findings import is_left_to_a_person, turns_away
from ams.sets.canonical import Document, listed, table
from ams.sets.findings_by_axis import findings_by_axis
from ams.sets.verdict_conditions import verdict_conditions

NOT_USABLE: Final = "not usable"
"""The verdict over which nothing is approved unless a person accepts it by this name."""
NOBODY_ACCEPTED: Final = "nobody has accepted the verdict 'not usable' of the calibration"


@dataclass(frozen=True)
class AcceptedVerdict:
    """One person's word that a set may be used though its calibration is not usable, and why."""

    name: str
    reason: str


@dataclass(frozen=True)
class Withdrawal:
    """One person's word that a set must not be used any more, when it was given and why."""

    name: str
    withdrawn_utc: datetime
    reason: str

    def __str__(self) -> str:
        """Return ``withdrawn by A. Ray on 2026-03-05 (UTC): the mount was loose``."""
        return f"withdrawn by {self.name} on {self.withdrawn_utc:%Y-%m-%d} (UTC): {self.reason.strip().rstrip('.')}"


def stated_verdict(document: Document) -> str | None:
    """Return the verdict of a set's document; None where it tells none.

    Sets of before the key tell theirs by a finding that exceeds the stated uncertainties.
    """
    if "verdict" in document:
        return str(document["verdict"])
    return NOT_USABLE if _named(document, _exceeds) else None


def verdict_in_words(document: Document) -> str | None:
    """Return the verdict of a set or of a fit with its grounds, such as ``not usable: … (x: sensor-change)``.

    Of one that is usable with what the data show all the same (``y: wrong-dwell``), which the stated uncertainties
    hold. None where the document tells none.
    """
    verdict = stated_verdict(document)
    if verdict is None:
        return None
    if verdict == NOT_USABLE:
        grounds = grounds_in_words(document)
        return f"{verdict}: {grounds}" if grounds else verdict
    shown = _named(document, lambda _: True)
    said = "the warnings must be read first" if verdict == "usable" else "nothing speaks against it"
    said = f"the data show {shown}, which the stated uncertainties hold; {said}" if shown else said
    return f"{verdict}: {said}{conditions_in_words(document)}"


def conditions_in_words(document: Document) -> str:
    """Return what the verdict of a set or of a fit is without, as a verdict goes on; empty where nothing lacks."""
    sections = (document, *(table(section) for section in table(document.get("axes", {})).values()))
    names = product(sections, ("warnings", "remarks"))
    return verdict_conditions(str(text) for section, name in names for text in listed(section.get(name, [])))


def grounds_in_words(document: Document) -> str:
    """Return why a set or a fit is not usable, each ground with the significant findings that it rests on.

    Empty where the document tells none.
    """
    stated = {
        "there is no result to use of an axis": _named(document, _leaves_nothing),
        "the table, its base or the fixture turned or stood off while it was measured": _named(document, _turns_away),
        "the stated uncertainties do not hold what the data show": _named(
            document, lambda finding: _exceeds(finding) and not _turns_away(finding)
        ),
    }
    return "; ".join(f"{ground} ({found})" for ground, found in stated.items() if found)


def no_conformity(verdict: str | None, *, is_in_quarantine: bool, is_withdrawn: bool = False) -> str | None:
    """Return why no limit is judged of a sensor as left: its stated uncertainties do not hold; else None."""
    if is_withdrawn:
        return "the set is withdrawn"
    if verdict == NOT_USABLE:
        return "the calibration is not usable"
    return "the set was put in quarantine" if is_in_quarantine else None


def _exceeds(finding: Document) -> bool:
    return "stated_uncertainties" in finding


def _turns_away(finding: Document) -> bool:
    return turns_away(str(finding["kind"]), finding)


def _leaves_nothing(finding: Document) -> bool:
    return finding["kind"] in UNUSABLE_AXIS and not is_left_to_a_person(finding)


def _named(document: Document, is_meant: Callable[[Document], bool]) -> str:
    """Return the significant findings that are meant, each kind once with the axes that show it."""
    axes_of: dict[str, dict[str, None]] = {}
    for axis, finding in findings_by_axis(document):
        if finding["significant"] and is_meant(finding):
            axes_of.setdefault(str(finding["kind"]), {})[axis] = None
    return "; ".join(f"{', '.join(axes)}: {kind}" for kind, axes in axes_of.items())


def unsigned_status(status: str, verdict: str | None) -> str:
    """Return the status of a set that nobody signed: not usable, an approved rig does not make it approved."""
    return "engineering" if verdict == NOT_USABLE else status


def standing_in_words(status: str, verdict: str | None, accepted: AcceptedVerdict | None) -> str:
    """Return a status as every text has it: an approval over the verdict ``not usable`` tells who answers for it."""
    if status != "approved" or verdict != NOT_USABLE:
        return status
    by = "nobody" if accepted is None else f"{accepted.name}: {accepted.reason}"
    return f"approved though not usable, accepted by {by}"
