"""Which sets the signatures approve: an approval after the fact counts as one that the rig file gave beforehand.

The set's bytes never change, so one that was calibrated as 'engineering' still holds that word; what the archive hands
out carries the name of who approved it since, and everything drawn from it says so.
"""

from sqlalchemy import Connection, Select, select

from ams.archive.tables import FUNCTIONS, SIGNATURES
from ams.sets.stated_verdict import NOT_USABLE, AcceptedVerdict, Withdrawal

ACCEPTED = "accepted"
"""The role of a signature whose comment is what was accepted, a colon and the reason."""
OF_WHAT = ": "
"""Between what was accepted (a finding's name, or the verdict) and the reason."""


WITHDRAWN = "withdrawn"
"""The role of a signature whose comment is why the set must not be used any more."""


def withdrawn() -> Select[tuple[str]]:
    """Return the query of the checksums of sets that must not be used any more."""
    return select(SIGNATURES.c.sha256).where(SIGNATURES.c.role == WITHDRAWN)


def withdrawals(connection: Connection, sha256: str | None = None) -> dict[str, Withdrawal]:
    """Return who withdrew a set, when and why, by the checksum of the set; of one set or all."""
    query = select(SIGNATURES.c.sha256, SIGNATURES.c.name, SIGNATURES.c.signed_utc, SIGNATURES.c.comment).where(
        SIGNATURES.c.role == WITHDRAWN, *([] if sha256 is None else [SIGNATURES.c.sha256 == sha256])
    )
    return {of: Withdrawal(name, utc, reason) for of, name, utc, reason in connection.execute(query)}


def approved() -> Select[tuple[str]]:
    """Return the query of the checksums of sets that somebody approved and nobody withdrew."""
    signed = select(SIGNATURES.c.sha256).where(SIGNATURES.c.role == "approved")
    return signed.where(SIGNATURES.c.sha256.not_in(withdrawn()))


def approver_of(connection: Connection, sha256: str) -> str | None:
    """Return who approved a set by signature, None where nobody did or it was withdrawn since."""
    query = select(SIGNATURES.c.name).where(SIGNATURES.c.role == "approved", SIGNATURES.c.sha256 == sha256)
    return connection.execute(query.where(SIGNATURES.c.sha256.not_in(withdrawn()))).scalar()


def function_of_approver(connection: Connection, sha256: str) -> str:
    """Return the function of who approved a set by signature, empty where nobody told it."""
    query = (
        select(FUNCTIONS.c.function)
        .join(SIGNATURES, SIGNATURES.c.sequence == FUNCTIONS.c.sequence)
        .where(SIGNATURES.c.role == "approved", SIGNATURES.c.sha256 == sha256)
    )
    return connection.execute(query).scalar() or ""


def accepted_verdicts(connection: Connection, sha256: str | None = None) -> dict[str, AcceptedVerdict]:
    """Return who accepted that a calibration is not usable, and why, by the checksum of the set; of one set or all."""
    query = select(SIGNATURES.c.sha256, SIGNATURES.c.name, SIGNATURES.c.comment).where(
        SIGNATURES.c.role == ACCEPTED,
        SIGNATURES.c.comment.startswith(f"{NOT_USABLE}{OF_WHAT}", autoescape=True),
        *([] if sha256 is None else [SIGNATURES.c.sha256 == sha256]),
    )
    return {
        of: AcceptedVerdict(name, comment.partition(OF_WHAT)[2])
        for of, name, comment in connection.execute(query.order_by(SIGNATURES.c.sequence.desc()))
    }
