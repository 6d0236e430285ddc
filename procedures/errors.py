"""Errors of the procedures and the exit status each leads to.

0 done, 1 failed, 2 the request or a file is wrong, 3 held by an interlock or waiting for a person,
4 aborted by the operator.
"""

from datetime import datetime
from enum import IntEnum


class ExitStatus(IntEnum):
    """What the shell sees."""

    DONE = 0
    FAILED = 1
    WRONG_REQUEST = 2
    HELD = 3
    ABORTED = 4


class ProcedureError(Exception):
    """Any error of this package: the base, never raised itself."""

    exit_status = ExitStatus.FAILED


class PlanError(ProcedureError):
    """The procedure asks for what the rig cannot do, or for a design that cannot determine its model."""

    exit_status = ExitStatus.WRONG_REQUEST


class RequestError(ProcedureError):
    """The command asks for something that is not there or not allowed now; nothing was changed."""

    exit_status = ExitStatus.WRONG_REQUEST


class JournalError(ProcedureError):
    """The journal is damaged, of another version, or not a journal; it was left as it is."""

    exit_status = ExitStatus.WRONG_REQUEST


class JournalTakenAway(JournalError):
    """The journal of the run is not where the run was; the sentence says where what was saved of it is."""

    def __init__(self, sentence: str, stopped_utc: datetime) -> None:
        super().__init__(sentence)
        self.stopped_utc = stopped_utc
        """When the run ended by that."""


class RunFailed(ProcedureError):
    """The run cannot go on; axes are at rest and the journal is closed."""

    exit_status = ExitStatus.FAILED


class NotSolved(ProcedureError):
    """A defect kept a run from being solved: its dwells are kept, and its folder has a page that says so."""

    exit_status = ExitStatus.FAILED


class StorageFailed(ProcedureError):
    """The disk refuses the journal (full, read-only, broken, held): what was committed before is intact."""

    exit_status = ExitStatus.FAILED


class JournalReplaced(StorageFailed):
    """A file of the open journal was removed, replaced or changed by another hand: only the process still has it."""
