"""Where a set stands: who signed it, what was accepted and released, and which certificates were issued."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from ams.sets.signature import Signature
from ams.sets.stated_findings import StatedFinding
from ams.sets.stated_verdict import NOT_USABLE, AcceptedVerdict, Withdrawal, standing_in_words

Role = Literal["prepared", "reviewed", "approved", "withdrawn"]
ORDER: tuple[Role, ...] = ("prepared", "reviewed", "approved")


@dataclass(frozen=True)
class AcceptedFinding:
    """One person's word that a significant finding, or the verdict, does not forbid the use of the set, and why."""

    finding: str
    """Its name, as ``x.cubic``; ``not usable`` of the verdict."""
    name: str
    accepted_utc: datetime
    reason: str


@dataclass(frozen=True)
class Release:
    """One person's word that a set in quarantine may be used, and why."""

    name: str
    released_utc: datetime
    reason: str


@dataclass(frozen=True)
class Certificate:
    """A certificate that was issued on a set."""

    number: str
    sha256: str
    """Of the set."""
    file_sha256: str
    issued_by: str
    issued_utc: datetime
    amends: str | None
    """Number of the certificate that this one takes the place of."""
    reason: str
    """Why it amends; empty for a first issue."""


@dataclass(frozen=True)
class SignOff:
    """Where a set stands."""

    sha256: str
    signatures: tuple[Signature, ...]
    certificates: tuple[Certificate, ...]
    findings: tuple[StatedFinding, ...] = ()
    """The significant ones of the set."""
    acceptances: tuple[AcceptedFinding, ...] = ()
    quarantine: str | None = None
    """Why the set was put into quarantine; None where it never was."""
    release: Release | None = None
    verdict: str | None = None
    """``sound``, ``usable`` or ``not usable``; None where the set tells none."""
    accepted_verdict: AcceptedFinding | None = None
    """Who accepted that the calibration is not usable."""

    @property
    def is_verdict_open(self) -> bool:
        """Whether the calibration is not usable and nobody has accepted that."""
        return self.verdict == NOT_USABLE and self.accepted_verdict is None

    @property
    def standing(self) -> str:
        """The state in words: by whom it was withdrawn and why, or who accepted an approval over not usable."""
        if self.withdrawal is not None:
            return str(self.withdrawal)
        word = self.accepted_verdict
        return standing_in_words(
            self.state, self.verdict, None if word is None else AcceptedVerdict(word.name, word.reason)
        )

    @property
    def unaccepted(self) -> tuple[StatedFinding, ...]:
        """The significant findings that nobody has accepted."""
        accepted = {acceptance.finding for acceptance in self.acceptances}
        return tuple(finding for finding in self.findings if finding.name not in accepted)

    @property
    def is_in_quarantine(self) -> bool:
        return self.quarantine is not None and self.release is None

    @property
    def state(self) -> str:
        """``unsigned``, ``prepared``, ``reviewed``, ``approved`` or ``withdrawn``."""
        return self.signatures[-1].role if self.signatures else "unsigned"

    @property
    def approver_reviewed(self) -> bool:
        """Whether one person reviewed and approved."""
        reviewed, approved = self.by("reviewed"), self.by("approved")
        return reviewed is not None and approved is not None and is_same_person(reviewed.name, approved.name)

    @property
    def withdrawal(self) -> Withdrawal | None:
        """By whom, when and why the set was withdrawn; None where it was not."""
        word = self.by("withdrawn")
        return None if word is None else Withdrawal(word.name, word.signed_utc, word.comment)

    @property
    def is_approved(self) -> bool:
        return self.state == "approved"

    def by(self, role: Role) -> Signature | None:
        """Return the signature in a role, None where nobody signed."""
        return next((signature for signature in self.signatures if signature.role == role), None)


def is_same_person(first: str, second: str) -> bool:
    """Return whether two names are one person's, without regard to case and spaces."""
    return " ".join(first.casefold().split()) == " ".join(second.casefold().split())
