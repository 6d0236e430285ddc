"""The archive's tables as SQLAlchemy sees them; ``migrations`` is what makes them. Imported only when used.

Rows are written once and never changed: what is told later (a signature, a certificate, a newer solution of the same
run) is a row of its own. Every row is told by a record of the chain (:mod:`ams.archive.ledger`). Leases come and go,
and durations and components only tell what to expect of the next run: they are no part of the record.
"""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    Boolean,
    Column,
    ColumnElement,
    Connection,
    Date,
    DateTime,
    Dialect,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
    and_,
    collate,
)


class UtcDateTime(TypeDecorator[datetime]):
    """A moment: aware in, aware UTC out, whether or not the database keeps time zones (SQLite does not)."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError(f"a moment needs its time zone: got {value.isoformat()}")
        utc = value.astimezone(UTC)
        return utc.replace(tzinfo=None) if dialect.name == "sqlite" else utc

    def process_result_value(self, value: Any, dialect: Dialect) -> datetime | None:  # noqa: ARG002 (its signature)
        if value is None:
            return None
        moment: datetime = value
        return moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)


METADATA = MetaData()
REVISIONS = ("0001", "0002", "0003", "0004", "0005", "0006", "0007", "0008", "0009")
"""Of the schema, oldest first: what this calrig knows."""

SETS = Table(
    "sets",
    METADATA,
    Column("sha256", String(64), primary_key=True),
    Column("sensor", Text, nullable=False, index=True),
    Column("serial", Text),
    Column("model", Text, nullable=False),
    Column("convention", Text, nullable=False),
    Column("status", Text, nullable=False),
    Column("simulated", Boolean, nullable=False),
    Column("run_id", Text),
    Column("software_version", Text, nullable=False),
    Column("created_utc", UtcDateTime, nullable=False),
    Column("published_utc", UtcDateTime, nullable=False),
    Column("document", Text, nullable=False),
    Index("ix_sets_run_sensor", "run_id", "sensor"),
)


def in_code_points(connection: Connection, text: ColumnElement[str]) -> ColumnElement[str]:
    """Return a text as it is ordered and compared as Python does, whatever language a database was made for."""
    return text if connection.dialect.name == "sqlite" else collate(text, "C")


COEFFICIENTS = Table(
    "coefficients",
    METADATA,
    Column("sha256", String(64), ForeignKey("sets.sha256"), primary_key=True),
    Column("axis", Text, primary_key=True),
    Column("name", Text, primary_key=True),
    Column("unit", Text, nullable=False),
    Column("value", Double),
    Column("standard_uncertainty", Double),
)

POINTS = Table(
    "points",
    METADATA,
    Column("sha256", String(64), ForeignKey("sets.sha256"), primary_key=True),
    Column("rig", Text, nullable=False),
    Column("axes", Text, nullable=False),
    Column("sensitivity_name", Text, nullable=False),
    Column("check_sensor", Boolean, nullable=False),
    Column("gravity_mps2", Double, nullable=False),
    Column("numbers", LargeBinary, nullable=False),
)
"""A set as a point of its sensor's history: offset, k and covariances as ``ams.surveillance.history_points`` packs
them."""

VERDICTS = Table(
    "verdicts",
    METADATA,
    Column("sha256", String(64), ForeignKey("sets.sha256"), primary_key=True),
    Column("verdict", Text, nullable=False),
)
"""What a set states of its own calibration in one word; no row where it states none."""

RUNS = Table(
    "runs",
    METADATA,
    Column("journal_sha256", String(64), primary_key=True),
    Column("run_id", Text, nullable=False, index=True),
    Column("title", Text, nullable=False),
    Column("rig", Text, nullable=False),
    Column("operator", Text, nullable=False),
    Column("simulated", Boolean, nullable=False),
    Column("started_utc", UtcDateTime, nullable=False),
    Column("ended_utc", UtcDateTime, nullable=False),
    Column("folder", Text, nullable=False),
    Column("software_version", Text, nullable=False),
    Column("published_utc", UtcDateTime, nullable=False),
)

STANDARDS = Table(
    "standards",
    METADATA,
    Column("serial", Text, primary_key=True),
    Column("certificate", Text, primary_key=True),
    Column("name", Text, nullable=False),
    Column("due", Date),
    Column("uncertainty", Text, nullable=False),
)

USES = Table(
    "uses",
    METADATA,
    Column("journal_sha256", String(64), ForeignKey("runs.journal_sha256"), primary_key=True),
    Column("serial", Text, primary_key=True),
    Column("certificate", Text, primary_key=True),
    Column("overridden_by", Text),
    Column("override_reason", Text),
)
"""Which standard stood behind which run; an expired one with who answers for it and why."""

STANDARDS_USED = USES.join(
    STANDARDS, and_(USES.c.serial == STANDARDS.c.serial, USES.c.certificate == STANDARDS.c.certificate)
)
"""Each use with the certificate that held then."""

ADJUSTMENTS = Table(
    "adjustments",
    METADATA,
    Column("sha256", String(64), ForeignKey("sets.sha256"), primary_key=True),
    Column("previous_sha256", String(64), ForeignKey("sets.sha256")),
    Column("as_found", Text),
    Column("as_left", Text),
    Column("as_found_error_deg", Double),
    Column("as_left_error_deg", Double),
    Column("document", Text, nullable=False),
)
"""As found and as left: verdicts, largest errors, and the whole as JSON."""

QUARANTINES = Table(
    "quarantines",
    METADATA,
    Column("sha256", String(64), ForeignKey("sets.sha256"), primary_key=True),
    Column("reason", Text, nullable=False),
    Column("quarantined_utc", UtcDateTime, nullable=False),
)
"""Sets of a run whose table turned: kept as they are, and never what a later one is compared with."""

SIGNATURES = Table(
    "signatures",
    METADATA,
    Column("sequence", Integer, primary_key=True, autoincrement=False),
    Column("sha256", String(64), ForeignKey("sets.sha256"), nullable=False, index=True),
    Column("role", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("signed_utc", UtcDateTime, nullable=False),
    Column("comment", Text, nullable=False),
)

FUNCTIONS = Table(
    "functions",
    METADATA,
    Column("sequence", Integer, ForeignKey("signatures.sequence"), primary_key=True, autoincrement=False),
    Column("function", Text, nullable=False),
)
"""Of who signed, in the laboratory, where it was told with the signature."""

CERTIFICATES = Table(
    "certificates",
    METADATA,
    Column("number", Text, primary_key=True),
    Column("sha256", String(64), ForeignKey("sets.sha256"), nullable=False, index=True),
    Column("file_sha256", String(64), nullable=False),
    Column("issued_by", Text, nullable=False),
    Column("issued_utc", UtcDateTime, nullable=False),
    Column("amends", Text, ForeignKey("certificates.number")),
    Column("reason", Text, nullable=False),
)

RECORDS = Table(
    "records",
    METADATA,
    Column("sequence", Integer, primary_key=True, autoincrement=False),
    Column("utc", UtcDateTime, nullable=False),
    Column("kind", Text, nullable=False),
    Column("detail", Text, nullable=False),
    Column("previous", String(64), nullable=False),
    Column("sha256", String(64), nullable=False),
)
"""The chain: what was written, when, by whom, each record with the hash of the one before."""

COMING_AND_GOING = MetaData()
"""Tables that the chain does not tell of."""

LEASES = Table(
    "leases",
    COMING_AND_GOING,
    Column("resource", Text, primary_key=True),
    Column("token", String(32), nullable=False),
    Column("host", Text, nullable=False),
    Column("account", Text, nullable=False),
    Column("purpose", Text, nullable=False),
    Column("place", Text, nullable=False),
    Column("since_utc", UtcDateTime, nullable=False),
    Column("lapses_utc", UtcDateTime, nullable=False),
)
"""Who has a device that more than one computer reaches, until when if nothing is heard of it."""

DURATIONS = Table(
    "durations",
    COMING_AND_GOING,
    Column("journal_sha256", String(64), primary_key=True),
    Column("part", Text, primary_key=True),
    Column("rig", Text, nullable=False, index=True),
    Column("simulated", Boolean, nullable=False),
    Column("ended_utc", UtcDateTime, nullable=False),
    Column("steps", Integer, nullable=False),
    Column("expected_s", Double, nullable=False),
    Column("measured_s", Double, nullable=False),
    Column("expected_s2", Double, nullable=False),
    Column("rest_s2", Double, nullable=False),
)
"""Of every run, how long the parts of its steps were expected to take by the files, and took."""

COMPONENTS = Table(
    "components",
    COMING_AND_GOING,
    Column("journal_sha256", String(64), primary_key=True),
    Column("sensor", Text, primary_key=True),
    Column("axis", Text, primary_key=True),
    Column("type", Text, nullable=False),
    Column("rig", Text, nullable=False, index=True),
    Column("simulated", Boolean, nullable=False),
    Column("ended_utc", UtcDateTime, nullable=False),
    Column("reading_g", Double, nullable=False),
    Column("dwell_g", Double, nullable=False),
    Column("lack_of_fit_g", Double, nullable=False),
    Column("offset_drift_g", Double, nullable=False),
    Column("sensitivity_drift", Double, nullable=False),
)
"""Of every run, what each sensor axis showed: noise, lack of fit and drift, per sensitivity."""
