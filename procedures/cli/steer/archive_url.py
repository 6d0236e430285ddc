"""The URL of the archive that a run's sets go to: whether it can be one, how the run keeps it, what it is later."""

from contextlib import suppress
from os import environ
from pathlib import Path

from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

from ams.archive.connection import EMPTIED, EMPTIED_REMEDY, is_emptied
from ams.archive.refusals import HIDDEN, PASSWORD_KEYS, without_password
from ams.errors import ArchiveError
from procedures.cli.locations import archive_of, shared_archive_url
from procedures.cli.output import note
from procedures.errors import RequestError
from procedures.journal.journal_reader import JournalReader


def require_archive_url(archive_url: str) -> None:
    """Refuse before anything moves what would else be refused after the last dwell. Nothing is connected to: a server
    that does not answer now may do so when the run ends. Raises: RequestError.
    """
    shown = archive_url.rpartition("@")[2]  # what stands before it may hold a password
    try:
        url = make_url(archive_url)
        url.get_dialect()
    except (ArgumentError, ImportError, ValueError) as error:
        raise RequestError(
            f"archive: no archive can have this URL: got {shown!r} ({error.__class__.__name__}), allowed are "
            "sqlite:///relative/path, sqlite:////absolute/path and postgresql+psycopg://…; nothing was begun"
        ) from error
    if url.get_backend_name() == "sqlite" and url.database and not Path(url.database).parent.is_dir():
        raise RequestError(
            f"archive: its folder is not there: got {shown!r}; nothing was begun; make the folder or give another URL"
        )
    if url.get_backend_name() == "sqlite" and url.database and is_emptied(archive_url):
        raise RequestError(f"{url.database}: the archive {EMPTIED}; nothing was begun; {EMPTIED_REMEDY}")


def as_kept(archive: str | None, *, is_simulated: bool) -> str:
    """Return the archive that was named for a run, as its journal keeps it; empty where none was.

    A path is a whole one, since the run may be taken up from another folder; a password is never kept.
    ``is_simulated``: ``CALRIG_ARCHIVE`` is then not where its sets go.
    """
    named = archive if is_simulated else shared_archive_url(archive)
    if not named:
        return ""
    url = make_url(named)
    if url.get_backend_name() == "sqlite" and url.database and url.database != ":memory:":
        return url.set(database=str(Path(url.database).absolute())).render_as_string(hide_password=False)
    return without_password(named)


def archive_of_run(folder: Path, archive: str | None) -> str | None:
    """Return the archive that is named now, else the one that a run keeps; None where neither is.

    Of one with a password the run keeps all but that: the whole URL is taken from ``CALRIG_ARCHIVE`` where it is the
    same one, else the database is asked without, as by ``PGPASSWORD`` or a file of passwords, which is said.
    Raises: JournalError.
    """
    if archive is not None:
        return archive
    with JournalReader.open(folder) as reader:
        opened = reader.last_event("opened")
    kept = "" if opened is None else str(opened.detail.get("archive") or "")
    if HIDDEN not in kept:
        return kept or None
    of_environment = environ.get("CALRIG_ARCHIVE") or ""
    if without_password(of_environment) == kept:
        return of_environment
    if "PGPASSWORD" not in environ:
        note(
            f"archive {kept}: the run keeps no password; where the database wants one, give --archive again, or set "
            "CALRIG_ARCHIVE or PGPASSWORD"
        )
    return _without_stars(kept)


def url_of_run(folder: Path, archive: str | None, *, is_simulated: bool) -> str:
    """Return where the sets of a run go: the archive named now, else the run's own, else that of such runs here.

    One whose file has 0 bytes is begun anew, and said to be: what was measured is not kept out of it.
    """
    url = archive_of(folder.parent, archive_of_run(folder, archive), is_simulated=is_simulated)
    with suppress(ArchiveError):  # what is wrong with a URL is told where it is written to
        if is_emptied(url):
            note(
                f"{without_password(url)}: the archive {EMPTIED}; it is begun anew; where it held sets, restore a copy"
            )
    return url


def _without_stars(kept: str) -> str:
    """Return a URL that is kept with stars for its password, without these."""
    url = make_url(kept).difference_update_query(PASSWORD_KEYS)
    whole = URL.create(url.drivername, url.username, None, url.host, url.port, url.database, url.query)
    return whole.render_as_string(hide_password=False)
