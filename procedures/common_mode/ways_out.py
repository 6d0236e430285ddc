"""Which dwells a change of table or meter leaves in doubt, and the commands that have them measured again."""

from collections.abc import Collection, Iterable, Sequence
from typing import Final

from ams.analysis.diagnostics.take_back import ways_back, ways_in_words
from ams.findings import Said
from procedures.records.dwells import DwellRecord, measured_design

Moment = tuple[int, float]
"""Epoch and rig seconds within it: dates of two starts may overlap, where the clock was set or time is virtual."""

TO_MEASURE_AGAIN: Final = "to measure them again "
_ACCEPTED: Final = "or keep them, and accept the finding by name and reason when the set is signed"


def in_doubt(steps: Collection[int]) -> str:
    """Name the dwells in doubt: of the one step, or how many of which steps."""
    first, last = min(steps), max(steps)
    return (
        f"in doubt is the dwell of step {first}"
        if len(steps) == 1
        else f"in doubt are the {len(steps)} dwells of steps {first} to {last}"
    )


def take_back_commands(steps: Collection[int], dwells: Iterable[DwellRecord], run: str) -> str:
    """Return the commands that take back the dwells in doubt, with what each takes back, the cheapest first.

    ``dwells``: all of the run; those of the design that count are taken back.
    """
    return ways_in_words(ways_back(set(steps), measured_design(dwells), run))


def measured_again(steps: Collection[int], dwells: Iterable[DwellRecord], run: str) -> Said:
    """Return how dwells that a change of the meter leaves in doubt are measured again, or what else can be done."""
    return Said(
        in_doubt(steps),
        f"{TO_MEASURE_AGAIN}put the meter right, then {take_back_commands(steps, dwells, run)}; then calrig resume "
        f"{run}; {_ACCEPTED}",
    )


def meter_way_out(steps: Sequence[int], since: Moment, until: Moment, dwells: Sequence[DwellRecord], run: str) -> Said:
    """Say what a change of the meter leaves in doubt of the design, and the way out.

    ``steps``: measured in between, where visits tell it; else those that count and were. ``since`` and ``until``: when
    the meter still and already stood as it was found. ``run``: as commands take it.
    """
    design = [dwell for dwell in dwells if dwell.accepted and dwell.purpose == "design"]
    before = [dwell.step for dwell in design if (dwell.epoch, dwell.ended_s) <= since]
    after = [dwell.step for dwell in design if (dwell.epoch, dwell.started_s) >= until]
    counting = {dwell.step for dwell in design}
    between = [step for step in steps if step in counting] or sorted(counting - set(before) - set(after))
    if between:
        return measured_again(between, design, run)
    if not before or not after:
        return Said("all dwells that count stand on one side of it: none is in doubt by it")
    again = measured_again(after, design, run)
    mixture = f"{len(after)} of {len(design)} dwells were measured after it, and the result is a mixture"
    return again._replace(fact=f"{mixture}: {again.fact}")
