"""What a database refused, as a sentence: who holds it, what it lacks, what to do. Nothing was changed in any case.

What cannot be read out of it (a row, a table, the file) is damage, whoever finds it: the database, its driver or the
conversion of a cell.
"""

import re

from ams.errors import ArchiveDamaged, ArchiveError, ArchiveUnknown

NOTHING = "nothing was changed"
HIDDEN = "***"
"""In place of a password."""
PASSWORD_KEYS = ("password", "sslpassword")
"""Of the query of a URL."""

RESTORE = "restore a copy"
VERIFY = f"{RESTORE}; calrig archive verify names the rows"

_BUSY = ("locked", "busy", "lock timeout", "LockNotAvailable")

SENTENCES: tuple[tuple[tuple[str, ...], str, str, type[ArchiveError]], ...] = (
    (
        _BUSY,
        "the archive is locked by another program for over {wait:g} s",
        "try again later",
        ArchiveError,
    ),
    (
        ("unable to open",),
        "the archive cannot be opened: {cause}",
        "check that the folder exists and its rights",
        ArchiveError,
    ),
    (
        ("readonly", "read-only"),
        "the archive cannot be written: {cause}",
        "check the rights of the file and its folder",
        ArchiveError,
    ),
    (
        ("not a database",),
        "is no archive, or a damaged one: {cause}",
        "restore a copy, or give another URL",
        ArchiveDamaged,
    ),
    (
        ("malformed",),  # no command of ours reads rows out of such a file
        "the archive is damaged ({cause})",
        RESTORE,
        ArchiveDamaged,
    ),
    (
        ("Could not decode", "no such table", "no such column", "UndefinedTable", "UndefinedColumn"),
        "the archive is damaged ({cause})",
        VERIFY,
        ArchiveDamaged,
    ),
    (
        ("disk is full", "No space left", "DiskFull", "disk I/O error"),
        "the disk of the archive is full or fails: {cause}",
        "free some space, then do it again",
        ArchiveError,
    ),
    (
        ("does not exist", "could not translate host name", "failed to resolve host", "Name or service not known"),
        "there is no such database or server: {cause}",
        "check the URL; a PostgreSQL database is made by its administrator (createdb)",
        ArchiveUnknown,
    ),
    (
        ("password authentication failed", "no password supplied", "no pg_hba.conf entry", "Peer authentication"),
        "the database does not let you in: {cause}",
        "check user and password of the URL",
        ArchiveError,
    ),
    (
        ("permission denied", "InsufficientPrivilege"),
        "the rights are missing: {cause}",
        "ask the database's administrator for the rights to make and write tables",
        ArchiveError,
    ),
    (
        ("Connection refused", "connection failed", "timeout expired", "server closed the connection"),
        "the server of the archive does not answer: {cause}",
        "check that it runs and that the URL is right",
        ArchiveError,
    ),
)


def without_password(archive_url: str) -> str:
    """Return the URL as it may be shown, printed and kept: a password in it, in either place, as three stars."""
    shown = re.sub(r"(?<=://)([^:/@]*):.*(?=@)", rf"\1:{HIDDEN}", archive_url)
    return re.sub(rf"([?&](?:{'|'.join(PASSWORD_KEYS)})=)[^&]*", rf"\1{HIDDEN}", shown)


def refusal(shown: str, error: Exception, busy_timeout_s: float) -> ArchiveError:
    """Return the error to raise for what a database or its driver said."""
    cause, original_text = cause_of(error), _original_text(error)
    for signs, what, to_do, kind in SENTENCES:
        if any(sign in original_text for sign in signs):
            return kind(f"{shown}: {what.format(cause=cause, wait=busy_timeout_s)}; {NOTHING}; {to_do}")
    return ArchiveError(
        f"{shown}: the archive refused: {cause}; {NOTHING}; check the URL, the rights and the free space"
    )


def is_busy(error: Exception) -> bool:
    """Return whether a database refused because another program has it."""
    return any(sign in _original_text(error) for sign in _BUSY)


def _original_text(error: Exception) -> str:
    original = getattr(error, "orig", None) or error
    return f"{type(original).__name__} {original}"


def damaged(shown: str, what: str, to_do: str = VERIFY) -> ArchiveDamaged:
    """Return the error to raise for an archive that is not as it was written; ``what`` names the place."""
    return ArchiveDamaged(f"{shown}: the archive is damaged ({what}); {NOTHING}; {to_do}")


def cause_of(error: Exception) -> str:
    """Return what a database, its driver or the conversion of a cell said, in one line."""
    return _last_line(str(getattr(error, "orig", None) or error))


def _last_line(text: str) -> str:
    """Return a driver's first line; of failed connections the last one's reason."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    reasons = [line.rpartition("failed: ")[2] for line in lines if "failed: " in line]
    return next((reason for reason in reversed(reasons) if reason), lines[0] if lines else "no reason was given")
