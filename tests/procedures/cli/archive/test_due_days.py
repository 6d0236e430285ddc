"""What is due is counted from the day on the calendar at the wall, as a certificate's own due day is."""

import os
from datetime import UTC, date, datetime
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from archived_runs import a_run, a_sensor
from command import call
from visited_console import Visited
from zones import FARTHEST, hung_in

from ams.archive.runs import publish_run

FAR = date(2999, 1, 1)
pytestmark = pytest.mark.skipif(os.name == "nt", reason="the zone of a process is a variable only elsewhere")


@pytest.mark.parametrize("zone", FARTHEST)
def test_the_days_that_are_left_are_those_of_the_wall(
    zone: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{tmp_path / 'none.sqlite'}"
    publish_run(url, a_run(), [a_sensor(due=FAR)], datetime.now(UTC))
    visited = Visited(tmp_path)
    browser = visited.enter()
    with hung_in(zone):
        before = datetime.now(ZoneInfo(zone)).date()
        due = call(capsys, "archive", "due", "--archive", url, "--json").document["due"]
        behind = datetime.now(ZoneInfo(zone)).date()
        (left,) = (entry["days_left"] for entry in due if entry["kind"] == "standard")
        assert (FAR - behind).days <= left <= (FAR - before).days
        day = visited.clock.now_utc().astimezone(ZoneInfo(zone)).date()
        assert f"in {(FAR - day).days} days" in browser.get("/archive").text
