"""Where a run stands, read from its journal by any process at any time."""

from contextlib import closing
from pathlib import Path

from procedures.journal.status.follower import Follower
from procedures.journal.status.standing import RunStatus


def status(run_dir: Path) -> RunStatus:
    """Return where a run stands. Raises: JournalError."""
    with closing(Follower(run_dir, with_dwells=False)) as follower:
        return follower.poll().status
