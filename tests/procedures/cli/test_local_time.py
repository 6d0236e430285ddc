"""Moments as a person reads them: by the watch where the command is called, with UTC beside it."""

import os
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

from archived_runs import a_run, a_sensor
from run_folders import STARTED_UTC, make_run

from ams.archive.runs import publish_run
from procedures.journal.requests.corrections import add_note
from procedures.records.states import State

CALLS = "import sys; from procedures.cli.main import run_command; [run_command(c.split('|')) for c in sys.argv[1:]]"


def _told_in_tokyo(*calls: tuple[object, ...]) -> str:
    """What the commands print there, one after the other in one process."""
    words = ["|".join(map(str, call)) for call in calls]
    environment = {**os.environ, "TZ": "Asia/Tokyo"}
    done = subprocess.run(
        [sys.executable, "-c", CALLS, *words], env=environment, capture_output=True, encoding="utf-8", check=True
    )
    return done.stdout


def test_moments_are_told_by_the_watch_and_in_utc(tmp_path: Path) -> None:
    """The archived run began on 10 January at 18:00 UTC, 3 o'clock on Sunday in Tokyo, and took nine hours."""
    url, run = f"sqlite:///{tmp_path / 'archive.sqlite'}", make_run(tmp_path / "night", State.STOPPED)
    publish_run(url, a_run(), [a_sensor()], datetime(2026, 6, 1, tzinfo=UTC))
    add_note(run, "bumped", "anna")
    looks = [("archive", *words, "--archive", url) for words in (("search",), ("list",), ("show", "SN1"))]
    told = _told_in_tokyo(*looks, ("handover", run))
    searched, listed, shown, handed = (told.index(start) for start in ("1 run ", "1 set ", "SN1: pitch", "title of"))
    began, ended = "Sun 03:00 local (2026-01-10 18:00 UTC)", "Sun 12:00 local (2026-01-11 03:00 UTC)"
    assert began in told[searched:listed]
    assert ended in told[listed:shown]
    assert f"calibrated {ended}" in told[shown:handed]
    assert f"began it Sat 03:00 local ({STARTED_UTC:%Y-%m-%d %H:%M} UTC)" in told[handed:]
    moments = [line for line in told[handed:].splitlines() if line.startswith("  ")]
    assert len(moments) > 5
    assert [line for line in moments if " local (20" not in line] == []
