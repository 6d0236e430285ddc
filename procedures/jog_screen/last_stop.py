"""The stop with which a bench is left: what it came to is what people are told, and what the exit status says.

Nobody is there any more who would stop what turns on. So a line that is out is waited for and opened, and the axis
behind it stopped then; where that cannot be, or another device answers there, it is said which axis may turn and what
to do.
"""

from dataclasses import dataclass, replace

from procedures.errors import ExitStatus
from rig.assembly.open_rig import Rig
from rig.errors import DeviceFault
from rig.motion import out_of_reach
from rig.motion.jog import in_doubt_in_words
from rig.motion.out_of_reach import stop_known


@dataclass(frozen=True, slots=True)
class StopOutcome:
    """What is known of the axes when all of them were told to stop."""

    failure: str = ""
    """Why not every axis is known to stand, what is known of each, and what to do; empty where all were seen to."""
    in_doubt: str = ""
    """What follows "stands still": orders that may still move one."""
    reopened: str = ""
    """Which line had to be opened again before; empty where none had."""

    @property
    def is_clean(self) -> bool:
        return not (self.failure or self.in_doubt)

    @property
    def in_words(self) -> str:
        """What people are told, without a full stop."""
        return self.failure or f"{self.reopened}every axis stands still{self.in_doubt}"

    def exit_status(self, lost: str) -> ExitStatus:
        """Return the status of a session; ``lost``: why its operator is gone, empty where he left by himself."""
        if self.failure:
            return ExitStatus.FAILED
        return ExitStatus.ABORTED if lost else ExitStatus.DONE


NOT_SEEN = StopOutcome(
    "not every axis is known to stand still: the bench ended before it saw them; go and look, and use the stop button"
    " at the machine"
)
"""Before there was a last stop."""


def stopped(rig: Rig) -> StopOutcome:
    """Stop every axis and see it stand; what another device answers than at first tells nothing of an axis."""
    try:
        stop_known(rig, rig.axes)
    except DeviceFault as error:
        return StopOutcome(str(error))
    return StopOutcome(in_doubt=in_doubt_in_words(rig.motion.in_doubt(rig.axes)))


def stopped_in_reach(rig: Rig) -> StopOutcome:
    """Stop every axis for the last time; where one turns on a line that is out, as soon as that can be opened again."""
    outcome, line = out_of_reach.stopped_in_reach(rig, lambda _unopened: stopped(rig), lambda it: bool(it.failure))
    failure = outcome.failure
    if line is not None:
        failure = f"{failure}; its line cannot be opened: {line.unopened}" if failure and line.unopened else failure
    if failure:
        return StopOutcome(f"{failure}; {'; '.join(rig.motion.in_words(rig.axes))}; go and look")
    return outcome if line is None else replace(outcome, reopened=f"{line.lost}; the line is open again, and ")
