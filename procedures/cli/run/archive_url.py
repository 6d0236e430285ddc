"""Whether the URL of an archive can be one, looked at before anything moves."""

from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from procedures.errors import RequestError


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
