"""Whatever stopped a run, what it says to do next holds whole commands, which are pasted as they are."""

import re
import shlex

import pytest
from report_dwells import dwell, event

from procedures.cli.main import make_app
from procedures.journal.stop_advice import ADVICE, StopNumbers, advice, numbers_of
from procedures.records.states import State

RUN = "/data/runs of today/night-1"
COMMAND = re.compile(rf"calrig [a-z]+ {shlex.quote(RUN)}(?: --[a-z]+(?: (?:NAME|TEXT|\d+))?)*")
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
    assert (NUMBERS.newest, NUMBERS.doubtful, NUMBERS.replications) == (14, 12, (1, 2))
    said = advice("table", State.HELD, NUMBERS)
    for command in ("void", "redo"):
        assert f"calrig {command} {shlex.quote(RUN)} --" in said
    assert "--from 12 " in said
    assert "--replication 1 " in said
    assert "--replication 2 " in said
    taken_back = [
        event(20, "common_mode", 20, held=True, doubtful=[12, 13]),
        event(21, "voided", 21, dwells=[[12, 1, 1], [13, 1, 1]]),
    ]
    assert numbers_of(RUN, taken_back, []).doubtful is None
