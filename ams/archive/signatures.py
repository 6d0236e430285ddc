"""Who stands behind a set: prepared, reviewed, approved, by name and in this order; certificates only after approval.

Four eyes: whoever prepared a set neither reviews nor approves it; who reviewed it may approve it, since ISO/IEC 17025
(7.8.1.1) asks for a review and an authorisation, and not for a third person. Where one did both, that is told. A
signature is a row of its own and is never taken back; a set that must not be used any more is *withdrawn*, by name and
with a reason, and stays withdrawn. Names are compared without regard to case and spaces. What showed that it is that
person (``identified_by``) is the caller's: the command asks for a secret, and the record tells that it did.

A significant finding of a set is *accepted*, and a quarantine *released*, by name and with a reason, after the set was
prepared and by somebody else than who prepared it. Nothing is approved that holds a finding which nobody accepted, or
that is in quarantine. These are signatures too: an acceptance's comment is the finding's name, a colon and the reason.

A set whose calibration has the verdict *not usable* is approved only after that verdict itself was accepted, by this
name: whoever accepted finding after finding has not said that the set may be used.
"""

import unicodedata
from collections.abc import Sequence
from datetime import datetime
from typing import get_args

from sqlalchemy import Connection, func, not_, select

from ams.archive.approvals import ACCEPTED, OF_WHAT, RELEASED, is_withdrawn, words_on
from ams.archive.connection import reading, writing
from ams.archive.ledger import ChainReport, Written, verify_chain, write
from ams.archive.quarantines import is_quarantined
from ams.archive.sets import BUSY_TIMEOUT_S, find_set, stored_set
from ams.archive.sign_offs import (
    ORDER,
    AcceptedFinding,
    Certificate,
    Release,
    Role,
    SignOff,
    is_same_person,
)
from ams.archive.tables import CERTIFICATES, FUNCTIONS, QUARANTINES, SETS, SIGNATURES
from ams.errors import ArchiveForbids, ArchiveUnknown
from ams.sets.coefficients import CoefficientSet
from ams.sets.signature import Signature
from ams.sets.stated_findings import significant_findings
from ams.sets.stated_verdict import NOBODY_ACCEPTED, NOT_USABLE

_MOST_BESIDE = 3


def sign(
    archive_url: str,
    key: str,
    role: str,
    name: str,
    signed_utc: datetime,
    comment: str = "",
    busy_timeout_s: float = BUSY_TIMEOUT_S,
    *,
    function: str = "",
    identified_by: str = "",
) -> SignOff:
    """Sign a set (by sensor: its latest, or by checksum) in a role.

    ``function``: of the person in the laboratory, as certificates have it beside the name. ``identified_by``: what
    showed that it is that person, for the record.

    Raises: ArchiveError where the order, the four eyes or the archive do not allow it; nothing is written then.
    """
    wanted = _role(role)
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        sha256 = find_set(connection, key)
        signed = _sign_off(connection, sha256)
        _check_turn(signed, wanted, name, comment)
        _check_legible(f"set {sha256[:12]}: {wanted}", "function", function)
        signature = Signature(wanted, name.strip(), signed_utc, comment, function.strip())
        _insert(connection, sha256, signature, "signature", identified_by)
        return _sign_off(connection, sha256)


def accept(
    archive_url: str,
    key: str,
    finding: str,
    name: str,
    accepted_utc: datetime,
    reason: str,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
    *,
    identified_by: str = "",
) -> SignOff:
    """Accept a significant finding of a set by its name (``x.cubic``), or its verdict ``not usable``, with a reason.

    Raises: ArchiveError where the name, the reason or the finding is missing, the set is not prepared or withdrawn, or
    who accepts prepared it; nothing is written then.
    """
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        sha256 = find_set(connection, key)
        signed = _sign_off(connection, sha256)
        where = f"set {signed.sha256[:12]}: accept {finding}"
        before = _acceptance_of(signed, finding, where)
        if before is not None:
            raise ArchiveForbids(f"{where}: {before.name} accepted it already; nothing was signed")
        _check_word(signed, where, name, reason)
        comment = f"{finding}{OF_WHAT}{reason.strip()}"
        _insert(
            connection, sha256, Signature(ACCEPTED, name.strip(), accepted_utc, comment), "acceptance", identified_by
        )
        return _sign_off(connection, sha256)


def release(
    archive_url: str,
    key: str,
    name: str,
    released_utc: datetime,
    reason: str,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
    *,
    identified_by: str = "",
) -> SignOff:
    """Release a set from quarantine; ``key`` is its checksum, for a set in quarantine is no sensor's latest.

    Raises: ArchiveError where the name or the reason is missing, or the set is not in quarantine, not prepared, or
    prepared by who releases it; nothing is written then.
    """
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        sha256 = find_set(connection, key)
        signed = _sign_off(connection, sha256)
        where = f"set {sha256[:12]}: release"
        if signed.quarantine is None:
            raise ArchiveForbids(f"{where}: the set is not in quarantine; nothing was signed")
        if signed.release is not None:
            raise ArchiveForbids(f"{where}: {signed.release.name} released it already; nothing was signed")
        _check_word(signed, where, name, reason)
        _insert(
            connection,
            sha256,
            Signature(RELEASED, name.strip(), released_utc, reason.strip()),
            "release",
            identified_by,
        )
        return _sign_off(connection, sha256)


def set_to_use(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> CoefficientSet:
    """Return a set that leaves the archive to be used, by sensor (its latest) or checksum.

    Raises: ArchiveForbids where it was withdrawn, by whatever key it is meant; ArchiveError, SetError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        sha256 = find_set(connection, key)
        found, withdrawal = stored_set(connection, sha256), _sign_off(connection, sha256).withdrawal
        others = _sets_beside(connection, found) if withdrawal is not None else ()
    if withdrawal is None:
        return found
    known = f"use another set of it by its checksum ({', '.join(others)}), or calibrate" if others else "calibrate"
    raise ArchiveForbids(
        f"archive: set {sha256[:12]} of {found.sensor} is {withdrawal}; it is not for use and nothing was written; "
        f"{known} again; calrig archive show {sha256[:12]} tells all of it"
    )


def _sets_beside(connection: Connection, found: CoefficientSet) -> tuple[str, ...]:
    """Return the newest other sets of a sensor that may be used, as checksum and day, the newest first."""
    query = select(SETS.c.sha256, SETS.c.created_utc).where(
        SETS.c.sensor == found.sensor, SETS.c.simulated == found.is_simulated,
        not_(is_withdrawn(SETS.c.sha256)), not_(is_quarantined(SETS.c.sha256)),
    )  # fmt: skip
    rows = connection.execute(query.order_by(SETS.c.created_utc.desc()).limit(_MOST_BESIDE))
    return tuple(f"{sha256[:12]} of {created_utc:%Y-%m-%d}" for sha256, created_utc in rows)


def sign_off(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> SignOff:
    """Return the signatures and certificates of a set. Raises: ArchiveError."""
    with reading(archive_url, busy_timeout_s) as connection:
        return _sign_off(connection, find_set(connection, key))


def issue_certificate(
    archive_url: str, key: str, certificate: Certificate, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> SignOff:
    """Record a certificate of an approved set; ``certificate.sha256`` may be empty, it is taken from the set.

    The same certificate (number and file) again changes nothing.

    Raises: ArchiveError where the set is not approved, the number is taken by another file, or what it amends is not
    there.
    """
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        sha256 = find_set(connection, key)
        signed = _sign_off(connection, sha256)
        there = _certificate(connection, certificate.number)
        if there is not None and (there.sha256, there.file_sha256) == (sha256, certificate.file_sha256):
            return signed
        _check_issue(signed, certificate, there)
        if certificate.amends is not None and _certificate(connection, certificate.amends) is None:
            raise ArchiveUnknown(
                f"certificate {certificate.number}: amends {certificate.amends}, which is not in the archive; nothing "
                "was issued; give the number of a certificate that was issued"
            )
        row = {**vars(certificate), "sha256": sha256}
        detail = {"by": certificate.issued_by}
        write(connection, certificate.issued_utc, "certificate", [Written(CERTIFICATES, [row])], {**detail})
        return _sign_off(connection, sha256)


def certificate_of(archive_url: str, number: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> Certificate | None:
    """Return a certificate by its number; None where there is none. Raises: ArchiveError."""
    with reading(archive_url, busy_timeout_s) as connection:
        return _certificate(connection, number)


def verify_archive(archive_url: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> ChainReport:
    """Recompute the chain and every row under it. Raises: ArchiveError where the archive cannot be read."""
    with reading(archive_url, busy_timeout_s) as connection:
        return verify_chain(connection)


def _role(role: str) -> Role:
    found: Role | None = next((known for known in get_args(Role) if known == role), None)
    if found is None:
        raise ArchiveUnknown(
            f"role: got {role!r}, allowed are {', '.join(get_args(Role))}; nothing was signed; name one of them"
        )
    return found


def _check_turn(signed: SignOff, role: Role, name: str, comment: str) -> None:
    where = f"set {signed.sha256[:12]}: {role}"
    _check_legible(where, "name", name)
    _check_legible(where, "comment", comment)
    if not name.strip():
        raise ArchiveForbids(f"{where}: needs a name: got {name!r}; nothing was signed")
    if signed.state == "withdrawn":
        raise ArchiveForbids(f"{where}: the set is withdrawn; nothing was signed; calibrate again")
    if role == "withdrawn":
        if not comment.strip():
            raise ArchiveForbids(f"{where}: needs a reason; nothing was signed; say why")
        return
    expected = ORDER[len(signed.signatures)] if len(signed.signatures) < len(ORDER) else None
    if role != expected:
        next_step = "it is approved already" if expected is None else f"{expected} comes next"
        raise ArchiveForbids(f"{where}: is not its turn: the set is {signed.state}, {next_step}; nothing was signed")
    _check_four_eyes(signed, where, name)
    if role == "approved":
        _check_nothing_open(signed, where)


def _check_four_eyes(signed: SignOff, where: str, name: str) -> None:
    first = signed.by("prepared")
    if first is not None and is_same_person(first.name, name):
        raise ArchiveForbids(
            f"{where}: {name.strip()} prepared this set; nothing was signed; somebody else must do it (four eyes)"
        )


def _check_nothing_open(signed: SignOff, where: str) -> None:
    if signed.is_in_quarantine:
        raise ArchiveForbids(
            f"{where}: the set is in quarantine ({signed.quarantine}); nothing was signed; calibrate again, or have it "
            "released (calrig archive release)"
        )
    if signed.unaccepted:
        raise ArchiveForbids(
            f"{where}: nobody has accepted {', '.join(finding.name for finding in signed.unaccepted)}; "
            "nothing was signed; have each of them accepted with a reason (calrig archive accept)"
        )
    if signed.is_verdict_open:
        raise ArchiveForbids(f"{where}: {NOBODY_ACCEPTED}; nothing was signed; {how_to_close(signed)}")


def how_to_close(signed: SignOff) -> str:
    """Say what there is to do about a verdict that is not usable and that nobody has accepted."""
    return (
        f"calibrate again, or have the verdict accepted by name, with a reason (calrig archive accept "
        f"{signed.sha256[:12]} '{NOT_USABLE}')"
    )


def _acceptance_of(signed: SignOff, finding: str, where: str) -> AcceptedFinding | None:
    """Return who accepted a finding, or the verdict, before. Raises: ArchiveUnknown where the set has no such thing."""
    if finding == NOT_USABLE:
        if signed.verdict != NOT_USABLE:
            said = "it tells no verdict" if signed.verdict is None else f"its verdict is {signed.verdict}"
            raise ArchiveUnknown(f"{where}: the calibration of the set is not that: {said}; nothing was signed")
        return signed.accepted_verdict
    names = [found.name for found in signed.findings]
    if finding not in names:
        known = f"its significant findings are {', '.join(names)}" if names else "it has no significant finding"
        verdict = f", and its verdict is '{NOT_USABLE}'" if signed.verdict == NOT_USABLE else ""
        raise ArchiveUnknown(f"{where}: the set has no such finding: {known}{verdict}; nothing was signed")
    return next((acceptance for acceptance in signed.acceptances if acceptance.finding == finding), None)


def _check_word(signed: SignOff, where: str, name: str, reason: str) -> None:
    """Check that a person may give a reason for this set. Raises: ArchiveForbids."""
    _check_legible(where, "name", name)
    _check_legible(where, "reason", reason)
    if not name.strip():
        raise ArchiveForbids(f"{where}: needs a name: got {name!r}; nothing was signed; say who answers for it")
    if not reason.strip():
        raise ArchiveForbids(f"{where}: needs a reason; nothing was signed; say why")
    if signed.state == "withdrawn":
        raise ArchiveForbids(f"{where}: the set is withdrawn; nothing was signed; calibrate again")
    if signed.by("prepared") is None:
        raise ArchiveForbids(
            f"{where}: nobody has prepared the set; nothing was signed; have it signed as prepared first, by somebody "
            "else (four eyes)"
        )
    _check_four_eyes(signed, where, name)


def _check_legible(where: str, what: str, text: str) -> None:
    """Check that what a person says is one line that every page shows as it is. Raises: ArchiveForbids."""
    hidden = next((letter for letter in text if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp")), None)
    if hidden is not None:
        raise ArchiveForbids(
            f"{where}: the {what} holds U+{ord(hidden):04X}, which nobody sees: got {text!r}, allowed is one line of "
            "letters; nothing was signed; leave it out"
        )


def _check_issue(signed: SignOff, certificate: Certificate, there: Certificate | None) -> None:
    if not certificate.number.strip() or not certificate.issued_by.strip():
        raise ArchiveForbids("certificate: needs a number and the name of who issues it; nothing was issued")
    if not signed.is_approved:
        raise ArchiveForbids(
            f"certificate {certificate.number}: the set {signed.sha256[:12]} is {signed.state}, needed is approved; "
            "nothing was issued; have it signed first"
        )
    if signed.is_verdict_open:
        raise ArchiveForbids(
            f"certificate {certificate.number}: {NOBODY_ACCEPTED}; nothing was issued; {how_to_close(signed)}"
        )
    if there is not None:
        raise ArchiveForbids(
            f"certificate {certificate.number}: is issued already (set {there.sha256[:12]}, file "
            f"{there.file_sha256[:12]}); nothing was issued; an amended certificate needs a number of its own"
        )
    if certificate.amends is not None and not certificate.reason.strip():
        raise ArchiveForbids(
            f"certificate {certificate.number}: amends {certificate.amends} and gives no reason; nothing was issued"
        )


def next_signature(connection: Connection) -> int:
    """Return the number of the next signature, inside a write transaction."""
    return int(connection.execute(select(func.coalesce(func.max(SIGNATURES.c.sequence), 0))).scalar_one()) + 1


def _insert(connection: Connection, sha256: str, signature: Signature, kind: str, identified_by: str) -> None:
    sequence = next_signature(connection)
    columns = {name: value for name, value in vars(signature).items() if name != "function"}
    written = [Written(SIGNATURES, [{"sequence": sequence, "sha256": sha256, **columns}])]
    if signature.function:
        written.append(Written(FUNCTIONS, [{"sequence": sequence, "function": signature.function}]))
    detail = {"by": signature.name} | ({"identified_by": identified_by} if identified_by else {})
    write(connection, signature.signed_utc, kind, written, detail)


def _sign_off(connection: Connection, sha256: str) -> SignOff:
    issued = select(*_certificate_columns()).where(CERTIFICATES.c.sha256 == sha256).order_by(CERTIFICATES.c.issued_utc)
    rows = words_on(connection, sha256)
    certificates: Sequence[Certificate] = [Certificate(*tuple(row)) for row in connection.execute(issued)]
    words = tuple(_acceptance(row) for row in rows if row.role == ACCEPTED)
    coefficients = stored_set(connection, sha256)
    return SignOff(
        sha256,
        coefficients.signatures,
        tuple(certificates),
        tuple(significant_findings(coefficients)),
        tuple(word for word in words if word.finding != NOT_USABLE),
        connection.execute(select(QUARANTINES.c.reason).where(QUARANTINES.c.sha256 == sha256)).scalar(),
        next((Release(row.name, row.signed_utc, row.comment) for row in rows if row.role == RELEASED), None),
        coefficients.verdict,
        next((word for word in words if word.finding == NOT_USABLE), None),
    )


def _acceptance(row: Signature) -> AcceptedFinding:
    finding, _, reason = row.comment.partition(OF_WHAT)
    return AcceptedFinding(finding, row.name, row.signed_utc, reason)


def _certificate(connection: Connection, number: str) -> Certificate | None:
    row = connection.execute(select(*_certificate_columns()).where(CERTIFICATES.c.number == number)).first()
    return None if row is None else Certificate(*tuple(row))


def _certificate_columns() -> list:  # type: ignore[type-arg]

    return [CERTIFICATES.c[name] for name in Certificate.__dataclass_fields__]
