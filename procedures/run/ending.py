"""How a run ends, and what leads to each end.

A device that is left quiet on the way out of an error may fail itself, and Python hands on that second error. So the
rule for all of them: the first error that decided how the run ends is told, with its person, reason and cause; what
failed behind it is told behind it. Whether axes stand is told by the last stop of the run, not by one before. A fault
that a device reported on the way out trips the run whoever ended it: a person has to look.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Protocol

from procedures.errors import ExitStatus, ProcedureError, StorageFailed
from procedures.journal.sidecar.last_words import MOVED, REPLACED, TAKES_NOTHING, refusal
from procedures.records.states import EXIT_STATUS, State, state_sentence
from procedures.run.judgement.alarm import CHAMBER, TrustLost
from rig.defects import defect_text
from rig.errors import (
    ChamberFault,
    DeviceFault,
    DeviceRefused,
    FileContradicted,
    GuardLost,
    LinkLost,
    MotionBreach,
    RequestRefused,
    RigError,
    WaitEnded,
)
from rig.local_time import at_both
from rig.motion.move import NotSeenAtRest

NO_RUN = "no run"
"""The cause where it did not let one begin."""
PROCESS = "process"
"""The cause of an ending that the process' own growth forced."""

DEVICE = "device"
"""The cause where a device reported a fault."""
BROKEN_LINE = "broken line"
"""The cause where a line broke under an axis that was to be stopped, and no stop reached it."""
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
    met: tuple[BaseException, ...] = ()
    """What failed behind that, on the way out, the first one first."""
    requested_utc: datetime | None = None
    """When the run heard that somebody asked for it, by the rig's clock; None where nobody asked the run itself."""

    @property
    def fault_met(self) -> str:
        """The cause where a device reported a fault on the way out; empty where none did."""
        faults = [
            error for error in self.met if isinstance(error, DeviceFault) and not isinstance(error, NotSeenAtRest)
        ]
        return _cause_of(faults[0]) if faults else ""

    def met_in_words(self, *, last_stop_failed: bool) -> list[str]:
        """Return what failed on the way out, a sentence each; ``last_stop_failed``: the last stop failed as well."""
        sentences: list[str] = []
        for error in reversed(self.met):
            if last_stop_failed and isinstance(error, NotSeenAtRest):
                continue
            stop = f"a stop on the way out failed: {error.faults}" if isinstance(error, NotSeenAtRest) else ""
            if not any((stop or str(error)) in later for later in (self.reason, *sentences)):
                sentences.insert(0, stop or str(error))
        return sentences

    def requested(self, decided_utc: datetime) -> list[str]:
        """Return the reason, where somebody asked with what and when: of a run whose axes are not known to rest.

        ``decided_utc``: when it began to end, before it was made safe, which may take minutes.
        """
        if self.state not in (State.STOPPED, State.ABORTED) or not self.by:
            return [self.reason] if self.reason else []
        said = f": {self.reason}" if self.reason else ""
        return [f"the run was {self.state} {at_both(self.requested_utc or decided_utc, to_the_second=True)}{said}"]


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


class AsksForEnds(Protocol):
    """Who hears what people and the system ask of a run: :class:`procedures.run.steering.Steering`."""

    @property
    def at_once(self) -> Ending | None: ...


_DECIDES = (RunEnds, WaitEnded, StorageFailed, MotionBreach, GuardLost, KeyboardInterrupt)
"""Errors that end a run whatever fails behind them."""
_FORESEEN = (RunEnds, RigError, ProcedureError, KeyboardInterrupt)
"""Every other one is a defect."""


def decision(error: BaseException | None, before: BaseException | None) -> BaseException | None:
    """Return the first error on the way to this one that decided how the run ends, or None.

    ``before``: what whoever began the run was handling then. What lies before a loss of trust was answered by the epoch
    behind it, and a decision that was raised from an error speaks for it.
    """
    decided = None
    while error is not None and error is not before and not isinstance(error, TrustLost):
        if isinstance(error, _DECIDES):
            decided = error
            if isinstance(error, RunEnds) and error.__cause__ is not None:
                break
        error = error.__context__
    return decided


def defect_of(error: BaseException, before: BaseException | None) -> BaseException | None:
    """Return the error that calrig did not foresee, also behind a stop that failed on its way out; None where none."""
    why = _hidden(error, before) or error
    return None if isinstance(why, _FORESEEN) else why


def ending_of(error: BaseException, before: BaseException | None, steering: AsksForEnds, run_dir: Path) -> Ending:
    """Return how a run ends by an error."""
    decided = decision(error, before)
    ending = _ending_by(decided or error, steering, run_dir)
    if decided is error:
        return ending
    if decided is None:
        return _with_request(_by_what_a_stop_hides(ending, _hidden(error, before)), steering.at_once)
    if not isinstance(error, _FORESEEN):
        return Ending(State.FAILED, f"{_ending_by(error, steering, run_dir).reason}; {_to_be(ending)}")
    return replace(ending, met=tuple(_met(error, decided)))


def _by_what_a_stop_hides(ending: Ending, hidden: BaseException | None) -> Ending:
    """Return it by the error on whose way out a stop failed, where there is one."""
    if hidden is None:
        return ending
    return replace(ending, reason=str(hidden), cause=BROKEN_LINE if isinstance(hidden, LinkLost) else ending.cause)


def _with_request(ending: Ending, request: Ending | None) -> Ending:
    """Return it with who asked for another end while what ended it was still on its way."""
    return ending if request is None else replace(ending, reason=f"{ending.reason}; meanwhile {_to_be(request)}")


def _hidden(error: BaseException, before: BaseException | None) -> BaseException | None:
    """Return on the way out of what a stop was sent that failed."""
    hidden = error.__context__ if isinstance(error, NotSeenAtRest) else None
    return None if hidden is before or isinstance(hidden, TrustLost) else hidden


def _met(last: BaseException, decided: BaseException) -> list[BaseException]:
    """Return what of calrig's own failed behind a decision, the first one first."""
    met: list[BaseException] = []
    error: BaseException | None = last
    while error is not None and error is not decided:
        if isinstance(error, _FORESEEN):
            met.insert(0, error)
        error = error.__context__
    return met


def _ending_by(error: BaseException, steering: AsksForEnds, run_dir: Path) -> Ending:
    match error:
        case RunEnds():
            return error.ending
        case WaitEnded():  # where nobody asked here, the stop guard heard it first
            return steering.at_once or Ending(State.ABORTED, error.what, error.by)
        case StorageFailed():
            sentence, cause = refusal(run_dir, error)
            unwritten = f"; {_to_be(steering.at_once)}" if steering.at_once is not None else ""
            return Ending(State.STOPPED, f"{sentence}{unwritten}", cause=cause)
        case DeviceFault() | DeviceRefused() | RequestRefused():
            return Ending(State.TRIPPED, str(error), cause=_cause_of(error))
        case RigError() | ProcedureError():
            return Ending(State.FAILED, str(error))
        case KeyboardInterrupt():
            return Ending(State.ABORTED, "interrupted from the keyboard", "Ctrl-C")
        case _:
            return Ending(State.FAILED, defect_text(error))


def _cause_of(error: RigError) -> str:
    if isinstance(error, MotionBreach | GuardLost):
        return "supervision"
    if isinstance(error, FileContradicted):
        return "rig file"
    return CHAMBER if isinstance(error, ChamberFault) else DEVICE


def _to_be(ending: Ending) -> str:
    """Say how a run would have ended, and by whom, where something else decided in the end."""
    return f"it was to be {ending.state}: {state_sentence(ending.reason, ending.by)}"
