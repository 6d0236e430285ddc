"""Times of day as people say them are those of the clock on the wall, on the days too on which it is put on or back."""

import os
from datetime import UTC, datetime
from zoneinfo import ZoneInfo

import pytest
from zones import hung_in

from procedures.errors import RequestError
from procedures.queue.moments import moment

BERLIN = ZoneInfo("Europe/Berlin")
"""From 2 to 3 at 01:00 UTC of 2026-03-29, and from 3 back to 2 at 01:00 UTC of 2026-10-25 (directive 2000/84/EC)."""
CASES = [
    ("in a winter night", "2026-01-10T20:00", "06:00", "2026-01-11T05:00"),
    ("later today", "2026-01-10T04:00", "06:00", "2026-01-10T05:00"),
    ("now is not next", "2026-01-10T05:00", "06:00", "2026-01-11T05:00"),
    ("over the last hour of winter", "2026-03-28T20:00", "06:00", "2026-03-29T04:00"),
    ("over the last hour of summer", "2026-10-24T18:00", "06:00", "2026-10-25T05:00"),
    ("the first of two", "2026-10-24T18:00", "02:30", "2026-10-25T00:30"),
    ("the second of two", "2026-10-25T00:45", "02:30", "2026-10-25T01:30"),
    ("over New Year", "2026-12-31T22:59", "00:10", "2026-12-31T23:10"),
    ("on to a leap day", "2028-02-28T20:00", "06:00", "2028-02-29T05:00"),
    ("a summer's day, said in winter", "2026-01-10T20:00", "2026-07-01T06:00", "2026-07-01T04:00"),
    ("a winter's day, said in summer", "2026-07-01T20:00", "2026-12-01T06:00", "2026-12-01T05:00"),
    ("a time that tells its zone", "2026-01-10T20:00", "2026-07-01T06:00+09:00", "2026-06-30T21:00"),
]


def _utc(text: str) -> datetime:
    return datetime.fromisoformat(text).replace(tzinfo=UTC)


@pytest.mark.parametrize(("said_at", "text", "meant"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_a_time_is_that_of_the_wall_on_its_own_day(said_at: str, text: str, meant: str) -> None:
    assert moment(text, "--until", _utc(said_at), BERLIN) == _utc(meant)
    if os.name != "nt":
        with hung_in("Europe/Berlin"):
            assert moment(text, "--until", _utc(said_at)) == _utc(meant), "by this machine's own zone"


def test_what_is_no_time_is_refused() -> None:
    with pytest.raises(RequestError, match=r"--until: got '25:00', needed is a time such as 22:00"):
        moment("25:00", "--until", _utc("2026-01-10T20:00"), BERLIN)
