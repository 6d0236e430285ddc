"""The significant findings that a set states, each with a name by which a person can accept it."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, cast

from ams.finding_kinds import FindingKind
from ams.findings import Finding
from ams.sets.canonical import Document, listed, number, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.findings_by_axis import findings_by_axis

LACKING = "missing for a calibration when the run began: "
"""What such a warning of a set begins with: no signature supplies what stands behind it."""
TABLE_NOT_COUNTED = "the table's own index errors are not in these uncertainties"
RATES_NOT_COUNTED = "the rate table's own errors are not in these uncertainties"
LEVELS_NOT_COUNTED = "what the known levels themselves are wrong by is not in these uncertainties"
DAY_NOT_KNOWN = "the day on which the readings were taken is not known"
"""How the remark of a set begins that has the day of fitting instead."""
NO_CERTIFICATE_WITH = (LACKING, TABLE_NOT_COUNTED, RATES_NOT_COUNTED, LEVELS_NOT_COUNTED)
"""Beginnings of warnings of a set that are gaps of a certificate."""


_NO_DETAILS: Final = frozenset(
    {"kind", "text", "fact", "what_to_do", "significant", "p_value", "steps", "stated_uncertainties"}
)


@dataclass(frozen=True)
class StatedFinding:
    """One significant finding of one axis, as the set has it."""

    name: str
    """``x.cubic``; of several of a kind on an axis the second is ``x.wrong-dwell.2``. The set's bytes fix it."""
    axis: str
    text: str
    fact: str
    """What the text says of the item; of a set that does not know its parts, all of it."""


_OUTSIDE: Final = "not in the uncertainty"
"""In the words of a remark: what it names widens no interval."""


def significant_findings(coefficients: CoefficientSet) -> Iterator[StatedFinding]:
    """Yield every significant finding of a set, axis by axis; sets of before version 3 have none."""
    seen: Counter[tuple[str, str]] = Counter()
    for axis, finding in findings_by_axis(coefficients.document):
        if finding["significant"]:
            kind = str(finding["kind"])
            seen[axis, kind] += 1
            suffix = f".{seen[axis, kind]}" if seen[axis, kind] > 1 else ""
            yield StatedFinding(f"{axis}.{kind}{suffix}", axis, str(finding["text"]), _fact(finding))


def fact_of(document: Document, text: str) -> str:
    """Return what a text of a set's document says of the item: of a finding its fact, any other as it is."""
    return next((_fact(finding) for _, finding in findings_by_axis(document) if finding["text"] == text), text)


def _fact(finding: Document) -> str:
    return str(finding.get("fact", finding["text"]))


def findings_of_set(coefficients: CoefficientSet) -> Iterator[Finding]:
    """Yield every finding of every axis of a set as the test that made it had it; steps in doubt are left out."""
    for _, stated in findings_by_axis(coefficients.document):
        p_value = stated.get("p_value")
        yield Finding(
            cast(FindingKind, str(stated["kind"])),
            _fact(stated),
            bool(stated["significant"]),
            None if p_value is None else number(p_value),
            details={
                name: value if isinstance(value, str) else number(value)
                for name, value in stated.items()
                if name not in _NO_DETAILS and isinstance(value, (str, int, float))
            },
            is_held="stated_uncertainties" not in stated,
            what_to_do=str(stated.get("what_to_do", "")),
        )


def package_reservations(document: Document) -> Iterator[str]:
    """Yield what must be read before the package of a set's document is used; remarks are none of it."""
    remarks = listed(document.get("remarks", []))
    yield from (str(text) for text in listed(document["warnings"]) if text not in remarks)


def outside_uncertainty(document: Document) -> Iterator[str]:
    """Yield the remarks of a set's document that say what its points do not determine and its uncertainties lack."""
    yield from (str(text) for text in listed(document.get("remarks", [])) if _OUTSIDE in str(text))


def is_stated(document: Document, *beginnings: str) -> bool:
    """Return whether a warning or a remark of a set's document begins with one of these words."""
    texts = [*listed(document["warnings"]), *listed(document.get("remarks", []))]
    return any(str(text).startswith(beginnings) for text in texts)


def axis_reservations(document: Document) -> Iterator[tuple[str, str]]:
    """Yield axis and sentence of what must be read before a single axis is used and is not said of the package."""
    said = [*listed(document["warnings"]), *listed(document.get("remarks", []))]
    for axis, section in table(document["axes"]).items():
        for text in listed(table(section).get("warnings", [])):
            if text not in said:
                yield axis, str(text)
