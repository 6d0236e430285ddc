"""A folder that another account can enter: the temporary folder of whoever tests may be private."""

import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_PASSABLE = 0o755


def make_open_folder(prefix: str = "calrig-tests-") -> Path:
    """Make a new folder that every account can enter, in the first of the places that lets them through."""
    places = (Path(tempfile.gettempdir()), Path("/tmp"), Path("/var/tmp"))
    passable = [place for place in places if _lets_through(place)]
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=passable[0] if passable else None))
    folder.chmod(_PASSABLE)
    return folder


@contextmanager
def open_folder() -> Iterator[Path]:
    """A new folder that every account can enter, for the length of the context."""
    folder = make_open_folder()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _lets_through(place: Path) -> bool:
    return all(folder.stat().st_mode & stat.S_IXOTH for folder in (place, *place.resolve().parents))
