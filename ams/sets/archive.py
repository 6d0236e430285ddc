"""The archive: coefficient sets kept for years, in SQLite by default and in any database that SQLAlchemy reaches.

A set is identified by its checksum. Publishing is idempotent and one transaction: every set is in, or none. What is
read back has passed the same checks as a set from a file. Where the archive is, the caller says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from typing import TYPE_CHECKING, Any

from ams.errors import ArchiveError, ArchiveUnknown
from ams.sets.archive_connection import reading, writing
from ams.sets.canonical import Document, table
from ams.sets.coefficients import CoefficientSet
from ams.sets.export.json_text import from_json, to_json

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, Connection, RowMapping, Table

BUSY_TIMEOUT_S = 10.0
SHORTEST_KEY = 6


@dataclass(frozen=True)
class ArchivedSet:
    """One set as a row of a list, in plain values."""

    sha256: str
    sensor: str
    serial: str | None
    model: str
    convention: str
    status: str
    simulated: bool
    run_id: str | None
    software_version: str
    created_utc: datetime
    published_utc: datetime


@dataclass(frozen=True)
class Publication:
    """What became of one set: new in the archive, or there before."""

    sha256: str
    sensor: str
    is_new: bool


def publish(
    archive_url: str,
    sets: Sequence[CoefficientSet],
    published_utc: datetime,
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> tuple[Publication, ...]:
    """Put the sets into the archive, all or none; a set that is there already is left as it is.

    Raises: ArchiveError where the archive cannot be written; VectorsDisagree for a set that contradicts itself.
    """
    if published_utc.tzinfo is None:
        raise ArchiveError(
            f"archive: published_utc has no time zone: got {published_utc.isoformat()}; nothing was published; "
            "pass an aware time"
        )
    for coefficients in sets:
        coefficients.check_vectors(f"{coefficients.sensor}: publish")
    with writing(archive_url, busy_timeout_s) as connection:
        return tuple(_published(connection, coefficients, published_utc) for coefficients in sets)


def list_sets(
    archive_url: str, sensor: str | None = None, busy_timeout_s: float = BUSY_TIMEOUT_S
) -> tuple[ArchivedSet, ...]:
    """The sets, by sensor, then oldest first. Raises: ArchiveError where the archive cannot be read."""
    from ams.sets.archive_tables import SETS

    listed = [SETS.c[field.name] for field in fields(ArchivedSet)]
    with reading(archive_url, busy_timeout_s) as connection:
        rows = _rows(connection, listed, None if sensor is None else SETS.c.sensor == sensor)
    return tuple(ArchivedSet(**row) for row in rows)


def show(archive_url: str, key: str, busy_timeout_s: float = BUSY_TIMEOUT_S) -> CoefficientSet:
    """The set of a checksum (its first six or more characters), or the latest set of a sensor.

    Raises: ArchiveError where nothing or more than one checksum fits; SetError where the stored set is damaged.
    """
    from ams.sets.archive_tables import SETS

    with reading(archive_url, busy_timeout_s) as connection:
        rows = _rows(connection, [SETS], SETS.c.sensor == key)[-1:]
        if not rows and len(key) >= SHORTEST_KEY:
            rows = _rows(connection, [SETS], SETS.c.sha256.startswith(key.lower(), autoescape=True))
    if len(rows) != 1:
        found = ", ".join(row["sha256"][:12] for row in rows) or "nothing"
        raise ArchiveUnknown(
            f"archive: no single set for {key!r}: found {found}, needed is a sensor's name or at least {SHORTEST_KEY} "
            "characters of a checksum that fit one set; list the sets and take one from there"
        )
    return from_json(rows[0]["document"].encode("utf-8"), f"archive: set {rows[0]['sha256'][:12]}")


def _published(connection: "Connection", coefficients: CoefficientSet, published_utc: datetime) -> Publication:
    from sqlalchemy import insert, select

    from ams.sets.archive_tables import COEFFICIENTS, SETS

    there = connection.execute(select(SETS.c.sha256).where(SETS.c.sha256 == coefficients.sha256)).first()
    if there is None:
        connection.execute(insert(SETS).values(_set_row(coefficients, published_utc)))
        connection.execute(insert(COEFFICIENTS), _coefficient_rows(coefficients))
    return Publication(coefficients.sha256, coefficients.sensor, there is None)


def _rows(
    connection: "Connection", columns: "Sequence[ColumnElement[Any] | Table]", where: "ColumnElement[bool] | None"
) -> "Sequence[RowMapping]":
    from sqlalchemy import select

    from ams.sets.archive_tables import SETS

    query = select(*columns).order_by(SETS.c.sensor, SETS.c.created_utc, SETS.c.sha256)
    return connection.execute(query if where is None else query.where(where)).mappings().all()


def _set_row(coefficients: CoefficientSet, published_utc: datetime) -> dict[str, Any]:
    sensor, provenance = table(coefficients.document["sensor"]), coefficients.provenance
    return {
        "sha256": coefficients.sha256,
        "sensor": coefficients.sensor,
        "serial": sensor["serial"],
        "model": coefficients.model,
        "convention": coefficients.convention,
        "status": coefficients.status,
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
