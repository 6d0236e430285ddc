"""Times as people read them: local first, UTC beside it, and by one function wherever something is told."""

import os
import subprocess
import sys
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest

from rig.local_time import at_both, text_at_both

ROOT = Path(__file__).parents[2]
MOMENT = datetime(2026, 2, 28, 23, 40, 7, tzinfo=UTC)
EAST = timezone(timedelta(hours=1))
ITS_OWN = {
    "procedures/queue/moments.py": "what is read, not told",
    "procedures/report/": "documents, in UTC alone",
    "procedures/solution/said_of_run.py": "the zero of a term in time",
}
"""Where a time of day has another form, and why."""


def test_the_day_of_the_reader_may_be_another_than_that_of_utc() -> None:
    assert at_both(MOMENT, EAST) == "Sun 00:40 local (2026-02-28 23:40 UTC)"
    assert at_both(MOMENT, EAST, to_the_second=True) == "Sun 00:40:07 local (2026-02-28 23:40:07 UTC)"
    assert at_both(MOMENT.astimezone(EAST), EAST) == at_both(MOMENT, EAST), "in whatever zone it comes"
    assert at_both(MOMENT, UTC) == "2026-02-28 23:40 UTC"


def test_a_text_that_is_no_time_is_left_as_it_is() -> None:
    assert text_at_both("a while ago") == "a while ago"


@pytest.mark.skipif(os.name == "nt", reason="the zone of a process is a variable only elsewhere")
def test_who_has_a_rig_is_told_by_the_clock_on_the_wall() -> None:
    """In St John's, as the process that tells it: half an hour beside every whole one."""
    tell = (
        "from rig.lines.lock import LockOwner;print(LockOwner('rig.toml', 7, '2026-02-28T23:40:07+00:00', 'jog', ''))"
    )
    environment = {**os.environ, "TZ": "America/St_Johns"}
    done = subprocess.run(
        [sys.executable, "-c", tell], capture_output=True, text=True, check=True, env=environment, cwd=ROOT
    )
    assert done.stdout == "process 7 (jog) since Sat 20:10:07 local (2026-02-28 23:40:07 UTC)\n"


def test_nobody_else_writes_a_time_of_day() -> None:
    found = {
        path.relative_to(ROOT).as_posix()
        for package in ("procedures", "rig")
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".py", ".j2") and "%H:%M" in path.read_text(encoding="utf-8")
    }
    assert {path for path in found if not path.startswith(tuple(ITS_OWN))} == {"rig/local_time.py"}
    assert all(any(path.startswith(known) for path in found) for known in ITS_OWN), "the table names what is not there"
