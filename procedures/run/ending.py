"""How a run ends, and what leads to each end."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from procedures.errors import ExitStatus
from procedures.journal.sidecar.last_words import MOVED, REPLACED, TAKES_NOTHING
from procedures.records.states import EXIT_STATUS, State
from rig.errors import RigError
from rig.local_time import at_both
from rig.motion.move import NotSeenAtRest

NO_RUN = "no run"
"""The cause where it did not let one begin."""
PROCESS = "process"
"""The cause of an ending that the process' own growth forced."""

DIED = "process died"
"""The cause where it ended without a word, as its stop guard tells."""


@dataclass(frozen=True, slots=True)
class Ending:
    """The state a run is to be left in and why."""

    state: State
    reason: str = ""
    by: str = ""
    cause: str = ""
    """A word that resume understands, such as ``seam``; empty otherwise."""

    def requested(self, now_utc: datetime) -> list[str]:
        """Return the reason, where somebody asked with what and when: of a run whose axes are not known to rest."""
        if self.state not in (State.STOPPED, State.ABORTED) or not self.by:
            return [self.reason] if self.reason else []
        said = f": {self.reason}" if self.reason else ""
        return [f"the run was {self.state} {at_both(now_utc, to_the_second=True)}{said}"]


def reason_of(error: Exception) -> str:
    """Return why a run ends by an error. Whether axes stand is told by its last stop, not by one that failed before.

    Such a stop, on the way out of a lost line, hides why it was sent.
    """
    before = error.__context__
    return str(before if isinstance(error, NotSeenAtRest) and isinstance(before, RigError) else error)


class RunEnds(Exception):
    """Leaves the work at a safe place with the ending that was decided."""

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending.reason)
        self.ending = ending


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run came to."""

    state: State
    reason: str
    dwells_done: int
    """Accepted design dwells."""
    dwells_planned: int
    cause: str = ""
    positions_deg: Mapping[str, float] = field(default_factory=dict)
    """Where the axes were seen to rest at the end."""
    copy: Path | None = None
    """The folder that holds the journal where that of the run does not any more; None where it does, or none."""

    @property
    def is_journal_away(self) -> bool:
        """Whether what stands in the folder of the run, if anything, is not its journal."""
        return self.state is State.INTERRUPTED and self.cause in (MOVED, REPLACED)

    @property
    def exit_status(self) -> ExitStatus:
        """A run that the disk or its own process stopped has failed, though it can be resumed: nobody asked for it."""
        return ExitStatus.FAILED if self.cause in (*TAKES_NOTHING, PROCESS) else EXIT_STATUS[self.state]
