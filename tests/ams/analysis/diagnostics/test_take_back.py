"""What a command takes back is counted in the order of time, and the command that takes back fewer comes first."""

from collections.abc import Collection, Sequence

import numpy as np
import pytest

from ams.analysis.diagnostics.take_back import Measured, measured_in, ways_back, ways_back_of, ways_in_words
from ams.observations import Observations

REPLICATIONS, POINTS = 4, 20
NIGHT: Sequence[Measured] = [(step, 1 + (step - 7) // POINTS) for step in range(7, 7 + REPLICATIONS * POINTS)]
REDONE: Sequence[Measured] = [*NIGHT[POINTS:], *NIGHT[:POINTS]]
"""The first replication was measured again: its steps are the lowest, and its dwells the last."""


def taken_back(command: str, measured: Sequence[Measured]) -> set[int]:
    """Return the steps that ``calrig void`` and ``calrig redo`` are documented to take back."""
    words = command.split()
    number = int(words[words.index("--from" if words[1] == "void" else "--replication") + 1])
    if words[1] == "redo":
        return {step for step, replication in measured if replication == number}
    steps = [step for step, _ in measured]
    return set(steps[steps.index(number) :])


@pytest.mark.parametrize("measured", [NIGHT, REDONE], ids=["as planned", "the first replication again"])
@pytest.mark.parametrize("steps", [{7}, {86}, {30, 31}, {26, 27}, set(range(7, 27)), set(range(27, 87)), {7, 86}])
def test_each_way_takes_back_what_is_meant_and_as_many_as_it_says(
    measured: Sequence[Measured], steps: Collection[int]
) -> None:
    ways = ways_back(steps, measured, "night-1")
    assert len(ways) == 2
    assert ways[0].dwells <= ways[1].dwells
    for way in ways:
        gone = set[int]().union(*(taken_back(command, measured) for command in way.commands))
        assert gone >= set(steps)
        assert way.dwells == len(gone)
        assert all(" night-1 --" in command for command in way.commands)


def test_one_wrong_dwell_of_the_first_replication_costs_a_replication_and_not_the_night() -> None:
    said = ways_in_words(ways_back({7}, NIGHT, "night-1"))
    assert said.index("calrig redo night-1 --replication 1 ") < said.index("calrig void night-1 --from 7 ")
    assert "--replication 1 --operator NAME --reason TEXT takes back 20 dwells of the design, or" in said
    assert said.endswith("takes back 80 dwells of the design")


def test_rows_are_taken_in_the_order_of_time_and_rows_of_no_run_have_no_command() -> None:
    steps, replication = np.array([step for step, _ in NIGHT]), np.array([label for _, label in NIGHT])
    zeros = np.zeros(steps.size)
    time_s = np.where(replication == 1, 1000.0, 0.0) + steps
    rows = Observations(replication, steps, zeros, zeros, {}, time_s=time_s, step=steps, run="night-1")
    assert measured_in(rows) == tuple(REDONE)
    (redo, void) = ways_back_of(replication != 1, rows)
    assert [redo.dwells, void.dwells] == [60, 80]
    of_a_file = Observations(replication, steps, zeros, zeros, {}, time_s=time_s)
    assert ways_back_of(replication != 1, of_a_file) == ()
