"""The record of an archive: every row that is written is told by a record, every record holds the hash of the last.

A record is one transaction: when, what kind, by whom and why, and for each row its table, its key and the SHA-256 of
its values. So a row that was changed, added or taken away behind calrig's back shows, and so does a record that was.
What no chain can show by itself is that its end was cut off together with the rows it told: the head (the last
record's hash) is printed by ``calrig archive verify`` to be written down elsewhere, as on a certificate.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, date, datetime
from functools import partial
from typing import Any, TypeVar

from sqlalchemy import Connection, Table, and_, insert, select
from sqlalchemy.exc import SQLAlchemyError

from ams.archive.refusals import cause_of
from ams.archive.tables import COMING_AND_GOING, METADATA, RECORDS
from ams.sets.canonical import Json, canonical_bytes

BEGINNING = "0" * 64
ROWS_AT_ONCE = 500
_UNREADABLE = (SQLAlchemyError, ValueError, TypeError)
"""What a database, its driver or the conversion of a cell raises where a row cannot be read."""

Made = TypeVar("Made")


@dataclass(frozen=True)
class Written:
    """Rows of one table that a transaction wrote."""

    table: Table
    rows: Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Head:
    """The last record: how many there are, and the hash that stands for all of them."""

    sequence: int
    sha256: str


@dataclass(frozen=True)
class ChainReport:
    """What a verification found."""

    head: Head
    rows: int
    faults: tuple[str, ...]
    """One sentence each; empty where everything is as it was written."""


def write(
    connection: Connection, utc: datetime, kind: str, written: Sequence[Written], detail: Mapping[str, Json]
) -> Head:
    """Insert the rows, tables in the order given, and tell them in one record."""
    for part in written:
        if part.rows:
            connection.execute(insert(part.table), [dict(row) for row in part.rows])
    return tell(connection, utc, kind, written, detail)


def tell(
    connection: Connection, utc: datetime, kind: str, written: Sequence[Written], detail: Mapping[str, Json]
) -> Head:
    """Append one record of rows that are there already; return the new head."""
    # Read under the writers' lock, which begins with the transaction: two records after one would fork the chain.
    last = head(connection)
    rows: list[Json] = [list(_row_record(part.table, row)) for part in written for row in part.rows]
    text = canonical_bytes({**detail, "rows": rows}).decode("utf-8")
    record = {"sequence": last.sequence + 1, "utc": utc, "kind": kind, "detail": text, "previous": last.sha256}
    digest = _record_hash(record)
    connection.execute(insert(RECORDS).values({**record, "sha256": digest}))
    return Head(last.sequence + 1, digest)


def head(connection: Connection) -> Head:
    """Return the last record; before the first, sequence 0 and 64 zeros."""
    query = select(RECORDS.c.sequence, RECORDS.c.sha256).order_by(RECORDS.c.sequence.desc()).limit(1)
    found = connection.execute(query).first()
    return Head(0, BEGINNING) if found is None else Head(found.sequence, found.sha256)


def verify_chain(connection: Connection) -> ChainReport:
    """Recompute every record and every row; read the others too: a row that cannot be read is a fault."""
    recorded: dict[tuple[str, str], str] = {}
    faults = list(_record_faults(connection, recorded))
    rows = 0
    for table in METADATA.sorted_tables:
        if table is RECORDS:
            continue
        found, unreadable = _each_row(connection, table, partial(_row_record, table))
        rows += len(found)
        for name, key, digest in found:
            expected = recorded.pop((name, key), None)
            if expected is None:
                faults.append(f"{name} {key}: no record tells of this row: it was added behind the record")
            elif expected != digest:
                faults.append(f"{name} {key}: is not as it was written (SHA-256 differs)")
        faults += _unreadable_faults(table.name, unreadable)
        for key in unreadable:
            recorded.pop((table.name, key), None)
    for table in COMING_AND_GOING.sorted_tables:
        faults += _unreadable_faults(table.name, _each_row(connection, table, dict)[1])
    faults += [f"{name} {key}: was written and is not there any more" for name, key in recorded]
    return ChainReport(head(connection), rows, tuple(faults))


def _record_faults(connection: Connection, recorded: dict[tuple[str, str], str]) -> Iterator[str]:
    """Yield the faults of the records themselves; fill what they tell."""
    previous: str | None = BEGINNING
    expected = 1
    rows, unreadable = _each_row(connection, RECORDS, dict)
    yield from _unreadable_faults("record", unreadable)
    for record in rows:
        while str(expected) in unreadable:
            previous, expected = None, expected + 1
        if record["sequence"] != expected:
            yield f"record {expected}: is missing"
        if previous is not None and record["previous"] != previous and record["sequence"] == expected:
            yield f"record {record['sequence']}: does not follow the record before it"
        if _record_hash(record) != record["sha256"]:
            yield f"record {record['sequence']} ({record['kind']}): is not as it was written (SHA-256 differs)"
        with suppress(ValueError, TypeError, AttributeError):  # a text that is none: told by the hash
            recorded |= {(name, key): digest for name, key, digest in json.loads(record["detail"]).get("rows", [])}
        previous, expected = record["sha256"], record["sequence"] + 1


def _each_row(
    connection: Connection, table: Table, tell: Callable[[Mapping[str, Any]], Made]
) -> tuple[list[Made], dict[str, str]]:
    """Return what ``tell`` makes of every row, by key, and the keys of the rows that cannot be read, each with why.

    Where not even the keys can be read, the key is empty.
    """
    keys = list(table.primary_key)
    query = select(table).order_by(*keys)
    try:
        with connection.begin_nested():
            rows = connection.execute(query, execution_options={"yield_per": ROWS_AT_ONCE}).mappings()
            return [tell(dict(row)) for row in rows], {}
    except _UNREADABLE:
        pass
    made: list[Made] = []
    unreadable: dict[str, str] = {}
    try:
        with connection.begin_nested():
            found = connection.execute(select(*keys).order_by(*keys)).all()
    except _UNREADABLE as error:
        return [], {"": cause_of(error)}
    for values in found:
        this = and_(*(column == value for column, value in zip(keys, values, strict=True)))
        try:
            with connection.begin_nested():
                made.append(tell(dict(connection.execute(select(table).where(this)).mappings().one())))
        except _UNREADABLE as error:
            unreadable[" ".join(map(str, values))] = cause_of(error)
    return made, unreadable


def _unreadable_faults(name: str, unreadable: Mapping[str, str]) -> Iterator[str]:
    for key, why in unreadable.items():
        yield f"{f'{name} {key}'.rstrip()}: cannot be read ({why})"


def _row_record(table: Table, row: Mapping[str, Any]) -> tuple[str, str, str]:
    """Return table, key and hash of a row, as a record has them.

    Null is left out, so that a later schema may add columns.
    """
    key = " ".join(str(row[column.name]) for column in table.primary_key)
    values = {name: _plain(value) for name, value in row.items() if value is not None}
    return table.name, key, hashlib.sha256(canonical_bytes(values)).hexdigest()


def _record_hash(record: Mapping[str, Any]) -> str:
    parts: Iterable[str] = ("sequence", "utc", "kind", "detail", "previous")
    return hashlib.sha256(canonical_bytes({name: _plain(record[name]) for name in parts})).hexdigest()


def _plain(value: Any) -> Json:
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat()
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, bytes | memoryview):
        return bytes(value).hex()
    plain: Json = value
    return plain
