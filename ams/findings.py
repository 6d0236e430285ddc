"""What the data contradict: one value for every finding, from the test that makes it to the page that prints it.

A finding names a *cause* from a closed list. A significant one is a reservation: it stands among the warnings of its
axis, in the coefficient set, on the certificate and in the verdict. One that is not significant tells what was tested
and stood.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, get_args

FindingKind = Literal[
    "wrong-dwell",
    "lack-of-fit",
    "quadratic",
    "cubic",
    "asymmetry",
    "cross-coupling",
    "drift",
    "autocorrelation",
    "temperature-residual",
    "temperature-lag",
    "temperature-curvature",
    "table-rotation",
    "meter-gain",
    "meter-offset",
    "sensor-change",
    "level-undeclared",
    "time-confounded",
    "axis-undetermined",
]
"""``axis-undetermined``: the sensitivity of the nominal axis is not told from zero by the attitudes visited."""

FINDING_KINDS: Final[tuple[str, ...]] = get_args(FindingKind)


@dataclass(frozen=True)
class Finding:
    """One test of a belief, and what it says of the data."""

    kind: FindingKind
    text: str
    """One or two sentences with the size in units a reader knows, and what to do where there is something to do."""
    is_significant: bool
    """Among all tests of all axes of the run, where it comes from a test."""
    p_value: float | None = None
    """None where it is a statement of fact and no test."""
    steps: tuple[int, ...] = ()
    """The run's steps in doubt, where single dwells are."""
    details: Mapping[str, float | str | None] = field(default_factory=dict)
    """Further numbers by name, the unit in the name."""

    def to_document(self) -> dict[str, object]:
        """Return the JSON form of the contract: ``kind``, ``text``, ``significant`` and what else is known."""
        return {
            "kind": self.kind,
            "text": self.text,
            "significant": self.is_significant,
            "p_value": self.p_value,
            **({"steps": list(self.steps)} if self.steps else {}),
            **self.details,
        }


def significant_texts(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Return the sentences that somebody must read before the result is used."""
    return tuple(finding.text for finding in findings if finding.is_significant)
