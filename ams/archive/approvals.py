"""Which sets the signatures approve: an approval after the fact counts as one that the rig file gave beforehand.

The set's bytes never change, so one that was calibrated as 'engineering' still holds that word; what the archive hands
out carries the name of who approved it since, and everything drawn from it says so.
"""

from collections.abc import Iterable

from sqlalchemy import ColumnElement, Connection, and_, exists, func, not_, select

from ams.archive.tables import FUNCTIONS, SIGNATURES
from ams.sets.signature import Signature
from ams.sets.stated_verdict import NOT_USABLE, AcceptedVerdict, Withdrawal

ACCEPTED = "accepted"
"""The role of a signature whose comment is what was accepted, a colon and the reason."""
OF_WHAT = ": "
"""Between what was accepted (a finding's name, or the verdict) and the reason."""
RELEASED = "released"
"""The role of a signature whose comment is why a set may be used that was in quarantine."""
WITHDRAWN = "withdrawn"
"""The role of a signature whose comment is why the set must not be used any more."""


def is_signed(sha256: ColumnElement[str], role: str) -> ColumnElement[bool]:
    """Return the condition that a set, by the column of its checksum, has a signature in a role.

    It is asked of each set by itself: a list of all that have one would be as long as the archive.
    """
    given = SIGNATURES.alias()
    return exists().where(given.c.sha256 == sha256, given.c.role == role)


def is_withdrawn(sha256: ColumnElement[str]) -> ColumnElement[bool]:
    """Return the condition that a set must not be used any more."""
    return is_signed(sha256, WITHDRAWN)


def withdrawals(connection: Connection, sha256: str | None = None) -> dict[str, Withdrawal]:
    """Return who withdrew a set, when and why, by the checksum of the set; of one set or all."""
    query = select(SIGNATURES.c.sha256, SIGNATURES.c.name, SIGNATURES.c.signed_utc, SIGNATURES.c.comment).where(
        SIGNATURES.c.role == WITHDRAWN, *([] if sha256 is None else [SIGNATURES.c.sha256 == sha256])
    )
    return {of: Withdrawal(name, utc, reason) for of, name, utc, reason in connection.execute(query)}


def is_approved(sha256: ColumnElement[str]) -> ColumnElement[bool]:
    """Return the condition that somebody approved a set and nobody withdrew it."""
    return and_(is_signed(sha256, "approved"), not_(is_withdrawn(sha256)))


def words_on(connection: Connection, sha256: str) -> tuple[Signature, ...]:
    """Return every word that a person signed on a set, acceptances and releases among them, in the order of signing."""
    columns = [SIGNATURES.c[name] for name in Signature.__dataclass_fields__ if name != "function"]
    query = (
        select(*columns, func.coalesce(FUNCTIONS.c.function, ""))
        .outerjoin(FUNCTIONS, FUNCTIONS.c.sequence == SIGNATURES.c.sequence)
        .where(SIGNATURES.c.sha256 == sha256)
        .order_by(SIGNATURES.c.sequence)
    )
    return tuple(Signature(*tuple(row)) for row in connection.execute(query))


def signatures_among(words: Iterable[Signature]) -> tuple[Signature, ...]:
    """Return of what was signed on a set the signatures on the set itself: not what was accepted or released of it."""
    return tuple(word for word in words if word.role not in (ACCEPTED, RELEASED))


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
