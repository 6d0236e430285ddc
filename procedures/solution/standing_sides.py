"""Which dwells of the design the table stood at as in the first check set of the run, and at which it did not.

A start of the run whose check set shows nothing against the first stands as that did, up to where a visit shows a turn
of the table. Of what was measured between two visits that differ nothing is known, nor of a start without such a check
set. Where a slip in mid-run is found by the dwells, this tells the side that is to be measured again.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

from ams.analysis.diagnostics.beliefs import SLIP
from ams.analysis.diagnostics.take_back import ways_back
from ams.calibration_result import Calibration
from ams.findings import Finding
from procedures.common_mode.check_sets import check_set_pairs, first_checks
from procedures.common_mode.visit_watch import VisitWatch, since_check_set
from procedures.records.declared_supply import correcting
from procedures.records.dwells import DwellRecord
from procedures.solution.record import RunRecord
from procedures.solution.request import SolvedSensor

_FIRST: Final = 1
"""Epoch of the check set that the declared zero was taken with."""


@dataclass(frozen=True)
class StandingSides:
    """Of one run. Nothing is judged before a finding asks."""

    record: RunRecord

    @cached_property
    def design(self) -> tuple[DwellRecord, ...]:
        """The dwells of the design that count, in the order of time."""
        design = (dwell for dwell in self.record.dwells if dwell.accepted and dwell.purpose == "design")
        return tuple(sorted(design, key=lambda dwell: (dwell.epoch, dwell.ended_s)))

    @cached_property
    def stands_as_first(self) -> Mapping[int, bool | None]:
        """Step to whether the table stood at it as in the first check set; None where nothing tells."""
        opened = {epoch: self._opens_as_first(epoch) for epoch in {dwell.epoch for dwell in self.design}}
        return {dwell.step: self._stands(dwell, is_as_first=opened[dwell.epoch]) for dwell in self.design}

    def with_side(self, finding: Finding) -> Finding:
        """Return a slip in mid-run with the side that is to be measured again; any other finding as it is."""
        if finding.details.get("test") != SLIP or not finding.is_significant or not finding.steps:
            return finding
        changed = set(finding.steps)
        steps = [dwell.step for dwell in self.design]
        others = [step for step in steps if step not in changed]
        is_to_the_end = changed == set(steps[len(others) :])
        sides = (("since", sorted(changed)), ("before" if is_to_the_end else "outside", others))
        sides = sides if is_to_the_end else (("in between", sorted(changed)), sides[1])
        for (where, right), (elsewhere, wrong) in (sides, sides[::-1]):
            if self._tells_sides_apart(right, wrong):
                return self._with_side(finding, where, elsewhere, wrong)
        return finding

    def _tells_sides_apart(self, right: list[int], wrong: list[int]) -> bool:
        as_first = self.stands_as_first
        is_right = bool(right) and all(as_first.get(step) is True for step in right)
        return is_right and not any(as_first.get(step) for step in wrong) and any(
            as_first.get(step) is False for step in wrong
        )  # fmt: skip

    def _with_side(self, finding: Finding, where: str, elsewhere: str, wrong: list[int]) -> Finding:
        measured = [(dwell.step, dwell.replication) for dwell in self.design]
        way = ways_back(set(wrong), measured, self.record.run)[0]
        fact = f"the check sets show that those {where} stand as the first check set of the run did"
        what_to_do = (
            f"measure the {len(wrong)} {elsewhere} again, with the table as it stood for the others ({way.text})"
        )
        return replace(finding.adding(fact), what_to_do=what_to_do)

    def _stands(self, dwell: DwellRecord, *, is_as_first: bool | None) -> bool | None:
        """Return whether the table stood so at a dwell of an epoch that opened as the first did, or not."""
        for judged in self.record.judged_visits:
            if not judged.holds or not judged.since[0] == judged.until[0] == dwell.epoch:
                continue
            if (dwell.epoch, dwell.ended_s) <= judged.since:
                continue
            is_after = (dwell.epoch, dwell.started_s) >= judged.until
            is_as_first = False if is_as_first and is_after else None
        return is_as_first

    def _opens_as_first(self, epoch: int) -> bool | None:
        if epoch == _FIRST:
            return True
        dwells = sorted(self.record.dwells, key=lambda dwell: (dwell.epoch, dwell.started_s))
        pairs = {pair.epoch: pair for pair in check_set_pairs(dwells, self.record.events) if pair.is_alike}
        pair = pairs.get(epoch)
        if pair is None:
            return None
        mounting = next(iter(pair.after.values())).mounting
        before = first_checks(dwells, mounting, _FIRST, _FIRST + 1)
        watch = VisitWatch(self.record.plan, correcting(self.record.rig.chain))
        for dwell in dwells:
            if dwell.epoch == _FIRST:  # a turn between starts is no scatter
                watch.take(dwell)
        judged = watch.compare_check_sets(before, pair.after, since_check_set(_FIRST))
        if judged is None or not before.keys() >= pair.after.keys():
            return None
        if judged.findings:
            return False if judged.holds else None
        return True


def with_standing_side(solved: SolvedSensor, sides: StandingSides) -> SolvedSensor:
    """Return a sensor whose slips in mid-run name the side that is to be measured again, where check sets tell it."""
    calibration = solved.calibration
    if calibration is None:
        return solved
    again = dict(_replaced(calibration, sides))
    if not again:
        return solved
    texts = {finding.text: named.text for finding, named in again.values()}
    axes = {
        label: replace(
            axis,
            findings=tuple(again.get(finding.text, (finding, finding))[1] for finding in axis.findings),
            warnings=tuple(texts.get(text, text) for text in axis.warnings),
        )
        for label, axis in calibration.axes.items()
    }
    warnings = tuple(texts.get(text, text) for text in calibration.warnings)
    return replace(solved, calibration=replace(calibration, axes=axes, warnings=warnings))


def _replaced(calibration: Calibration, sides: StandingSides) -> Iterator[tuple[str, tuple[Finding, Finding]]]:
    for axis in calibration.axes.values():
        for finding in axis.findings:
            named = sides.with_side(finding)
            if named is not finding:
                yield finding.text, (finding, named)
