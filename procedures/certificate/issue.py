"""Issuing: check the grounds, set the pages, enter the certificate into the archive, write the files.

The archive comes first: it refuses a number that is taken before any file exists, and the same certificate issued again
(a disk that was full) is the same file and changes nothing there. A specimen leaves no trace in the archive.
"""

import hashlib
from dataclasses import dataclass
from datetime import UTC, datetime, time
from pathlib import Path

from ams.archive.runs import adjustment_of
from ams.archive.sets import show
from ams.archive.sign_offs import Certificate
from ams.archive.signatures import issue_certificate, sign_off
from ams.exports.dcc_administration import IssuedCertificate
from ams.whole_file import write_whole
from procedures.certificate.grounds import Amendment, Grounds, check_grounds
from procedures.certificate.page import certificate_page, certificate_paper
from procedures.delivery.deliver import attachments
from procedures.delivery.taken_back_sets import require_standing_dwells


@dataclass(frozen=True)
class Issued:
    """A certificate on the disk."""

    grounds: Grounds
    page: Path
    paper: Path
    sha256: str
    """Of the PDF, as the archive has it."""


def issue(archive_url: str, key: str, grounds_of: "GroundsOf", by: str, out: Path) -> Issued:
    """Write ``certificate-NUMBER.pdf`` and ``.html`` into a folder that exists, and enter it into the archive.

    ``key``: a sensor (its latest set) or the beginning of a checksum.

    Raises: RequestError for what is missing; ArchiveError where the archive refuses; WriteFailed.
    """
    grounds = grounds_of.complete(archive_url, key)
    check_grounds(grounds)
    page = certificate_page(grounds)
    paper = certificate_paper(grounds, page, attachments(grounds.coefficients, _issued(grounds)))
    sha256 = hashlib.sha256(paper).hexdigest()
    if not grounds.is_specimen:
        issue_certificate(archive_url, grounds.coefficients.sha256, _entry(grounds, sha256, by))
    stem = f"{'specimen' if grounds.is_specimen else 'certificate'}-{_safe(grounds.number)}"
    paths = out / f"{stem}.html", out / f"{stem}.pdf"
    write_whole(paths[0], page.encode("utf-8"))
    write_whole(paths[1], paper)
    return Issued(grounds, *paths, sha256)


@dataclass(frozen=True)
class GroundsOf:
    """What the person who issues says; the archive says the rest."""

    number: str
    issued: datetime
    amends: str | None = None
    reason: str = ""
    is_specimen: bool = False

    def complete(self, archive_url: str, key: str) -> Grounds:
        """Return the grounds with set, adjustment and signatures from the archive.

        Raises: RequestError where dwells of the set were taken back since; ArchiveError.
        """
        coefficients = show(archive_url, key)
        require_standing_dwells(archive_url, coefficients.sha256, "nothing was issued")
        return Grounds(
            number=self.number,
            issued=self.issued.astimezone(UTC).date(),
            coefficients=coefficients,
            adjustment=adjustment_of(archive_url, coefficients.sha256),
            signed=sign_off(archive_url, coefficients.sha256),
            amends=None if self.amends is None else Amendment(self.amends, self.reason),
            is_specimen=self.is_specimen,
        )


def _issued(grounds: Grounds) -> IssuedCertificate:
    """Return what the attached DCC says of the certificate."""
    amends = grounds.amends
    replaced, reason = (None, "") if amends is None else (amends.number, amends.reason)
    return IssuedCertificate(grounds.number, grounds.issued, replaced, reason, grounds.is_specimen)


def _entry(grounds: Grounds, sha256: str, by: str) -> Certificate:
    return Certificate(
        number=grounds.number,
        sha256=grounds.coefficients.sha256,
        file_sha256=sha256,
        issued_by=by,
        issued_utc=datetime.combine(grounds.issued, time(), tzinfo=UTC),
        amends=grounds.amends.number if grounds.amends else None,
        reason=grounds.amends.reason if grounds.amends else "",
    )


def _safe(number: str) -> str:
    """Return a laboratory's certificate number as part of a file name that any system takes."""
    return "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_.") else "-" for letter in number)
