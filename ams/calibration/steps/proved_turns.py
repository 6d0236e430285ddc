"""A turn of the table that visits proved over all sensors, as the dwells of the design tell it: form, size and place.

A visit has a few dwells, a side of the design a hundred: what these show of it is better determined, and a verdict that
rested on the visit alone would be better for a larger slip. So the test over the dwells is made of it as of every
change in mid-run, at the places that the visits leave open; what is plain is told by its diagnosis, taken out as
that takes it out, and stands in place of what the visits said. What the dwells do not show plainly, or would not tell
from a change of the sensor by themselves, is taken out in the form that the visits found, and stays told by these.
"""

from dataclasses import dataclass, replace

import numpy as np

from ams.analysis.diagnostics.steps.likeliest_step import likeliest
from ams.analysis.diagnostics.steps.step_scan import Change
from ams.arrays import BoolArray, IntArray
from ams.calibration.steps.step_columns import Changed, step_columns
from ams.calibration.steps.step_findings import findings_of_change
from ams.calibration.steps.step_or_drift import likelier
from ams.calibration.steps.step_search import StepSearch
from ams.findings import SHOWN_BY, Finding
from ams.inputs.known_of_run import ProvedChange, is_among
from ams.surveillance.turns import ROTATIONS


@dataclass(frozen=True)
class ShownTurn:
    """A turn that visits proved and dwells tell."""

    change: Change
    findings: tuple[Finding, ...]
    shown_by: tuple[str, ...]
    """Between which visits it was proved: two pairs of them, where it came in the middle of a visit."""

    @property
    def findings_with_visits(self) -> tuple[Finding, ...]:
        """What is told of it, with what else shows it."""
        between = " and ".join(self.shown_by)
        return tuple(
            replace(
                finding.adding(f"all sensors show it {between}"),
                details={**finding.details, SHOWN_BY: "; ".join(self.shown_by)},
            )
            for finding in self.findings
        )


def beside_proved(
    search: StepSearch, changes: tuple[ProvedChange, ...], level: float
) -> tuple[StepSearch, tuple[ShownTurn, ...]]:
    """Return the search beside changes that are proved, and the turns among them that the dwells tell.

    ``level``: of a change of one output.
    """
    shown: list[ShownTurn] = []
    for change in changes if search.course.dof > 0 else ():
        if not _is_shown(change, search):
            continue
        search, turn = _beside(search, change, level) if _is_turn(change, search) else (search, None)
        if turn is not None:
            shown.append(turn)
            continue
        at = next((at for at, before in enumerate(shown) if _is_within(before.change, change, search)), None)
        if at is None:
            search = search.beside(change)
        else:
            shown[at] = replace(shown[at], shown_by=(*shown[at].shown_by, change.between))
    return search, tuple(shown)


def _is_shown(change: ProvedChange, search: StepSearch) -> bool:
    """Return whether the outputs take anything of a change: on a sting nothing of one that is of roll alone."""
    (evidence, at), *_ = search.seen
    every = Changed(np.ones(evidence.rows.rows, dtype=bool), change.parts)
    return bool(step_columns(evidence, at, (every,)).shape[1] > 0)


def _is_turn(change: ProvedChange, search: StepSearch) -> bool:
    return search.course.is_judged and bool(change.parts) and set(change.parts) <= set(ROTATIONS)


def _beside(search: StepSearch, change: ProvedChange, level: float) -> tuple[StepSearch, ShownTurn | None]:
    """Return the search beside a turn as the dwells tell it; as it is, and None, where they do not."""
    slip = _likeliest(search, change, level)
    if slip is None:
        return search, None
    if drifting := search.drifting_beside(slip, level):
        return _beside(search.beside_drift_of(drifting), change, level)
    if likelier(search, slip) == "drift":
        return search, None
    findings = tuple(finding for finding, _ in findings_of_change(search, slip, is_shared=True))
    if any(finding.kind != "table-rotation" or finding.details.get("confounded_with") for finding in findings):
        return search, None
    return search.without(slip), ShownTurn(slip, findings, (change.between,))


def _likeliest(search: StepSearch, change: ProvedChange, level: float) -> Change | None:
    """Return the likeliest slip at the places that visits leave open; None where none is significant.

    It has to be significant with dwells that stand out drawn in as well.
    """
    moments = _moments(search, change)
    if moments is None:
        return None
    plain = [
        slip
        for slip in likeliest(search.scans, *moments)
        if slip is not None and slip.is_of_table and search.chance(slip) <= level * search.share(slip)
    ]
    if not plain or (
        search.is_struck
        and not search.is_clipped
        and _likeliest(replace(search, is_clipped=True), change, level) is None
    ):
        return None
    return max(plain, key=lambda slip: slip.square)


def _is_within(slip: Change, change: ProvedChange, search: StepSearch) -> bool:
    """Return whether a turn that is told already may be what visits proved once more."""
    moments = _moments(search, change) if _is_turn(change, search) else None
    return moments is not None and moments[0] <= slip.index <= moments[1]


def _moments(search: StepSearch, change: ProvedChange) -> tuple[int, int] | None:
    """Return the first and the last dwell, in the order of time, before which the change may have been."""

    def in_time(dwells: BoolArray) -> IntArray:
        return np.flatnonzero(dwells[search.course.time_order])

    rows = search.evidence.rows
    before, after = in_time(is_among(rows, change.before)), in_time(is_among(rows, change.after))
    if before.size == 0 or after.size == 0 or before[-1] >= after[0]:
        return None
    return int(before[-1]) + 1, int(after[0])
