"""Where things are: run folders, the archive, the user's folders."""

import getpass
import os
import re
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from platformdirs import user_state_path

from procedures.accounts.people import People
from procedures.errors import RequestError
from procedures.journal.taken_away import is_taken_away
from rig.plain_text import LONGEST_NAME, text_complaint

JOURNAL = "journal.sqlite"


def find_run(run: str, runs: Path) -> Path:
    """Return the run folder that RUN means. Raises: RequestError.

    RUN is a run folder, its journal, its name under ``runs``, or a folder that holds exactly one run.
    """
    for candidate in (Path(run), runs / run):
        if candidate.is_file() and candidate.name == JOURNAL:
            return candidate.parent
        if (candidate / JOURNAL).exists() or is_taken_away(candidate):
            return candidate
    held = sorted(path.parent for path in Path(run).glob(f"*/{JOURNAL}")) if Path(run).is_dir() else []
    if len(held) == 1:
        return held[0]
    if held:
        raise RequestError(
            f"{run}: holds {len(held)} runs ({', '.join(path.name for path in held[:5])} …); name one of them"
        )
    if Path(run).is_file():
        raise RequestError(f"{run}: is a file and not a run's {JOURNAL}; give the run's folder")
    raise RequestError(f"{run}: no run is there (looked for {JOURNAL} in it and in {runs / run}); check the path")


def new_run_folder(out: Path, title: str, now: datetime) -> Path:
    """``<out>/<utc>-<slug>``, made new. File names are safe on every system."""
    letters = unicodedata.normalize("NFKD", title.lower()).encode("ascii", "ignore").decode("ascii")
    slug = re.sub(r"[^a-z0-9]+", "-", letters).strip("-")[:48] or "run"
    stem = f"{now:%Y%m%dT%H%M%SZ}-{slug}"
    for attempt in range(1, 1000):
        folder = out / (stem if attempt == 1 else f"{stem}-{attempt}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise RequestError(
                f"{out}: cannot hold runs: {error.strerror}; nothing was begun; give --out with a folder that can be "
                "written"
            ) from error
        return folder
    raise RequestError(f"{out}: holds a thousand runs of this second; look at the clock")


@contextmanager
def left_out_where_empty(folder: Path) -> Iterator[None]:
    """Remove a run's folder again where the run was refused before its journal was made."""
    try:
        yield
    except RequestError:
        with suppress(OSError):  # it holds something, so it stays
            folder.rmdir()
        raise


def archive_of(runs: Path, archive: str | None, *, is_simulated: bool) -> str:
    """Return the archive of the runs in a folder; a simulated run's is beside them, never the laboratory's own.

    Its past runs teach how long the next takes.
    """
    return (archive or f"sqlite:///{runs / 'archive.sqlite'}") if is_simulated else archive_url(archive)


def archive_to_show(runs: Path, archive: str | None = None) -> str:
    """Return the archive of which a person is told who looks at a folder of runs.

    It is the one that was named, else the user's own; where nobody has any yet, that of the simulated runs beside them.
    """
    beside = runs / "archive.sqlite"
    nobody_has_any = shared_archive_url(archive) is None and not (user_state_path("calrig") / "archive.sqlite").exists()
    return archive_of(runs, archive, is_simulated=nobody_has_any and beside.exists())


def archive_url(archive: str | None = None) -> str:
    """Return the archive that was named, else ``archive.sqlite`` in the user's state folder, which is made."""
    return (
        shared_archive_url(archive) or f"sqlite:///{user_state_path('calrig', ensure_exists=True) / 'archive.sqlite'}"
    )


def shared_archive_url(archive: str | None = None) -> str | None:
    """Return the archive that was named, by option or by ``CALRIG_ARCHIVE``; None where there is only the user's own.

    Only one that was named can be shared with other computers, and keep leases for them.
    """
    return archive or os.environ.get("CALRIG_ARCHIVE") or None


def queues_of_here() -> Path:
    """Return the folder of queues: ``CALRIG_QUEUES``, else that of the user's state folder."""
    given = os.environ.get("CALRIG_QUEUES")
    return Path(given) if given else user_state_path("calrig") / "queues"


def people_of_here() -> People:
    """Return the accounts of this machine: ``CALRIG_PEOPLE``, else ``people.json`` in the user's state folder."""
    given = os.environ.get("CALRIG_PEOPLE")
    return People(Path(given) if given else user_state_path("calrig") / "people.json")


def login_name() -> str:
    """Return who is logged in, for the record."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return f"uid {os.getuid()}" if hasattr(os, "getuid") else "unknown"


def person_named(operator: str | None) -> str:
    """Return who answers for it: by --operator, else who is logged in.

    Raises: RequestError for a name that is empty, or that nobody can read.
    """
    if operator is None:
        return login_name()
    complaint = text_complaint(operator, longest=LONGEST_NAME) or (
        "" if operator.strip() else "is empty; give a name, or leave it out"
    )
    if complaint:
        raise RequestError(f"--operator: got {operator[:80]!r}, which {complaint}; nothing was done")
    return operator.strip()
