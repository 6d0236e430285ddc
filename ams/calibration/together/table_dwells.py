"""Whether the table stood off at single dwells: all axes of all packages together, each dwell beside its replications.

A table that did not seat turns everything on it by the same angles, e_s = k_s·(∂f/∂R δR + ∂f/∂α δα) for every axis s
of every package; a reading that is wrong is wrong by itself. At each dwell both angles are fitted to what the dwell
reads off the other replications, by weighted least squares with the scatter of each axis. The squares that they explain
are held against Fisher's F, with the degrees of freedom of the axis that has the fewest: a sum of independent Student
variables has no heavier tails than the worst of them. How the table seats from dwell to dwell turns all sensors alike
as well; its variance about each axis is learned from all other dwells by moments, and stands beside that of readings.

The largest is taken out and the next looked at, and those up to the last that is significant are told (Rosner 1983), so
that of two neither hides the other; where replications scatter unevenly without them, those that stand out of their own
(:mod:`ams.calibration.together.dwell_scatter`). Bonferroni over the dwells; the level is that of one test of a run for
each axis that is looked at. What is significant is named by the diagnosis of two visits
(:mod:`ams.surveillance.common_mode`), of a single attitude: a reading of one channel, a package by itself, and a turn.
One package has three readings and two turns: where one axis alone would show the turn, at level or at a right angle,
nothing tells it from a wrong reading of that axis, and both are told.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.analysis.diagnostics.axis.axis_tests import MOST_TESTS
from ams.analysis.diagnostics.beliefs import LEVEL, SLIP
from ams.analysis.diagnostics.dwell_words import dwell_words
from ams.analysis.diagnostics.take_back import ways_back_of, ways_in_words
from ams.analysis.diagnostics.words.wrong_dwell_words import MOST_LISTED
from ams.analysis.diagnostics.wrong_dwells import LARGEST_SHARE, LEAST_DOF
from ams.calibration.together.table_dwell_search import Behind, DwellSearch, StoodPackage, seen_package
from ams.calibration_result import Calibration
from ams.findings import Finding
from ams.inputs.known_of_run import NOTHING_KNOWN, DwellLabels, KnownOfRun, ProvedChange, labels_of
from ams.surveillance.common_mode_words import who_agree
from ams.units import ARCSEC_PER_DEG

TABLE_DWELL: Final = "table at single dwells"
_PATIENCE: Final = 4
"""Dwells that are looked at after the last that was significant."""


@dataclass(frozen=True)
class DwellsOfTable:
    """What all packages show together of single dwells."""

    known: KnownOfRun = NOTHING_KNOWN
    findings: tuple[Finding, ...] = ()
    """Of every package; none where the table is not named."""


def judge_dwells(
    packages: Sequence[StoodPackage], family: int | None = None, changes: Sequence[ProvedChange] = ()
) -> DwellsOfTable:
    """Return at which dwells the table stood off.

    ``family``: axes of the run, None: those of the packages. ``changes``: of table or meter in mid-run that are proved:
    what was measured after one is looked at by itself, and what was measured meanwhile not at all. Packages without
    replications, and those that sense no attitude, say nothing of it; one on a sting nothing of roll. Where a package
    by itself shows a slip in mid-run, that is what its dwells are off by.
    """
    seen = [seen for package in packages if (seen := seen_package(package, changes)) is not None]
    yawed = [package for package in seen if package.rows.yaw_rad is not None]
    seen = yawed or seen  # on a gimbal what has no yaw was not turned by it
    if not seen or any(_slipped(package.calibration) for package in packages):
        return DwellsOfTable()
    search = DwellSearch(tuple(seen), tuple(labels_of(seen[0].rows)))
    size = sum(len(package.k) for package in seen)
    found = list(_off(search, LEVEL * size / (family or size) / MOST_TESTS))
    off = [judged for judged in found if judged.behind.is_table]
    known = KnownOfRun(
        frozenset(judged.labels for judged in off),
        {
            judged.labels: judged.behind.turn_in_words
            for judged in found
            if judged.behind.turn is not None and not judged.behind.is_table
        },
    )
    return DwellsOfTable(known, (_finding(off, search),) if off else ())


def _slipped(calibration: Calibration) -> bool:
    findings = (finding for axis in calibration.axes.values() for finding in axis.findings)
    return any(finding.is_significant and finding.details.get("test") == SLIP for finding in findings)


@dataclass(frozen=True)
class _Judged:
    """A dwell that stands out by a turn of all."""

    labels: DwellLabels
    p_value: float
    behind: Behind


def _off(search: DwellSearch, level: float) -> Iterator[_Judged]:
    """Yield the dwells that stand out, each judged with the others taken out.

    Where without them the replications scatter unevenly, each is held against its own, the others of it left in: what
    is left of a loud replication without its largest is less loud than it was.
    """
    found, without = _standing_out(search, level)
    if not found or len(found) > _most(search):
        return
    is_uneven = without.scatters_unevenly
    whole = search.by_replication() if is_uneven else search
    for dwell in found:
        alone, labels = whole, search.labels[dwell]
        for other in (search.labels[each] for each in found):
            beside = other[0] == labels[0] if is_uneven else other == labels
            alone = alone if beside else alone.without(other)
        rest = alone.without(labels)
        p_value = alone.p_value(dwell, rest)
        if p_value <= level:
            yield _Judged(labels, p_value, alone.judged(dwell, rest))


def _standing_out(search: DwellSearch, level: float) -> tuple[list[int], DwellSearch]:
    """Return the dwells up to the last that is significant, and the search without them; one too many says enough."""
    found, last, left = list[int](), 0, search
    without = left
    while len(found) < min(_most(search) + 1, last + _PATIENCE) and left.dof >= LEAST_DOF:
        dwell = left.likeliest()
        rest = left.without(search.labels[dwell])
        found.append(dwell)
        if left.p_value(dwell, rest) <= level:
            last, without = len(found), rest
        left = rest
    return found[:last], without


def _most(search: DwellSearch) -> int:
    """Return how many single dwells there may be."""
    return max(1, int(LARGEST_SHARE * len(search.labels)))


def _finding(off: Sequence[_Judged], search: DwellSearch) -> Finding:
    """Return one finding of all dwells at which the table stood off, with one way out for all packages."""
    first = search.packages[0]
    ordered = sorted(off, key=lambda judged: first.row_of[judged.labels])
    rows = [first.row_of[judged.labels] for judged in ordered]
    sensors = tuple(package.name for package in search.packages)
    turns = [
        f"{judged.behind.turn_in_words} at {dwell_words(first.rows, row)}"
        for judged, row in zip(ordered, rows, strict=True)
    ]
    more = len(turns) - MOST_LISTED
    listed = "; ".join(turns[:MOST_LISTED]) + (f"; and at {more} more" if more > 0 else "")
    steps = () if first.rows.step is None else tuple(int(first.rows.step[row]) for row in rows)
    meant = np.zeros(first.rows.rows, dtype=bool)
    meant[rows] = True
    what_to_do = (
        f"measure again ({ways_in_words(ways_back_of(meant, first.rows))})"
        if steps
        else f"measure again, or take {'its row' if len(rows) == 1 else 'their rows'} out of {first.rows.source} and "
        "solve it again"
    )
    largest = max(off, key=lambda judged: judged.behind.common.rotation_rad)
    at = first.row_of[largest.labels]
    who, is_lone = who_agree(largest.behind.common.agreeing, sensors), len(sensors) == 1
    seen = "its axes show it together, and none alone would" if is_lone else f"{who} show it, so it is not the sensors"
    what = f"the table, its base or the common fixture{' (or the package on it)' if is_lone else ''}"
    fact = (
        f"{what} stood off by {listed}, against the other replications: {seen}; it is in the result and in its "
        "uncertainty, and left out of all other tests"
    )
    details: dict[str, float | str | None] = {
        "test": TABLE_DWELL,
        "cause": largest.behind.common.stated[0].name,
        "confounded_with": None,
        "turned_arcsec": float(np.rad2deg(largest.behind.common.rotation_rad)) * ARCSEC_PER_DEG,
        "replication": float(largest.labels[0]),
        "point": float(largest.labels[1]),
        "pitch_deg": float(np.rad2deg(first.rows.pitch_rad[at])),
        "roll_deg": float(np.rad2deg(first.rows.roll_rad[at])),
        **({} if first.rows.yaw_rad is None else {"yaw_deg": float(np.rad2deg(first.rows.yaw_rad[at]))}),
    }
    p_value = min(judged.p_value for judged in off)
    return Finding("table-rotation", fact, True, p_value, steps, details, what_to_do=what_to_do)
