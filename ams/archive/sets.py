"""The archive: coefficient sets kept for years, in SQLite by default and in PostgreSQL for a laboratory.

A set is identified by its checksum. Publishing is idempotent and one transaction: every set is in, or none. What is
read back has passed the same checks as a set from a file. Where the archive is, the caller says. Runs with what was
found and left are published by :mod:`ams.archive.runs`; this file holds what is said of sets.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from datetime import date, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, case, false, not_, select

from ams.archive.approvals import (
    accepted_verdicts,
    is_approved,
    is_withdrawn,
    signatures_among,
    withdrawals,
    words_on,
)
from ams.archive.connection import reading, writing
from ams.archive.ledger import ROWS_AT_ONCE, Written, write
from ams.archive.quarantines import is_quarantined
from ams.archive.tables import ADJUSTMENTS, COEFFICIENTS, POINTS, QUARANTINES, SETS, VERDICTS, in_code_points
from ams.errors import ArchiveError, ArchiveUnknown, SetError
from ams.exports.json_text import from_json, parsed, to_json
from ams.sets.canonical import Document, listed, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.schema import check_identity
from ams.sets.stated_verdict import Withdrawal, no_conformity, standing_in_words, unsigned_status
from ams.sets.verdict_conditions import BEGINNINGS, verdict_conditions
from ams.surveillance.history_points import point_row

BUSY_TIMEOUT_S = 10.0
SHORTEST_KEY = 6
_HEX = re.compile(r"[0-9a-f]*")


@dataclass(frozen=True)
class ArchivedSet:
    """One set as a row of a list, in plain values."""

    sha256: str
    sensor: str
    serial: str | None
    model: str
    convention: str
    status: str
    """``engineering``, ``approved`` (by the rig file or by signatures since) or ``withdrawn``."""
    standing: str
    """The status in words: by whom it was withdrawn and why, or who accepted an approval over not usable."""
    verdict: str | None
    """Of the calibration: ``sound``, ``usable`` or ``not usable``; None where an earlier version tells none, and of a
    set that was withdrawn."""
    is_signed: bool
    """Approved by signature, as a certificate needs it; the rig file's ``approved_by`` is of rig and procedure."""
    simulated: bool
    run_id: str | None
    software_version: str
    created_utc: datetime
    published_utc: datetime
    rig: str
    as_found: str | None
    """Verdict; None where there was nothing to find or no limit, and by a set that was withdrawn."""
    as_left: str | None
    """Verdict; None where there is no limit, or none is judged: not usable, withdrawn, or in quarantine."""
    quarantine: str | None
    """Why it is in quarantine; None where it is not, or was released."""
    withdrawal: Withdrawal | None
    """Who withdrew it, when and why; None where nobody did."""


@dataclass(frozen=True)
class Publication:
    """What became of one set: new in the archive, or there before."""

    sha256: str
    sensor: str
    is_new: bool
    exchanged: str = ""
    """Why it is in quarantine where the sensor looks exchanged with another of its run; empty where it does not."""
    exchanged_before: str = ""
    """That the sensor looks exchanged in its set before, which counts, and not in this one; empty where it does not."""


@dataclass(frozen=True)
class Search:
    """What to list; a field that is None does not narrow it. Times are of the calibration."""

    sensor: str | None = None
    serial: str | None = None
    rig: str | None = None
    run_id: str | None = None
    since_utc: datetime | None = None
    until_utc: datetime | None = None
    """Not included."""


def publish(
    archive_url: str,
    sets: Sequence[CoefficientSet],
    published_utc: datetime,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> tuple[Publication, ...]:
    """Put the sets into the archive, all or none; a set that is there already is left as it is.

    Raises: ArchiveError where the archive cannot be written, or a standard of a measured set had expired when it was
    calibrated; VectorsDisagree for a set that contradicts itself; SetWithdrawn.
    """
    require_publishable(sets, published_utc)
    for coefficients in sets:
        _refuse_expired(coefficients)
    with writing(archive_url, busy_timeout_s) as connection:
        return insert_sets(connection, sets, published_utc, {})


def list_sets(
    archive_url: str,
    sensor: str | None = None,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
    search: Search | None = None,
) -> tuple[ArchivedSet, ...]:
    """Return the sets, by sensor, then oldest first. Raises: ArchiveError where the archive cannot be read."""
    from_other = {
        "rig": POINTS.c.rig,
        "as_found": ADJUSTMENTS.c.as_found,
        "as_left": ADJUSTMENTS.c.as_left,
        "quarantine": case((is_quarantined(SETS.c.sha256), QUARANTINES.c.reason)),
        "status": case(
            (is_withdrawn(SETS.c.sha256), "withdrawn"),
            (is_approved(SETS.c.sha256), "approved"),
            else_=SETS.c.status,
        ),
        "verdict": VERDICTS.c.verdict,
        "is_signed": case((is_approved(SETS.c.sha256), True), else_=False),
    }
    names = [field.name for field in fields(ArchivedSet) if field.name not in ("standing", "withdrawal")]
    listed = [from_other[name] if name in from_other else SETS.c[name] for name in names]
    wanted = [*_conditions(search or Search()), *([] if sensor is None else [SETS.c.sensor == sensor])]
    with reading(archive_url, busy_timeout_s) as connection:
        rows = [dict(zip(names, row, strict=True)) for row in connection.execute(_query(listed, wanted))]
        accepted, withdrawn_by = accepted_verdicts(connection), withdrawals(connection)
    for row in rows:
        word, row["withdrawal"] = accepted.get(row["sha256"]), withdrawn_by.get(row["sha256"])
        if row["withdrawal"] is not None:
            row |= {"standing": str(row["withdrawal"]), "verdict": None, "as_found": None, "as_left": None}
            continue
        if row["status"] == "approved" and not row["is_signed"]:
            row["status"] = unsigned_status(row["status"], row["verdict"])
        row["standing"] = standing_in_words(row["status"], row["verdict"], word)
        if no_conformity(row["verdict"], is_in_quarantine=row["quarantine"] is not None):
            row["as_left"] = None
    return tuple(ArchivedSet(**row) for row in rows)


def listed_conditions(archive_url: str, search: Search, busy_timeout_s: float = BUSY_TIMEOUT_S) -> dict[str, str]:
    """Return checksum to what the verdict of each set is without, as a verdict goes on; empty where nothing lacks.

    The stored texts are looked through and not parsed, which takes a tenth of the time: a remark stands in quotes.
    Raises: ArchiveError where the archive cannot be read.
    """
    quoted = {begins: json.dumps(begins, ensure_ascii=False)[:-1] for begins in BEGINNINGS}
    documents = _query([SETS.c.sha256, SETS.c.document], _conditions(search)).execution_options(yield_per=ROWS_AT_ONCE)
    with reading(archive_url, busy_timeout_s) as connection:
        return {
            sha256: verdict_conditions(begins for begins, text in quoted.items() if text in document)
            for sha256, document in connection.execute(documents)
        }


def show(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> CoefficientSet:
    """Return the set of a checksum (its first six or more characters), or the latest set of a sensor.

    Raises: ArchiveError where nothing or more than one checksum fits; SetError where the stored set is damaged.
    """
    with reading(archive_url, busy_timeout_s) as connection:
        return stored_set(connection, find_set(connection, key))


def find_set(connection: Connection, key: str) -> str:
    """Return the checksum that a key means: a sensor's latest set, or the one whose checksum begins so.

    A set in quarantine is nobody's latest.

    Raises: ArchiveUnknown where nothing or more than one fits.
    """
    sound = [SETS.c.sensor == key, not_(is_quarantined(SETS.c.sha256))]
    rows = connection.execute(_query([SETS.c.sha256], sound)).scalars().all()[-1:]
    if not rows and len(key) >= SHORTEST_KEY:
        begins, sha256 = key.lower(), in_code_points(connection, SETS.c.sha256)
        # A range, which the index answers; behind the digits of a checksum comes no g.
        within = [sha256 >= begins, sha256 < f"{begins}g"] if _HEX.fullmatch(begins) else [false()]
        rows = connection.execute(_query([SETS.c.sha256], within)).scalars().all()
    if len(rows) != 1:
        taken = connection.execute(_query([SETS.c.sha256], [SETS.c.sensor == key])).first() is not None
        found = ", ".join(sha256[:12] for sha256 in rows) or ("only sets in quarantine" if taken else "nothing")
        raise ArchiveUnknown(
            f"archive: no single set for {key!r}: found {found}, needed is a sensor's name or at least {SHORTEST_KEY} "
            "characters of a checksum that fit one set; list the sets and take one from there"
        )
    return str(rows[0])


def stored_set(connection: Connection, sha256: str) -> CoefficientSet:
    """Return a set by its whole checksum, every check of a file made.

    Raises: SetError where it is damaged or another's.
    """
    found = from_json(_stored(connection, sha256), _where(sha256))
    _refuse_another(found.document, sha256)
    return replace(
        found,
        signatures=signatures_among(words_on(connection, sha256)),
        accepted_verdict=accepted_verdicts(connection, sha256).get(sha256),
        withdrawal=withdrawals(connection, sha256).get(sha256),
    )


def stored_document(connection: Connection, sha256: str) -> Document:
    """Return the document of a set, its checksum held against its content and its shape believed.

    Raises: SetError where it is damaged or another's.
    """
    document = check_identity(parsed(_stored(connection, sha256), _where(sha256)), _where(sha256))
    _refuse_another(document, sha256)
    return document


def _stored(connection: Connection, sha256: str) -> bytes:
    document: str = connection.execute(select(SETS.c.document).where(SETS.c.sha256 == sha256)).scalar_one()
    return document.encode("utf-8")


def _where(sha256: str) -> str:
    return f"archive: set {sha256[:12]}"


def _refuse_another(document: Document, sha256: str) -> None:
    stated = str(table(document["checksum"])["sha256"])
    if stated != sha256:
        sensor = table(document["sensor"])["name"]
        raise SetError(
            f"{_where(sha256)}: holds another set, {stated[:12]} of {sensor}; the set is not used; "
            "calrig archive verify tells what was changed"
        )


def require_publishable(sets: Sequence[CoefficientSet], published_utc: datetime) -> None:
    """Refuse sets that cannot be published.

    Raises: ArchiveError for a time without its zone; VectorsDisagree for a set that contradicts itself; SetWithdrawn.
    """
    if published_utc.tzinfo is None:
        raise ArchiveError(
            f"archive: published_utc has no time zone: got {published_utc.isoformat()}; nothing was published; "
            "pass an aware time"
        )
    for coefficients in sets:
        coefficients.require_standing(f"{coefficients.sensor}: publish", "nothing was published")
        coefficients.check_vectors(f"{coefficients.sensor}: publish")


def _refuse_expired(coefficients: CoefficientSet) -> None:
    """Refuse a measured set whose standards were overdue on its day. Raises: ArchiveError."""
    day = coefficients.created_utc.astimezone().date()  # a certificate's due day is one at the wall
    standards = [table(entry) for entry in listed(coefficients.provenance["standards"])]
    overdue = [entry for entry in standards if entry["due"] and date.fromisoformat(str(entry["due"])) < day]
    if overdue and not coefficients.is_simulated:
        named = ", ".join(
            f"{entry['name']} ({entry['certificate'] or 'no certificate'}, due {entry['due']})" for entry in overdue
        )
        raise ArchiveError(
            f"{coefficients.sensor}: standards had expired when it was calibrated on {day}: {named}; nothing was "
            "published; have them calibrated and measure again"
        )


def insert_sets(
    connection: Connection,
    sets: Sequence[CoefficientSet],
    published_utc: datetime,
    check_sensors: Mapping[str, bool],
) -> tuple[Publication, ...]:
    """Insert the sets that are new and tell them in one record, inside a write transaction."""
    new: dict[str, CoefficientSet] = {}
    publications = []
    for coefficients in sets:
        is_new = coefficients.sha256 not in new and not _is_there(connection, coefficients.sha256)
        publications.append(Publication(coefficients.sha256, coefficients.sensor, is_new))
        if is_new:
            new[coefficients.sha256] = coefficients
    if new:
        points = [point_row(entry, is_check=check_sensors.get(entry.sensor, False)) for entry in new.values()]
        written = [
            Written(SETS, [_set_row(entry, published_utc) for entry in new.values()]),
            Written(COEFFICIENTS, [row for entry in new.values() for row in _coefficient_rows(entry)]),
            Written(POINTS, points),
            Written(VERDICTS, [_verdict_row(entry) for entry in new.values() if entry.verdict is not None]),
        ]
        write(connection, published_utc, "sets", written, {})
    return tuple(publications)


def _is_there(connection: Connection, sha256: str) -> bool:
    return connection.execute(select(SETS.c.sha256).where(SETS.c.sha256 == sha256)).first() is not None


def _query(columns: Sequence[ColumnElement[Any]], wanted: Sequence[ColumnElement[bool]]) -> Select[Any]:
    """Return the query by sensor, then oldest first.

    Of solutions of one run the one that was published last comes last.
    """
    tables = SETS.outerjoin(POINTS, SETS.c.sha256 == POINTS.c.sha256)
    tables = tables.outerjoin(ADJUSTMENTS, SETS.c.sha256 == ADJUSTMENTS.c.sha256)
    tables = tables.outerjoin(QUARANTINES, SETS.c.sha256 == QUARANTINES.c.sha256)
    tables = tables.outerjoin(VERDICTS, SETS.c.sha256 == VERDICTS.c.sha256)
    order = (SETS.c.sensor, SETS.c.created_utc, SETS.c.published_utc, SETS.c.sha256)
    return select(*columns).select_from(tables).where(*wanted).order_by(*order)


def _conditions(search: Search) -> list[ColumnElement[bool]]:
    equal = {SETS.c.sensor: search.sensor, SETS.c.serial: search.serial, POINTS.c.rig: search.rig,
             SETS.c.run_id: search.run_id}  # fmt: skip
    wanted = [column == value for column, value in equal.items() if value is not None]
    if search.since_utc is not None:
        wanted.append(SETS.c.created_utc >= search.since_utc)
    if search.until_utc is not None:
        wanted.append(SETS.c.created_utc < search.until_utc)
    return wanted


def _verdict_row(coefficients: CoefficientSet) -> dict[str, Any]:
    return {"sha256": coefficients.sha256, "verdict": coefficients.verdict}


def _set_row(coefficients: CoefficientSet, published_utc: datetime) -> dict[str, Any]:
    sensor, provenance = table(coefficients.document["sensor"]), coefficients.provenance
    return {
        "sha256": coefficients.sha256,
        "sensor": coefficients.sensor,
        "serial": sensor["serial"],
        "model": coefficients.model,
        "convention": coefficients.convention,
        "status": coefficients.document["status"],
        "simulated": coefficients.is_simulated,
        "run_id": provenance["run_id"],
        "software_version": provenance["software_version"],
        "created_utc": coefficients.created_utc,
        "published_utc": published_utc,
        "document": to_json(coefficients).decode("utf-8"),
    }


def _coefficient_rows(coefficients: CoefficientSet) -> list[dict[str, Any]]:
    return [
        {"sha256": coefficients.sha256, "axis": axis, "name": name, **_coefficient(table(parameter))}
        for axis, section in table(coefficients.document["axes"]).items()
        for name, parameter in table(table(section)["parameters"]).items()
    ]


def _coefficient(parameter: Document) -> dict[str, Any]:
    return {name: parameter[name] for name in ("unit", "value", "standard_uncertainty")}
