"""Where a run stands in words and for monitoring: a reader's own time beside UTC, and text that Prometheus takes."""

import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone

import pytest

from procedures.journal.sidecar.live import Live, Target
from procedures.journal.status.metrics import RunFigures, metrics_text
from procedures.journal.status.standing_words import live_rows, rows_of
from procedures.records.progress import Progress
from procedures.records.states import State
from rig.local_time import at_both

NOW = datetime(2026, 3, 1, 4, 0, tzinfo=UTC)
MOMENT = Progress("dwell", State.RUNNING, 1004, 1482, 5, 6, 7.43, NOW + timedelta(minutes=40), "", rejected=3)
SOAKING = Live(
    phase="soaking", phase_since_utc=NOW - timedelta(minutes=3), setpoint_degc={"air": 20.0},
    temperature_degc={"air": 20.02}, soak_left_s=720.0, now=Target(7, "design", 2, {"pitch": -70.0, "roll": 90.0}),
    next=Target(8, "design", 2, {"pitch": -70.0, "roll": 120.0}), positions_deg={"pitch": -70.0, "roll": 90.0},
    written_utc=NOW,
)  # fmt: skip
BERLIN = timezone(timedelta(hours=1))
LINE = re.compile(r'[a-z_]+\{(?:[a-z]+="(?:[^"\\\n]|\\["\\n])*",?)+\} [-+0-9.e]+')
"""Of the exposition format: https://prometheus.io/docs/instrumenting/exposition_formats/."""


def test_rows_tell_everything_that_a_person_asks_at_night() -> None:
    assert dict(rows_of(MOMENT, "", SOAKING, NOW, BERLIN)) == {
        "state": "RUNNING",
        "done": "1004 of 1482 dwells (67 %), replication 5 of 6, 3 rejected, 7.43 a minute",
        "ends": "Sun 05:40 local (2026-03-01 04:40 UTC)",
        "now": "soaking for 3 min 00 s",
        "at": "step 7 (design), pitch -70, roll +90; seen at pitch -70, roll +90",
        "next": "step 8 (design), pitch -70, roll +120",
        "air": "20.02 °C, set to 20",
        "soak": "12 min left at the least",
    }


@pytest.mark.parametrize("state", [State.FINISHED, State.HELD, State.PAUSED, State.TRIPPED])
def test_what_does_not_go_on_is_not_said_to_end(state: State) -> None:
    """Whoever waits for a person or for a cable has no end: the one that was told before is over by then."""
    rows = dict(rows_of(replace(MOMENT, state=state), "", None, NOW, BERLIN))
    assert list(rows) == ["state", "done"]


def test_a_reason_is_told_in_full() -> None:
    reason = "environment.air: got 22.41 °C, allowed 19 to 22 °C " + "and more " * 40
    assert rows_of(MOMENT, reason, None, NOW)[0][1] == f"RUNNING: {reason}"


def test_where_the_reader_lives_by_utc_it_is_told_once() -> None:
    assert at_both(NOW, UTC) == "2026-03-01 04:00 UTC"


def test_every_line_of_the_metrics_is_in_the_format_whatever_a_run_is_called() -> None:
    text = metrics_text(
        [RunFigures('a "night"\\\n', MOMENT, SOAKING, True, None), RunFigures("b", MOMENT, None, False, 2)]
    )
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert [line for line in lines if not LINE.fullmatch(line)] == []
    assert 'calrig_run_dwells_done{run="b"} 1004' in lines
    assert [line for line in lines if line.startswith("calrig_run_damaged")] == ['calrig_run_damaged{run="b"} 2']
    assert sum(line.startswith("calrig_run_state") and line.endswith(" 1") for line in lines) == 2
    heads = [line.split()[2] for line in text.splitlines() if line.startswith("# TYPE")]
    assert len(heads) == len(set(heads)), "one block a metric"


def test_a_phase_tells_how_long_it_usually_takes() -> None:
    live = Live(phase="settling", phase_since_utc=NOW, usual_s=3.0, seldom_over_s=4.6)
    assert dict(live_rows(live, NOW))["now"] == "settling for 0 s (usually 3 s, seldom over 4.6 s)"
    plain = Live(phase="reading", phase_since_utc=NOW, usual_s=720.0, seldom_over_s=720.0)
    assert dict(live_rows(plain, NOW))["now"] == "reading for 0 s (usually 12 min)"


def test_an_end_says_when_it_is_late_in_one_case_of_ten() -> None:
    ends, late = NOW + timedelta(hours=1), NOW + timedelta(hours=2)
    progress = replace(MOMENT, eta_utc=ends, late_utc=late)
    found = dict(rows_of(progress, "", None, NOW, UTC))["ends"]
    assert found == "2026-03-01 05:00 UTC; later than 2026-03-01 06:00 UTC in one case of ten"


@pytest.mark.parametrize(
    ("phase", "state", "ahead"),
    [("soaking", State.RUNNING, "the soak"), ("reading", State.RUNNING, "this dwell"),
     ("moving", State.CHECKING, "the check set"), ("soaking", State.CHECKING, "the soak and the check set")],
)  # fmt: skip
def test_what_was_asked_and_waits_is_told_with_what_it_waits_for(phase: str, state: State, ahead: str) -> None:
    live = Live(phase=phase, pending_request="pause, by anna")
    rows = rows_of(replace(MOMENT, state=state), "", live, NOW, BERLIN)
    assert ("asked", f"pause, by anna: waits for the end of {ahead}") in rows
    assert "asked" not in dict(rows_of(MOMENT, "", Live(phase=phase), NOW, BERLIN))
