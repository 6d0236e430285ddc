"""The archive's tables as SQLAlchemy sees them; ``migrations`` is what makes them. Imported only when used."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    Boolean,
    Column,
    DateTime,
    Dialect,
    Double,
    ForeignKey,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
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
)

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
