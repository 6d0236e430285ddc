"""Whether an output stands at a rail: an amplifier's or a meter's end of range, where it is no measure of the force.

Readings at a rail are equal to the last digit. So are those of one attitude without noise, and those that a coarse
meter puts on one step; a rail is told where the same readings, as the other dwells predict them, lie further apart than
steps and noise explain, or where replications of one attitude differ everywhere but there. Two or three equal readings
are a rail only where chance would hardly make all replications of their attitude equal: with a meter far finer than the
noise.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from ams.arrays import BoolArray, FloatArray, IntArray
from ams.findings import Finding
from ams.inputs.common_step import GRID, common_step
from ams.inputs.equal_readings import chance_of_a_number
from ams.units import printed

KIND: Final = "output-clipped"
LEAST: Final = 2
"""Dwells at a rail."""
_MANY: Final = 4
"""Dwells that are not equal by chance where hardly any others are."""
_CHANCE: Final = 0.002
"""That fewer are equal to the last digit at an extreme, by the meter's step and the noise."""
_FAR_SD: Final = 10.0
"""Standard deviations by which what the model expects at a rail must differ from dwell to dwell."""
_FAR_STEPS: Final = 3.0
"""Steps of the meter beside it."""
_SAME: Final = 1e-12
"""Of the span: what differs by less is the same number."""
_ALL_DIFFER: Final = 0.9
_MOST: Final = 0.6
"""Share of the rows beyond which there is no output left to hold them against."""
MOST_LISTED: Final = 8


def at_extremes(output: FloatArray) -> list[BoolArray]:
    """Return the rows of (N,) outputs that are equal at their highest, and at their lowest, where they are several."""
    low, high = float(output.min()), float(output.max())
    near = _SAME * (high - low)
    found = [output >= high - near, output <= low + near]
    return [rows for rows in found if LEAST <= np.count_nonzero(rows) <= _MOST * output.size]


def is_rail_by_expectation(rows: BoolArray, output: FloatArray, predicted: FloatArray, sd: float) -> bool:
    """Return whether equal readings are expected further apart than steps and noise explain.

    ``predicted``: (N,) by a solution without these rows, with ``sd`` of what that leaves.
    """
    return float(np.ptp(predicted[rows])) > _FAR_SD * sd + _FAR_STEPS * _least_gap(output)


def is_rail_by_replications(rows: BoolArray, others: BoolArray, output: FloatArray, point: IntArray) -> bool:
    """Return whether replications of an attitude are equal in ``rows``, and differ in ``others``, at no extreme."""
    repeated = np.bincount(point[rows], minlength=int(point.max()) + 1) > 1
    if not repeated.any():
        return False
    ordered = np.lexsort((output[others], point[others]))
    alike = np.diff(point[others][ordered]) == 0
    apart = np.diff(output[others][ordered])[alike]
    if not apart.size or float(np.mean(apart > _SAME * np.ptp(output))) < _ALL_DIFFER:
        return False
    if np.count_nonzero(rows) >= _MANY:
        return True
    return _hardly_by_chance(rows, output, point, _scatter(output[others], point[others]))


def _scatter(output: FloatArray, point: IntArray) -> float:
    """Return the standard deviation of (N,) readings within their points, of which one at least repeats."""
    _, number, rows = np.unique(point, return_inverse=True, return_counts=True)
    means = np.bincount(number, output) / rows
    return float(np.sqrt(np.sum((output - means[number]) ** 2) / (output.size - rows.size)))


def _hardly_by_chance(rows: BoolArray, output: FloatArray, point: IntArray, sd: float) -> bool:
    """Return whether all replications of the attitudes of ``rows`` stand there, and chance would hardly have it so."""
    if np.any(rows != np.isin(point, point[rows])) or not sd > 0.0:
        return False
    least = GRID * float(np.ptp(output))
    equal = chance_of_a_number(max(common_step(output, least), least), float(np.sqrt(2.0)) * sd)
    return bool(equal ** (np.count_nonzero(rows) - np.unique(point[rows]).size) <= _CHANCE)


def clipped_finding(
    rows: Sequence[BoolArray],
    output: FloatArray,
    unit: str,
    dwells: Sequence[str],
    steps: IntArray | None,
    *,
    are_left_out: bool,
) -> Finding:
    """Return what is said of the rails of one output; ``dwells``: the first of them in words.

    ``are_left_out``: whether the other tests are made without them.
    """
    every = np.flatnonzero(np.logical_or.reduce(rows))
    levels = [float(output[rail][0]) for rail in rows]
    at = " and at ".join(f"{level:.7g} {printed(unit)}" for level in levels)
    more = every.size - len(dwells)
    listed = "; ".join(dwells) + (f"; and {more} more" if more > 0 else "")
    others = "without these dwells" if are_left_out else "with these dwells, since too few points are left without"
    fact = (
        f"clipped: {every.size} dwells stand at {at}, equal to the last digit: a rail of the amplifier, the range of "
        f"the meter, a channel that hangs or an open input, and no measure of what the sensor felt ({listed}); offset "
        "and sensitivities are wrong by it, they are not usable and there is no coefficient set; the other tests are "
        f"made {others}"
    )
    what_to_do = "choose a larger range or a smaller gain and measure again, or leave these dwells out and solve again"
    details: dict[str, float | str | None] = {"dwells": float(every.size)}
    details |= dict(zip(("level", "other_level"), levels, strict=False))
    numbers = () if steps is None else tuple(int(step) for step in steps[every])
    return Finding(KIND, fact, True, None, numbers, details, is_held=False, what_to_do=what_to_do)


def first_rows(rows: Sequence[BoolArray]) -> Iterator[int]:
    """Yield the first rows at a rail, as many as are listed."""
    yield from np.flatnonzero(np.logical_or.reduce(rows))[:MOST_LISTED].tolist()


def _least_gap(output: FloatArray) -> float:
    apart = np.diff(np.sort(output))
    apart = apart[apart > _SAME * float(np.ptp(output))]
    return float(apart.min()) if apart.size else 0.0
