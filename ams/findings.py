"""What the data contradict: one value for every finding, from the test that makes it to the page that prints it.

A finding names a *cause* from a closed list. A significant one is a reservation: it stands among the warnings of its
axis, in the coefficient set, on the certificate and in the verdict. One that is not significant tells what was tested
and stood.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

from ams.finding_kinds import UNUSABLE_AXIS, FindingKind

FITS_WITH: Final = "fits_with"
"""Of a finding's details: the signs of angles and outputs, or the order of angles, that the readings fit with. Nothing
says whether an angle or a channel is the other way round, so that there is a set, and a person judges the finding."""
DECLARED_SIZE: Final = "declared_sensitivity_"
"""Of a finding's details: the sensitivity that an axis is far from. Nothing says whether what is declared or what was
read is wrong, so that there is a set, and a person judges the finding."""
HOLDING_ARCSEC: Final = 3.0
"""A smaller rotation stops no night and quarantines no set: it is a finding. A good table's certificate allows 1″."""
UNLIKE_SIZE: Final = "sensitivity_of_others_"
"""Of a finding's details: the sensitivity of the other axes, which an axis is far from; a person judges it as well."""
SHOWN_BY: Final = "shown_by_visits"
"""Of a finding's details: between which visits or check sets all sensors show it too, where the dwells tell it."""
EXPLAINED_BY: Final = "explained_by"
"""Of a finding's details: what another finding tells that explains it, in words."""
ON_ONE_SIDE: Final = "all_dwells_on_one_side"
"""Of a finding's details, 1 where it is so."""
ALL_AFTER: Final = "all_dwells_after"
"""Of a finding's details, 1 where all dwells that count stand after it: nothing ties them to the declared zero."""


class Said(NamedTuple):
    """What is said of a test: the two parts of a finding's text."""

    fact: str
    what_to_do: str = ""

    @property
    def text(self) -> str:
        """Both as one text."""
        return "; ".join(part for part in self if part)


@dataclass(frozen=True)
class Finding:
    """One test of a belief, and what it says of the data."""

    kind: FindingKind
    fact: str
    """What the data show of the item: one or two sentences with the size in units a reader knows."""
    is_significant: bool
    """Among all tests of all axes of the run, where it comes from a test."""
    p_value: float | None = None
    """None where it is a statement of fact and no test."""
    steps: tuple[int, ...] = ()
    """The run's steps in doubt, where single dwells are."""
    details: Mapping[str, float | str | None] = field(default_factory=dict)
    """Further numbers by name, the unit in the name."""
    is_held: bool = True
    """False where offset, sensitivities or predictions hold some of it that their stated uncertainties do not."""
    what_to_do: str = field(default="", kw_only=True)
    """By the laboratory, commands and keys of its files included; empty where there is nothing to do."""

    @property
    def text(self) -> str:
        """Fact and way out as one text."""
        return Said(self.fact, self.what_to_do).text

    def adding(self, fact: str, what_to_do: str = "") -> "Finding":
        """Return the finding with more that the data show, and more to do about it."""
        return replace(self, fact=Said(self.fact, fact).text, what_to_do=Said(self.what_to_do, what_to_do).text)

    def to_document(self) -> dict[str, object]:
        """Return the JSON form of the contract: ``kind``, ``text``, ``significant`` and what else is known.

        ``text`` is whole; where there is something to do, ``fact`` and ``what_to_do`` are its parts.
        """
        return {
            "kind": self.kind,
            "text": self.text,
            **({"fact": self.fact, "what_to_do": self.what_to_do} if self.what_to_do else {}),
            "significant": self.is_significant,
            "p_value": self.p_value,
            **({"steps": list(self.steps)} if self.steps else {}),
            **({"stated_uncertainties": "exceeded"} if self.is_significant and not self.is_held else {}),
            **self.details,
        }


def significant_texts(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Return what somebody must read before the result is used, each with what to do."""
    return tuple(finding.text for finding in findings if finding.is_significant)


def significant_facts(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Return the same without what the laboratory does about it, as archive and customer keep it."""
    return tuple(finding.fact for finding in findings if finding.is_significant)


def beyond_the_stated(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the significant findings that the stated uncertainties do not hold: nothing is usable with those."""
    return tuple(finding for finding in findings if finding.is_significant and not finding.is_held)


def leaves_nothing(finding: Finding) -> bool:
    """Return whether there is no result to use of the axis of a finding, and no set."""
    return finding.kind in UNUSABLE_AXIS and finding.is_significant and not is_left_to_a_person(finding.details)


def is_left_to_a_person(details: Mapping[str, object]) -> bool:
    """Return whether there is a set in spite of a finding of an axis, which a person judges: by what it says."""
    return FITS_WITH in details or any(key.startswith((DECLARED_SIZE, UNLIKE_SIZE)) for key in details)


def turned_the_table(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the findings of a table, base or fixture that turned so far that nothing measured stands.

    What a change of a lone sensor or of the meter would look like as well is not among them, nor what dwells that count
    stand on one side of and are tied to the declared zero of the axes.
    """
    return tuple(
        finding for finding in findings if finding.is_significant and turns_away(finding.kind, finding.details)
    )


def withheld(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the findings for which an archive gives a set to nobody until a person releases it by name.

    The table turned, or lines of the run's record are lost that may have taken back what counts.
    """
    every = tuple(findings)
    lost = (finding for finding in beyond_the_stated(every) if finding.kind == "record-lost")
    return (*turned_the_table(every), *lost)


def turns_away(kind: str, details: Mapping[str, object]) -> bool:
    """Return whether a significant finding takes away what was measured, by its kind and what it says."""
    turned_arcsec = details.get("turned_arcsec")
    return (
        kind == "table-rotation"
        and not details.get("confounded_with")
        and not details.get(ON_ONE_SIDE)
        and isinstance(turned_arcsec, float | int)
        and turned_arcsec > HOLDING_ARCSEC
    )
