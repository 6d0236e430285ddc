"""Whatever stopped a run, what it says to do next holds whole commands, which are pasted as they are."""

import re
import shlex

import pytest
from report_dwells import dwell, event

from procedures.cli.main import make_app
from procedures.journal.status.stop_advice import (
    ADVICE,
    StopNumbers,
    advice,
    held_before,
    left_in_doubt,
    next_step,
    numbers_of,
)
from procedures.records.states import RESUMABLE, State

RUN = "/data/runs of today/night-1"
COMMAND = re.compile(rf"calrig [a-z]+ {shlex.quote(RUN)}(?: --[a-z]+(?:-[a-z]+)*(?: (?:NAME|TEXT|\d+))?)*")
STATES = (State.HELD, State.TRIPPED, State.FAILED, State.STOPPED, State.INTERRUPTED)
NUMBERS = numbers_of(
    RUN,
    [event(20, "common_mode", 20, held=True, doubtful=[12, 13, 14])],
    [dwell(step, replication=1 + (step > 12)) for step in range(3, 15)],
)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("cause", [*ADVICE, "never met before"])
@pytest.mark.parametrize("numbers", [NUMBERS, StopNumbers(shlex.quote(RUN))], ids=["in mid-run", "before any dwell"])
def test_every_command_of_every_cause_and_state_is_one_that_the_command_line_takes(
    cause: str, state: State, numbers: StopNumbers
) -> None:
    said = advice(cause, state, numbers)
    commands = [shlex.split(found)[1:] for found in COMMAND.findall(said)]
    assert len(commands) == said.count(shlex.quote(RUN)), said
    assert commands or state is State.HELD or cause == "no run", "what goes on by itself needs none"
    for words in commands:
        make_app(words[0]).parse_args(words, exit_on_error=False, print_error=False)
    assert not re.search(r"\b(RUN|STEP|N|REASON)\b|[{}]", said)
    verbs = {words[0] for words in commands}
    assert verbs.isdisjoint({"continue", "stop"}) or state is State.HELD, "no process takes them"
    signed = [words for words in commands if words[0] == "resume" and "--operator" in words]
    assert signed or state is not State.TRIPPED or cause == "no run", "a trip is answered for by name"


def test_the_numbers_are_those_of_the_hold_and_of_what_counts() -> None:
    assert NUMBERS.newest == 14
    said, run = advice("table", State.HELD, NUMBERS), shlex.quote(RUN)
    signed = "--operator NAME --reason TEXT"
    assert (
        f"calrig stop {run}, then calrig void {run} --from 12 {signed} takes back 3 dwells of the design, "
        f"or calrig redo {run} --replication 1 {signed} and calrig redo {run} --replication 2 {signed} take back "
        f"12 dwells of the design; then calrig resume {run}. calrig continue {run} keeps them"
    ) in said


def test_of_both_ways_back_the_one_that_takes_back_fewer_dwells_comes_first() -> None:
    dwells = [dwell(step, replication=1 + step // 4) for step in range(12)]
    early = numbers_of(RUN, [event(20, "common_mode", 20, held=True, doubtful=[4, 5])], dwells)
    assert early.ways_back.startswith(f"calrig redo {shlex.quote(RUN)} --replication 2 ")
    assert re.findall(r"back (\d+) dwells", early.ways_back) == ["4", "8"]


def test_nothing_is_named_of_dwells_that_were_taken_back_since() -> None:
    taken_back = [
        event(20, "common_mode", 20, held=True, doubtful=[12, 13]),
        event(21, "voided", 21, dwells=[[12, 1, 1], [13, 1, 1]]),
    ]
    assert numbers_of(RUN, taken_back, []).ways_back == ""


@pytest.mark.parametrize("state", [state for state in State if state is not State.FINISHED])
@pytest.mark.parametrize("before", ["", "table"])
def test_every_state_has_one_next_step_with_whole_commands(state: State, before: str) -> None:
    said = next_step(state, "never met before", NUMBERS, before)
    commands = [shlex.split(found)[1:] for found in COMMAND.findall(said)]
    assert len(commands) == said.count(shlex.quote(RUN)), said
    for words in commands:
        make_app(words[0]).parse_args(words, exit_on_error=False, print_error=False)
    resumed = "resume" in {words[0] for words in commands}
    assert resumed == (state in (*RESUMABLE, State.HELD)) or state is State.HELD, said


def test_a_run_that_failed_is_not_resumed() -> None:
    assert "calrig resume" not in advice("never met before", State.FAILED, NUMBERS)
    assert "begin a new one" in advice("never met before", State.FAILED, NUMBERS)


def test_what_visits_left_in_doubt_is_less_by_what_was_taken_back_since() -> None:
    events = [
        event(20, "common_mode", 20, kinds=["meter-gain"], doubtful=[5, 6]),
        event(21, "voided", 21, dwells=[[6, 1, 1], [7, 1, 1]]),
        event(22, "common_mode", 22, kinds=["table-rotation"], held=True, doubtful=[7, 8]),
        event(23, "common_mode", 23, kinds=["meter-gain"], doubtful=[9]),
    ]
    of_meter = left_in_doubt(events, lambda found: found.detail["kinds"] == ["meter-gain"])
    assert of_meter == [{5}, {9}]
    again = numbers_of(RUN, events, [dwell(step, replication=1) for step in range(5, 9)])
    assert "--from 7 " in again.ways_back, "measured again, and in doubt again"


def test_the_hold_that_a_stop_ended_is_the_one_before_it() -> None:
    held = event(20, "state", 20, to="held", cause="table")
    assert held_before([held, event(21, "state", 21, to="stopped")]) == "table"
    assert held_before([held, event(21, "state", 21, to="running"), event(22, "state", 22, to="stopped")]) == ""
