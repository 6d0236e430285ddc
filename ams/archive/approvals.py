"""Which sets the signatures approve: an approval after the fact counts as one that the rig file gave beforehand.

The set's bytes never change, so one that was calibrated as 'engineering' still holds that word; what the archive hands
out carries the name of who approved it since, and everything drawn from it says so.
"""

from sqlalchemy import Connection, Select, select

from ams.archive.tables import SIGNATURES


def withdrawn() -> Select[tuple[str]]:
    """Return the query of the checksums of sets that must not be used any more."""
    return select(SIGNATURES.c.sha256).where(SIGNATURES.c.role == "withdrawn")


def approved() -> Select[tuple[str]]:
    """Return the query of the checksums of sets that somebody approved and nobody withdrew."""
    signed = select(SIGNATURES.c.sha256).where(SIGNATURES.c.role == "approved")
    return signed.where(SIGNATURES.c.sha256.not_in(withdrawn()))


def approver_of(connection: Connection, sha256: str) -> str | None:
    """Return who approved a set by signature, None where nobody did or it was withdrawn since."""
    query = select(SIGNATURES.c.name).where(SIGNATURES.c.role == "approved", SIGNATURES.c.sha256 == sha256)
    return connection.execute(query.where(SIGNATURES.c.sha256.not_in(withdrawn()))).scalar()
