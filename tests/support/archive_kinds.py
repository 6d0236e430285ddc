"""Archives of both kinds: every test that takes ``archive`` runs on SQLite, and on a real PostgreSQL server in CI."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from postgres_server import Server, running_server
from sqlalchemy import create_engine, text
from sqlalchemy.pool import NullPool


@dataclass(frozen=True)
class Archive:
    """The URL of an archive that is not there yet, and a way behind its back."""

    url: str

    @property
    def is_sqlite(self) -> bool:
        return self.url.startswith("sqlite")

    def execute(self, statement: str) -> list[tuple[object, ...]]:
        """Run SQL as somebody with the rights and without calrig."""
        engine = create_engine(self.url, poolclass=NullPool)
        with engine.begin() as connection:
            result = connection.execute(text(statement))
            return [tuple(row) for row in result] if result.returns_rows else []


@pytest.fixture(scope="session")
def postgres() -> Iterator[Server]:
    with running_server() as server:
        yield server


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.thorough)])
def archive(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Archive]:
    if request.param == "sqlite":
        yield Archive(f"sqlite:///{tmp_path / 'archive.sqlite'}")
        return
    server: Server = request.getfixturevalue("postgres")
    url = server.new_database()
    yield Archive(url)
    server.drop_database(url)
