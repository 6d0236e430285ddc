"""Every test that takes ``archive`` runs on SQLite, and on a real PostgreSQL server in CI."""

from archive_kinds import archive, postgres

__all__ = ["archive", "postgres"]
