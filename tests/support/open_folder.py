"""A folder that another account can enter: the temporary folder of whoever tests may be private."""

import re
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PASSABLE = 0o755
_PLAIN = re.compile(r"[A-Za-z0-9/._-]+")


def make_open_folder(prefix: str = "calrig-tests-", *, plain: bool = False) -> Path:
    """Make a new folder that every account can enter, in the first of the places that lets them through.

    ``plain``: nothing in its path is a space or beyond the letters that every program takes.
    """
    locations = (Path(tempfile.gettempdir()), Path("/tmp"), Path("/var/tmp"))
    fit = [
        location for location in locations if _lets_through(location) and (not plain or _PLAIN.fullmatch(str(location)))
    ]
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=fit[0] if fit else None))
    folder.chmod(_PASSABLE)
    return folder


@contextmanager
def open_folder(*, plain: bool = False) -> Iterator[Path]:
    """A new folder that every account can enter, for the length of the context."""
    folder = make_open_folder(plain=plain)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _lets_through(location: Path) -> bool:
    return all(folder.stat().st_mode & stat.S_IXOTH for folder in (location, *location.resolve().parents))
