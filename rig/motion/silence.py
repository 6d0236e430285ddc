"""For how long the stop guard bears an engine that gives no sign of life, by what the axes were told last.

A move ends at its target by itself, so an engine may be silent for as long as its longest reading takes. A turn ends
by nothing but a stop. An engine at work gives a sign of life at every look, at every exchange of bytes and at every
slice of a wait: a few of them missed say that it hangs.
"""

from collections.abc import Iterable

from rig.abilities.longest_reading import LONGEST_READING_S
from rig.motion.expectation import Task, Turning

TURNING_S, SHORTEST_S = 5.0, 3.0
"""While an axis turns; and where its cables would be at their end sooner. At a load of 19 on two processors the longest
gap between two signs of life was 0.26 s."""
PART_OF_WRAP = 0.25
"""Of the revolutions that cables bear: no more is to be turned unseen, unless that takes less than the shortest."""


def silence_s(tasks: Iterable[tuple[Task, float | None]]) -> float:
    """Return the allowed silence of a rig whose axes were told this; with each, what its cables bear, revolutions."""
    allowed_s = LONGEST_READING_S
    for task, wrap_turns in tasks:
        if isinstance(task, Turning):
            allowed_s = min(allowed_s, TURNING_S)
            if wrap_turns is not None and task.top_dps > 0.0:
                allowed_s = min(allowed_s, PART_OF_WRAP * 360.0 * wrap_turns / task.top_dps)
    return max(allowed_s, SHORTEST_S)
