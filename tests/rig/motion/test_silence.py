"""How long a silent engine is borne: by what its axes were told, and by what their cables bear."""

import pytest

from rig.abilities.longest_reading import LONGEST_READING_S
from rig.motion.expectation import Moving, Standing, Task, Turning
from rig.motion.silence import PART_OF_WRAP, SHORTEST_S, TURNING_S, silence_s

STANDS = Standing(0.0, is_homed=True)
MOVES = Moving(0.0, 90.0, 20.0, 0.0)


@pytest.mark.parametrize("task", [STANDS, MOVES])
def test_where_nothing_turns_a_silence_lasts_as_long_as_a_reading(task: Task) -> None:
    assert silence_s([(task, 5.0), (STANDS, None)]) == LONGEST_READING_S


@pytest.mark.parametrize("rate_dps", [-40.0, 0.5, 200.0])
@pytest.mark.parametrize("wrap_turns", [None, 1.0, 5.0])
def test_what_turns_unseen_is_a_part_of_what_the_cables_bear_or_what_the_shortest_silence_takes(
    rate_dps: float, wrap_turns: float | None
) -> None:
    turning = Turning(min(rate_dps, 0.0), max(rate_dps, 0.0))
    allowed_s = silence_s([(MOVES, None), (turning, wrap_turns)])
    assert SHORTEST_S <= allowed_s <= TURNING_S
    if wrap_turns is not None and allowed_s > SHORTEST_S:
        assert allowed_s * abs(rate_dps) <= PART_OF_WRAP * 360.0 * wrap_turns * (1.0 + 1e-12)
