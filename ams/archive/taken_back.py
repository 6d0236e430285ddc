"""Sets of runs whose dwells were taken back after the sets were made: which rest on which journal, and their end.

The archive knows a run by the content of its journal, and does not read journals: who does says here that dwells of one
were taken back. That is a withdrawal like a person's, by the name of who took them back and with that reason: the
record tells that it was said to the journal, which asks for no secret.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, not_, select

from ams.archive.approvals import WITHDRAWN, is_withdrawn, withdrawals
from ams.archive.connection import reading, writing
from ams.archive.ledger import Written, write
from ams.archive.sets import BUSY_TIMEOUT_S, find_set
from ams.archive.signatures import next_signature
from ams.archive.tables import RUNS, SETS, SIGNATURES
from ams.sets.stated_verdict import Withdrawal

SAID_TO_A_JOURNAL = "the journal of the run, to which it was said"


@dataclass(frozen=True)
class SetOfRun:
    """A set that nobody withdrew, and the journal that it rests on."""

    sha256: str
    sensor: str
    run_id: str
    journal_sha256: str | None
    """Content of the journal when the set was made; None where it does not say."""
    folders: tuple[str, ...]
    """Where the run lay when it was published."""


def sets_of_run(archive_url: str, run_id: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> tuple[SetOfRun, ...]:
    """Return the sets of a run that nobody withdrew; an older archive is migrated. Raises: ArchiveError."""
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        return _standing(connection, SETS.c.run_id == run_id)


def set_of_run(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> SetOfRun | None:
    """Return the set of a sensor (its latest) or a checksum; None where it has no run or was withdrawn.

    Raises: ArchiveError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        found = _standing(connection, SETS.c.sha256 == find_set(connection, key))
    return found[0] if found else None


def later_set_of_run(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> tuple[str, str] | None:
    """Return a set and the one that takes its place, by checksum; None where none does.

    That is the last published of the same run and sensor that nobody withdrew. Raises: ArchiveError.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        sha256 = find_set(connection, key)
        columns = (SETS.c.run_id, SETS.c.sensor, SETS.c.published_utc)
        run_id, sensor, published_utc = connection.execute(select(*columns).where(SETS.c.sha256 == sha256)).one()
        later = select(SETS.c.sha256).where(
            SETS.c.run_id == run_id, SETS.c.sensor == sensor, SETS.c.published_utc > published_utc,
            not_(is_withdrawn(SETS.c.sha256)),
        )  # fmt: skip
        found: str | None = connection.execute(later.order_by(SETS.c.published_utc.desc()).limit(1)).scalar()
    return None if found is None else (sha256, found)


def latest_sets_before(
    archive_url: str,
    sensors: Iterable[str],
    run_id: str,
    *,
    is_simulated: bool,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> tuple[SetOfRun, ...]:
    """Return of each sensor the latest set that nobody withdrew and that is of another run, where there is one.

    An older archive is migrated, as by what is published next. Raises: ArchiveError.
    """
    other = (SETS.c.run_id != run_id, SETS.c.simulated == is_simulated)
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        found = [_standing(connection, SETS.c.sensor == sensor, *other, most=1) for sensor in sensors]
    return tuple(entry for entries in found for entry in entries)


def withdraw_for_run(
    archive_url: str, sets: Sequence[str], word: Withdrawal, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> None:
    """Withdraw those of the sets, by checksum, that nobody withdrew, all or none. Raises: ArchiveError."""
    with writing(archive_url, busy_timeout_s, only_existing=True) as connection:
        gone = withdrawals(connection)
        first = next_signature(connection)
        said = {"role": WITHDRAWN, "name": word.name, "signed_utc": word.withdrawn_utc, "comment": word.reason}
        left = (sha256 for sha256 in sets if sha256 not in gone)
        rows = [{"sequence": number, "sha256": sha256, **said} for number, sha256 in enumerate(left, start=first)]
        if rows:
            detail = {"by": word.name, "identified_by": SAID_TO_A_JOURNAL}
            write(connection, word.withdrawn_utc, "signature", [Written(SIGNATURES, rows)], detail)


def _standing(
    connection: Connection, *conditions: ColumnElement[bool], most: int | None = None
) -> tuple[SetOfRun, ...]:
    """Return the sets of runs that nobody withdrew, the latest first."""
    query = select(SETS.c.sha256, SETS.c.sensor, SETS.c.run_id, SETS.c.document).where(
        SETS.c.run_id.is_not(None), not_(is_withdrawn(SETS.c.sha256)), *conditions
    )
    rows = connection.execute(query.order_by(SETS.c.created_utc.desc(), SETS.c.published_utc.desc()).limit(most)).all()
    folders = select(RUNS.c.run_id, RUNS.c.folder).where(RUNS.c.run_id.in_({row.run_id for row in rows}))
    lain: dict[str, list[str]] = {}
    for run_id, folder in connection.execute(folders):
        lain.setdefault(run_id, []).append(folder)
    return tuple(
        SetOfRun(sha256, sensor, run_id, _journal_of(document), tuple(lain.get(run_id, ())))
        for sha256, sensor, run_id, document in rows
    )


def _journal_of(document: str) -> str | None:
    found: str | None = json.loads(document)["provenance"].get("journal_sha256")
    return found
