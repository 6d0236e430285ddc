"""Which check dwells are compared: those of every later epoch with the first of their attitude that still counts.

A set that was cut short by a lost link counts as far as it goes. Nothing counts any more from before the package was
moved, or from before a step that a person accepted by resuming.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from procedures.records.dwells import DwellRecord, Event

RESTART_STEP: Final = "seam"
"""Kind of the event that says what a check set after a restart showed."""
BACK_AT: Final = "back_at_epoch"
"""In it: the epoch from which on check sets count again, as this one stands as they did."""


@dataclass(frozen=True)
class CheckSetPair:
    """The check set of one epoch, and what it is compared with."""

    epoch: int
    before: Mapping[int, DwellRecord]
    """Step to dwell; not empty."""
    after: Mapping[int, DwellRecord]
    is_alike: bool
    """Whether both stood at the same temperature."""

    @property
    def since(self) -> int:
        """The epoch of the earliest dwell compared with."""
        return min(dwell.epoch for dwell in self.before.values())


def first_checks(
    dwells: Iterable[DwellRecord], mounting: int, first_epoch: int, before_epoch: int
) -> dict[int, DwellRecord]:
    """Return step to the first accepted check dwell of a mounting, from the epochs in [first, before)."""
    found: dict[int, DwellRecord] = {}
    for dwell in dwells:
        is_wanted = dwell.purpose == "check" and dwell.accepted and dwell.mounting == mounting
        if is_wanted and first_epoch <= dwell.epoch < before_epoch:
            found.setdefault(dwell.step, dwell)
    return found


def check_set_pairs(dwells: Sequence[DwellRecord], events: Iterable[Event]) -> tuple[CheckSetPair, ...]:
    """Return every check set of a run after the first that has something to be compared with."""
    events = tuple(events)
    first_epochs, other_plateau = (1, *accepted_epochs(events)), _at_another_plateau(events)
    found = []
    for epoch in sorted({dwell.epoch for dwell in dwells if dwell.purpose == "check"}):
        after = {
            dwell.step: dwell
            for dwell in dwells
            if dwell.purpose == "check" and dwell.accepted and dwell.epoch == epoch
        }
        if not after:
            continue
        first = max((begun for begun in first_epochs if begun < epoch), default=1)
        mounting = next(iter(after.values())).mounting
        before = {step: dwell for step, dwell in first_checks(dwells, mounting, first, epoch).items() if step in after}
        if before:
            found.append(CheckSetPair(epoch, before, after, epoch not in other_plateau))
    return tuple(found)


def visits_before(dwells: Sequence[DwellRecord], pair: CheckSetPair) -> tuple[DwellRecord, ...]:
    """Return what the run had when it compared: what two visits of this mounting to one attitude differ by.

    Of the check sets before only the first whole one counts, as in a run without interruption.
    """
    earlier = [dwell for dwell in dwells if dwell.accepted and dwell.epoch < pair.epoch]
    wanted = {dwell.step for dwell in dwells if dwell.purpose == "check"}
    steps: dict[int, set[int]] = {}
    for dwell in earlier:
        if dwell.purpose == "check":
            steps.setdefault(dwell.epoch, set()).add(dwell.step)
    first = min((epoch for epoch, measured in steps.items() if measured >= wanted), default=None)
    mounting = next(iter(pair.after.values())).mounting
    return tuple(
        dwell for dwell in earlier if dwell.mounting == mounting and (dwell.purpose != "check" or dwell.epoch == first)
    )


def accepted_epochs(events: Iterable[Event]) -> tuple[int, ...]:
    """Return the epochs whose check set showed a step that whoever resumes accepts: nothing counts from before them.

    None of these counts any more from where a later check set stood again as the one before the step did.
    """
    accepted: tuple[int, ...] = ()
    for epoch, event in _by_epoch(events):
        if event.kind == "state" and event.detail.get("cause") == "seam":
            accepted = (*accepted, epoch)
        elif event.kind == RESTART_STEP and BACK_AT in event.detail:
            accepted = tuple(before for before in accepted if before <= int(str(event.detail[BACK_AT])))
    return accepted


def steps_in_mid_run(events: Iterable[Event]) -> tuple[int, ...]:
    """Return the epochs that began with a step, there or back: no visit is compared with one from before them."""
    return tuple(
        epoch
        for epoch, event in _by_epoch(events)
        if (event.kind == "state" and event.detail.get("cause") == "seam")
        or (event.kind == RESTART_STEP and BACK_AT in event.detail)
    )


def _at_another_plateau(events: Iterable[Event]) -> set[int]:
    """Return the epochs whose check set stood at another temperature."""
    return {
        epoch
        for epoch, event in _by_epoch(events)
        if event.kind == RESTART_STEP and "plateau" in str(event.detail.get("reason", ""))
    }


def _by_epoch(events: Iterable[Event]) -> Iterator[tuple[int, Event]]:
    epoch = 0
    for event in events:
        epoch += event.kind == "opened"
        yield epoch, event
