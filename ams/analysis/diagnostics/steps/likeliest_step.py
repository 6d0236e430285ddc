"""The likeliest place of a change in mid-run, one that stayed and one that came back, and its chance."""

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import numpy as np

from ams.analysis.diagnostics.steps.step_noise import times_as_loud
from ams.analysis.diagnostics.steps.step_paths import NOTHING, least_aside
from ams.analysis.diagnostics.steps.step_scan import Change, Scan
from ams.arrays import FloatArray
from ams.statistics.distributions import f_tail

_SEEN: Final = 12.0
"""In variances of a dwell: of two or three hundred intervals the likeliest explains as much by chance."""
_ROUNDS: Final = 2
_DOUBTFUL: Final = 0.01
"""Of a p-value: where it is larger, nothing is told of a change."""
_WORTH_IT: Final = 0.2
"""Of a p-value: where it is larger, the weights of the outputs make no matter of how far the columns travel."""


def changes_of(scans: Iterable[Scan]) -> list[Change]:
    """Return the likeliest changes of each pattern: one that stayed, and one that came back if there is one to see."""
    every = list(scans)
    found = zip(likeliest(every), _came_back(every), strict=True)
    return [change for pair in found for change in pair if change is not None]


def likeliest(scans: Sequence[Scan], earliest: int = 0, latest: int | None = None) -> list[Change | None]:
    """Return the place of some at which a change explains most, by scan of one course and by the chance over all.

    None where no place is tried.
    """
    if not scans:
        return []
    first, moments = scans[0].pattern.paths.first, scans[0].pattern.paths.squares.shape[1]
    begin, end = max(earliest - first, 0), moments if latest is None else max(latest - first + 1, 0)
    if begin >= min(end, moments):
        return [None] * len(scans)
    explained = [_explained(scan.since[first : first + moments], scan.sizes)[begin:end] for scan in scans]
    most = [_most(squares) for squares in explained]
    p_values = _anywhere(scans, [scan.share(square) for scan, (_, square) in zip(scans, most, strict=True)])
    return [
        _steadied(scan, scan.change(first + begin + at, p_value, square), _at_any_moment)
        for scan, (at, square), p_value in zip(scans, most, p_values, strict=True)
    ]


def _most(explained: FloatArray) -> tuple[int, float]:
    """Return which of (n,) changes explains most, and how much."""
    at = int(explained.argmax())
    return at, float(explained[at])


def _anywhere(scans: Sequence[Scan], shares: Sequence[float]) -> list[float]:
    """Return the chance that a change at any place explains more than a share of the squares, by scan."""
    share, dof = np.array(shares), np.array([float(scan.dof) for scan in scans])
    beyond = f_tail(share * (dof - 1.0) / (1.0 - share), 1.0, dof - 1.0)
    crossing = (1.0 - share) ** (0.5 * dof - 1.0) / np.pi
    found = beyond + np.array([scan.pattern.paths.travelled for scan in scans]) * crossing
    for which in np.flatnonzero(found < _WORTH_IT).tolist():
        found[which] = beyond[which] + scans[which].travelled * crossing[which]
    return list(np.where(share > 0.0, found, 1.0).tolist())


def _at_any_moment(scan: Scan, share: float) -> float:
    return _anywhere([scan], [share])[0]


def _came_back(scans: Sequence[Scan]) -> list[Change | None]:
    """Return the pair of places between which a change explains most, by scan; None where that is what chance does."""
    if not scans or scans[0].pattern.intervals.begin.size == 0:
        return [None] * len(scans)
    grid = scans[0].pattern.intervals
    first, last = grid.bounds[grid.begin], grid.bounds[grid.end]
    most = [_most(_explained(scan.since[first] - scan.since[last], scan.interval_sizes)) for scan in scans]
    return [
        _returned(scan, which, square) if scan.share(square) * scan.dof >= _SEEN else None
        for scan, (which, square) in zip(scans, most, strict=True)
    ]


def _returned(scan: Scan, which: int, explained: float) -> Change:
    """Return the change between one pair of places of the coarse grid."""
    grid = scan.pattern.intervals
    begin, end = int(grid.bounds[grid.begin[which]]), int(grid.bounds[grid.end[which]])
    return _steadied(scan, scan.change(begin, _between(scan, scan.share(explained)), explained, end), _between)


def _between(scan: Scan, share: float) -> float:
    """Return the chance that a change between any pair of places explains more than a share of the squares."""
    return scan.pattern.intervals.begin.size * scan.beyond(share)


def _steadied(scan: Scan, change: Change, chance: Callable[[Scan, float], float]) -> Change:
    """Return a change, of less where the dwells that tell it scatter plainly more than the others."""
    if change.p_value > _DOUBTFUL:
        return change
    course, explained = scan.course, change.square * scan.variance
    column = course.in_time(course.layout.about_points(course.during(change).astype(float)))
    replication, along = course.layout.replication[course.time_order], scan.since[:-1] - scan.since[1:]
    less = explained / times_as_loud(along, scan.loudness, column, replication, scan.dof)
    return scan.change(change.index, chance(scan, scan.share(less)), less, change.end)


def located(scan: Scan, change: Change) -> Change:
    """Return a change that came back between the likeliest of all dwells: the coarse grid is where it is looked for."""
    begin, end = change.index, change.end
    if end is None:
        return change
    first, rows = scan.pattern.paths.first, scan.course.layout.rows
    size, aside, explained = scan.sizes, least_aside(rows), change.square * scan.variance
    for _ in range(_ROUNDS):
        for is_begin in (True, False):
            fixed = end if is_begin else begin
            dwells = np.arange(first, fixed - aside + 1 if is_begin else first + size.size)
            dwells = dwells if is_begin else dwells[dwells >= fixed + aside]
            lengths = size[dwells - first] + size[fixed - first] - 2.0 * scan.overlap(fixed)[dwells]
            best, explained = _most(_explained(scan.since[dwells] - scan.since[fixed], lengths))
            begin, end = (int(dwells[best]), fixed) if is_begin else (fixed, int(dwells[best]))
    return scan.change(begin, change.p_value, explained, end)


def _explained(sums: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return (n,) what changes explain, of the sums that each is shown by and the squares of its column."""
    least, square = NOTHING * sizes.max(), sums * sums
    if sizes.min() > least:
        return np.divide(square, sizes, out=square)
    return np.where(sizes > least, square / np.maximum(sizes, least), 0.0)
