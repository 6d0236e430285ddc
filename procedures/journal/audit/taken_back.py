"""What was taken back of a run after it had finished: sets of before rest on dwells that count no more.

A set names the content of the journal that it was made of, which the journal still tells of each of its earlier ends.
So whether a set is meant is told by no clock.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from procedures.journal.journal_reader import JournalReader
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import keys_in
from procedures.records.dwells import Event
from procedures.records.states import State

_BY_THE_RUN = "calrig"
"""Who took dwells back where it was the run itself."""


@dataclass(frozen=True)
class TakenBack:
    """Dwells that were taken back after an end of the run."""

    run_id: str
    dwells: int
    by: str
    """Who took them back; of several words the last, for all of the last four."""
    utc: datetime
    reason: str
    cause: str
    """``void``, ``redo``, ``salvage`` or what in the run itself took them back."""

    @property
    def because(self) -> str:
        """Why a set of before must not be used, as its withdrawal has it."""
        return f"{self._counted} taken back after it was made: {self.reason.strip()}"

    def __str__(self) -> str:
        """Return who took back how many dwells of the run, when and why."""
        return (
            f"{self._counted} taken back after it was made, by {self.by} on "
            f"{self.utc:%Y-%m-%d} (UTC): {self.reason.strip().rstrip('.')}"
        )

    @property
    def _counted(self) -> str:
        of = f"of its run {self.run_id}"
        return f"1 dwell {of} was" if self.dwells == 1 else f"{self.dwells} dwells {of} were"


def taken_back_since(run: Path) -> Mapping[str, TakenBack]:
    """Return the content of the journal at each end of the run to what was taken back after it.

    An end after which nothing was taken back is missing. ``run``: its folder. Raises: JournalError.
    """
    with JournalReader.open(run) as reader:
        words = [event for event in reader.events(VOIDED) if keys_in(event)]
        if not words:
            return {}
        ends = [event.sequence for event in reader.events("state") if event.detail.get("to") == State.FINISHED]
        _, *contents = reader.contents()
        run_id = reader.header.run_id
    later = {content: [word for word in words if word.sequence > end] for end, content in zip(ends, contents)}  # noqa: B905  the present end has no content of before
    return {content: _of(run_id, found) for content, found in later.items() if found}


def _of(run_id: str, words: list[Event]) -> TakenBack:
    last = words[-1]
    dwells = {key for word in words for key in keys_in(word)}
    by, reason, cause = (str(last.detail.get(name) or "") for name in ("by", "reason", "cause"))
    return TakenBack(run_id, len(dwells), by or _BY_THE_RUN, last.utc, reason, cause)
