"""What the journal of a run lost, as a finding on every sensor: nobody can tell what else the lost lines took back."""

from collections.abc import Iterable
from typing import Final

from ams.finding_kinds import FindingKind
from ams.findings import Finding
from procedures.journal.lost_events import Losses, losses_in
from procedures.records.dwells import Event

KIND: Final[FindingKind] = "record-lost"
_MOST_NAMED: Final = 8


def lost_record(events: Iterable[Event]) -> Finding | None:
    """Return what salvages of a run's journal left out; None where nothing is lost.

    Dwells alone are named and can be measured again, which is a reservation. Where events are lost no result is
    usable: they may have taken back what counts now.
    """
    lost = losses_in(events)
    if not (lost.has_events or lost.dwells):
        return None
    steps = tuple(sorted({step for step, _, _ in lost.dwells}))
    if not lost.has_events:
        return Finding(KIND, f"the journal was damaged and salvaged, and {_dwells(lost)}", True, None, steps)
    dwells = f"; {_dwells(lost)}" if lost.dwells else ""
    return Finding(
        KIND,
        f"the journal was damaged and salvaged, and {_events(lost)} of its audit trail {_are(_count(lost))} lost, "
        f"which may have taken back dwells that count here{dwells}",
        True,
        None,
        steps,
        is_held=False,
        what_to_do="ask who ran it what was taken back, and measure the run again; or release the sets from quarantine "
        "and accept the verdict by name and reason",
    )


def _count(lost: Losses) -> int:
    return len(lost.events) + lost.behind


def _events(lost: Losses) -> str:
    named = ", ".join(map(str, lost.events[:_MOST_NAMED]))
    more = _count(lost) - min(len(lost.events), _MOST_NAMED)
    which = " and ".join([*([named] if named else []), *([f"{more} more"] if more and named else [])])
    return f"{_count(lost)} {'line' if _count(lost) == 1 else 'lines'}{f' ({which})' if which else ''}"


def _dwells(lost: Losses) -> str:
    count = len(set(lost.dwells))
    return f"{count} {'dwell' if count == 1 else 'dwells'} {_are(count)} left out"


def _are(count: int) -> str:
    return "is" if count == 1 else "are"
