"""A PostgreSQL server of one's own: a private cluster on a free port of the loopback, thrown away afterwards.

The server refuses to run as root, so a superuser runs it as ``postgres``, in a folder that this user can enter: the
temporary folder may be private. Nothing is synced to the disk: it is gone in a minute.
"""

import os
import secrets
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from open_folder import make_open_folder
from programs import require_program

SERVER_PROGRAMS = tuple(f"/usr/lib/postgresql/{version}/bin" for version in (18, 17, 16, 15, 14, 13))
SERVER_USER = "postgres"
PASSWORD = "opensesame"
SETTINGS = "fsync = off\nsynchronous_commit = on\nfull_page_writes = off\nshared_buffers = 16MB\nmax_connections = 40\n"


@dataclass(frozen=True)
class Server:
    """A running server; databases are made by name."""

    port: int
    run_as: tuple[str, ...]
    programs: Path

    def url(self, database: str, user: str = "laboratory") -> str:
        return f"postgresql+psycopg://{user}:{PASSWORD}@127.0.0.1:{self.port}/{database}"

    def new_database(self) -> str:
        """The URL of a new, empty database."""
        name = f"archive_{secrets.token_hex(6)}"
        self.execute("postgres", f"CREATE DATABASE {name}")
        return self.url(name)

    def drop_database(self, url: str) -> None:
        """Make room again."""
        self.execute("postgres", f"DROP DATABASE {url.rpartition('/')[2]} WITH (FORCE)")

    def execute(self, database: str, statement: str) -> list[tuple[object, ...]]:
        """Run a statement behind the archive's back."""
        import psycopg

        address = f"host=127.0.0.1 port={self.port} user=laboratory password={PASSWORD} dbname={database}"
        with psycopg.connect(address, autocommit=True) as connection:
            cursor = connection.execute(statement)
            return cursor.fetchall() if cursor.description else []


@contextmanager
def running_server() -> Iterator[Server]:
    """A server for the length of the context; skips where PostgreSQL is not installed."""
    initdb = Path(require_program("initdb", also_in=SERVER_PROGRAMS))
    run_as = ("runuser", "-u", SERVER_USER, "--") if os.geteuid() == 0 else ()
    folder = make_open_folder("calrig-postgres-")
    password_file = folder / "password"
    password_file.write_text(PASSWORD)
    if run_as:
        subprocess.run(["chown", "-R", SERVER_USER, str(folder)], check=True)
    data = folder / "data"
    try:
        identity = ["-U", "laboratory", "--pwfile", str(password_file), "-A", "scram-sha-256", "-E", "UTF8"]
        _run([*run_as, str(initdb), "-D", str(data), *identity, "--no-sync", "--no-locale"], folder)
        with (data / "postgresql.conf").open("a") as settings:
            settings.write(SETTINGS)
        port = _free_port()
        control = [*run_as, str(initdb.with_name("pg_ctl")), "-D", str(data)]
        options = f"-p {port} -h 127.0.0.1 -k ''"  # no socket in the file system, whose path may not be long
        _run([*control, "-l", str(folder / "log"), "-o", options, "-w", "start"], folder)
        try:
            yield Server(port, run_as, initdb.parent)
        finally:
            _run([*control, "-m", "immediate", "stop"], folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
