from datetime import timedelta

import pytest
from report_dwells import event

from procedures.journal.audit.audit_trail import interruptions_in, missing_in, notes_in


def test_a_pause_lasts_from_leaving_running_to_coming_back() -> None:
    events = [
        event(1, "state", 0, to="running"),
        event(2, "state", 10, to="paused", by="A", reason="lunch"),
        event(3, "state", 40, to="running"),
        event(4, "state", 90, to="finished"),
    ]
    (pause,) = interruptions_in(events)
    assert (pause.what, pause.by, pause.reason) == ("paused", "A", "lunch")
    assert pause.ended_utc is not None
    assert (pause.ended_utc - pause.began_utc).total_seconds() == 1800


def test_a_killed_run_was_interrupted_from_its_last_sign_of_life() -> None:
    events = [
        event(1, "state", 0, to="running"),
        event(2, "intent", 10),
        event(3, "opened", 70, operator="A", epoch=2),
        event(4, "state", 70, to="interrupted", by="A", reason="power cut"),
        event(5, "state", 71, to="checking"),
        event(6, "state", 80, to="running"),
    ]
    (kill,) = interruptions_in(events)
    assert (kill.what, kill.by) == ("interrupted", "A")
    assert kill.reason == "power cut; counted from its last sign of life"
    assert kill.began_utc == events[1].utc
    assert kill.ended_utc == events[5].utc


@pytest.mark.parametrize(("guarded_s", "began_s"), [(None, 10), (11, 11), (5, 10), (9999, 10)])
def test_what_the_resume_writes_is_no_sign_of_life_of_the_run_that_was_killed(
    guarded_s: float | None, began_s: float
) -> None:
    """Killed at 20:00 and resumed at 07:00 it stood as under a minute at 07:00: what was left of alerts had been
    journalled first. The stop guard saw the end."""
    running = event(1, "state", 0, to="running")
    guarded = [] if guarded_s is None else [
        event(4, "stop_guard", 700, stopped_utc=(running.utc + timedelta(minutes=guarded_s)).isoformat())
    ]  # fmt: skip
    events = [
        running,
        event(2, "intent", 10),
        event(3, "opened", 700, operator="A", epoch=2),
        *guarded,
        event(5, "alert", 700),
        event(6, "state", 700, to="interrupted", by="", reason="the process ended without a last line"),
        event(7, "state", 701, to="checking", by="A"),
        event(8, "state", 702, to="running"),
        event(9, "alert", 710),
        event(10, "state", 720, to="interrupted"),
    ]
    first, second = interruptions_in(events)
    assert (first.began_utc - running.utc).total_seconds() == 60.0 * began_s
    assert first.reason == "the process ended without a last line; counted from its last sign of life"
    assert second.began_utc == events[-2].utc


def test_a_stretch_that_changes_its_name_is_one_interruption() -> None:
    states = ["running", "held", "tripped", "checking", "running"]
    events = [event(index, "state", 10.0 * index, to=state) for index, state in enumerate(states)]
    (trip,) = interruptions_in(events)
    assert trip.what == "held"
    assert trip.ended_utc == events[-1].utc


def test_whoever_takes_a_tripped_run_up_is_named_with_the_reason() -> None:
    events = [
        event(1, "state", 0, to="running"),
        event(2, "state", 5, to="tripped", reason="stop button"),
        event(3, "state", 60, to="checking", by="B", reason="button was leaned on"),
        event(4, "state", 90, to="running"),
    ]
    (trip,) = interruptions_in(events)
    assert (trip.reason, trip.resumed_by, trip.resumed_because) == ("stop button", "B", "button was leaned on")


def test_what_people_answered_for_and_what_was_taken_back_stand_among_the_notes() -> None:
    events = [
        event(1, "override", 0, by="B", reason="typo", differences=["rig file: rig.name: was 1, is 2"]),
        event(2, "dropped", 5, sensor="SN2", step=7, reason="step 7: rejected 3 times"),
        event(3, "voided", 6, by="A", reason="bumped", dwells=[[1, 1, 1], [2, 1, 1]], remounted=True),
        event(4, "ack", 7, by="A", text="on my way"),
    ]
    assert [(note.by, note.text) for note in notes_in(events)] == [
        ("B", "went on over changes: rig file: rig.name: was 1, is 2: typo"),
        ("", "SN2 was dropped: step 7: rejected 3 times"),
        ("A", "2 dwells taken back: bumped; the package was moved"),
        ("A", "acknowledged. on my way"),
    ]


def test_what_was_missing_at_the_start_is_read_from_its_event() -> None:
    assert missing_in([event(1, "readiness", 0, engineering=["level.before: none"])]) == ("level.before: none",)


def test_an_aborted_run_never_went_on() -> None:
    events = [event(1, "state", 0, to="running"), event(2, "state", 5, to="aborted", by="A")]
    assert interruptions_in(events)[0].ended_utc is None


def test_a_clean_run_has_no_interruption() -> None:
    events = [event(index, "state", index, to=state) for index, state in enumerate(("checking", "running", "finished"))]
    assert interruptions_in(events) == ()


def test_notes_are_taken_from_their_events() -> None:
    events = [event(1, "identities", 0, **{"axes.pitch": "TWIN"}), event(2, "note", 5, text="bumped the table", by="A")]
    assert notes_in(events)[0].text == "bumped the table"
