"""One table of states: what it allows, and that the docs show it."""

import pytest
from example_files import ROOT

from procedures.errors import RequestError
from procedures.records.states import (
    ACTIVE,
    ANSWERED_FOR,
    EXIT_STATUS,
    RESUMABLE,
    TRANSITIONS,
    State,
    diagram,
    require_transition,
)


def test_the_page_in_the_docs_is_drawn_from_the_table() -> None:
    assert (ROOT / "docs" / "run-states.md").read_text(encoding="utf-8") == diagram()


def test_the_table_has_each_line_once() -> None:
    lines = [(line.source, line.target) for line in TRANSITIONS]
    assert len(lines) == len(set(lines))


def test_every_state_is_reached_from_planned() -> None:
    reached = {State.PLANNED}
    for _ in State:
        reached |= {line.target for line in TRANSITIONS if line.source in reached}
    assert reached == set(State)


@pytest.mark.parametrize("state", [State.FAILED, State.CLOSED])
def test_nothing_leaves_an_end(state: State) -> None:
    assert not [line for line in TRANSITIONS if line.source is state]


@pytest.mark.parametrize("state", ACTIVE)
def test_every_active_state_can_be_stopped_aborted_fail_and_lose_its_owner(state: State) -> None:
    for target in (State.STOPPED, State.ABORTED, State.FAILED, State.INTERRUPTED):
        require_transition(state, target)


def test_a_trip_or_an_abort_is_left_only_by_a_resume_or_a_close() -> None:
    for latched in ANSWERED_FOR:
        assert [(line.target, line.cause) for line in TRANSITIONS if line.source is latched] == [
            (State.CHECKING, "resume"),
            (State.CLOSED, "close, for good"),
        ]
    assert set(RESUMABLE) == {line.source for line in TRANSITIONS if line.cause == "resume"}


def test_a_transition_that_is_not_in_the_table_is_refused_with_those_that_are() -> None:
    with pytest.raises(RequestError, match=r"from paused to finished \(allowed: running, tripped, stopped"):
        require_transition(State.PAUSED, State.FINISHED)
    with pytest.raises(RequestError, match="none, it is an end"):
        require_transition(State.CLOSED, State.RUNNING)


def test_exit_statuses_are_those_of_the_command() -> None:
    assert {state.value: int(status) for state, status in EXIT_STATUS.items()} == {
        "finished": 0, "failed": 1, "held": 3, "tripped": 3, "stopped": 4, "aborted": 4,
    }  # fmt: skip
