from report_dwells import event

from procedures.report.trail import identities_in, interruptions_in, notes_in, seam_steps_in


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
    assert (kill.what, kill.by, kill.reason) == ("interrupted", "A", "power cut")
    assert kill.began_utc == events[1].utc
    assert kill.ended_utc == events[5].utc


def test_a_stretch_that_changes_its_name_is_one_interruption() -> None:
    states = ["running", "held", "tripped", "checking", "running"]
    events = [event(place, "state", 10.0 * place, to=state) for place, state in enumerate(states)]
    (trip,) = interruptions_in(events)
    assert trip.what == "held"
    assert trip.ended_utc == events[-1].utc


def test_an_aborted_run_never_went_on() -> None:
    events = [event(1, "state", 0, to="running"), event(2, "state", 5, to="aborted", by="A")]
    assert interruptions_in(events)[0].ended_utc is None


def test_a_clean_run_has_no_interruption() -> None:
    events = [event(place, "state", place, to=state) for place, state in enumerate(("checking", "running", "finished"))]
    assert interruptions_in(events) == ()


def test_notes_and_identities_are_taken_from_their_events() -> None:
    events = [
        event(1, "identities", 0, **{"axes.pitch": "TWIN"}),
        event(2, "note", 5, text="bumped the table", by="A"),
    ]
    assert identities_in(events) == {"axes.pitch": "TWIN"}
    assert notes_in(events)[0].text == "bumped the table"


def test_only_a_seam_that_found_a_step_is_told() -> None:
    events = [
        event(1, "seam", 0, tested=True, comparisons=18, steps=0, worst="dmm.x at step 2 changed by 1e-07 V"),
        event(2, "seam", 5, tested=False, reason="the check set was measured at another plateau"),
        event(3, "seam", 9, tested=True, comparisons=18, steps=2, worst="dmm.x at step 2 changed by 4e-05 V"),
    ]
    assert seam_steps_in(events) == ("dmm.x at step 2 changed by 4e-05 V",)
