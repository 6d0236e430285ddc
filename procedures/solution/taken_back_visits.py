"""Turns that held a run at a visit that was taken back since, while dwells in doubt of it still count.

What is measured again on a table that was put right shows nothing of the turn; the dwells that were measured on the
turned table and were not taken back still hold it.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from ams.surveillance.common_mode_words import still_in_doubt
from procedures.common_mode.check_sets import steps_in_mid_run
from procedures.common_mode.visit_watch import Judged, VisitWatch
from procedures.journal.voids import KIND as VOIDED
from procedures.journal.voids import Key, key_of, keys_in
from procedures.plan.plan import Plan
from procedures.records.dwells import DwellRecord, Event
from procedures.records.progress import COMMON_MODE
from rig.description.signal_chain import Chain


def left_in_doubt(
    plan: Plan,
    chains: Mapping[str, Chain],
    dwells: Sequence[DwellRecord],
    events: Sequence[Event],
    judged_now: Collection[Judged],
) -> tuple[Judged, ...]:
    """Return what held the run at visits that were taken back, each with the steps in doubt whose dwells still count.

    ``dwells``: in the order in which they were measured. ``judged_now``: what the visits that count show; a turn that
    one of them holds the same steps in doubt for is told there.
    """
    named = {step for judged in judged_now if judged.holds for step in judged.doubtful}
    found = []
    for stood, left in _holds_taken_back(dwells, events):
        watch = VisitWatch(plan, chains, steps_in_mid_run(events))
        judged = [watch.take(dwell) for dwell in stood][-1]
        if judged is not None and judged.holds and not left <= named:
            steps = tuple(sorted(left))
            findings = tuple(still_in_doubt(finding, steps) for finding in judged.findings)
            found.append(replace(judged, doubtful=steps, findings=findings))
    return tuple(found)


def _holds_taken_back(
    dwells: Sequence[DwellRecord], events: Sequence[Event]
) -> Iterator[tuple[tuple[DwellRecord, ...], frozenset[int]]]:
    """Yield the dwells as they stood at such a hold, the last one of the visit last, and the steps left in doubt."""
    epoch = 0
    for index, event in enumerate(events):
        epoch += event.kind == "opened"
        if event.kind != COMMON_MODE or not event.detail.get("held"):
            continue
        later = {key for after in events[index + 1 :] if after.kind == VOIDED for key in keys_in(after)}
        stood = _as_it_stood(dwells, int(str(event.detail["step"])), epoch, later)
        if not stood or key_of(stood[-1]) not in later:
            continue
        doubtful = event.detail["doubtful"]
        assert isinstance(doubtful, list)
        left = frozenset(dwell.step for dwell in stood if dwell.step in doubtful and _counts(dwell, later))
        if left:
            yield stood, left


def _counts(dwell: DwellRecord, taken_back: set[Key]) -> bool:
    return dwell.accepted and dwell.purpose == "design" and key_of(dwell) not in taken_back


def _as_it_stood(
    dwells: Sequence[DwellRecord], step: int, epoch: int, taken_back_later: set[Key]
) -> tuple[DwellRecord, ...]:
    """Return the dwells up to the accepted one of a step in an epoch; those taken back later counted then."""
    then = [
        replace(dwell, accepted=dwell.accepted or key_of(dwell) in taken_back_later)
        for dwell in dwells
        if dwell.epoch <= epoch
    ]
    at = (index for index, dwell in enumerate(then) if (dwell.step, dwell.epoch, dwell.accepted) == (step, epoch, True))
    return tuple(then[: max(at, default=-1) + 1])
