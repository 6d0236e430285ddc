"""Whether what a search found is a change in mid-run, or the likeliest step of a drift or of the temperature."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Final

import numpy as np

from ams.analysis.diagnostics.step_scan import Change
from ams.analysis.diagnostics.temperature import explained, varies
from ams.analysis.diagnostics.time_order import courses_of_drift, parts_of_replications
from ams.arrays import BoolArray, FloatArray
from ams.calibration.step_search import NOTHING, StepSearch
from ams.statistics.distributions import f_tail

_PARTS: Final = 4
"""Of a replication, each with a level of its own in what a change is held against."""
_PER_NUMBER: Final = 4.0
"""Of what a course explains, in variances of a dwell, for every number that it has to choose: the rest says which is
likelier. By Akaike (1974) 2, by Schwarz (1978) 7 for a thousand dwells."""
_FEW_REPLICATIONS: Final = 3
_FEW_OF_RETURN: Final = 5
"""Of so many, whose offsets are each what they are by chance, one stands by itself often enough."""
_CONTRADICTED: Final = 0.01
"""The chance below which parts of the run contradict a change."""
_LARGEST_REST: Final = 0.1
"""Of what a change explains: where the same pattern does more than this elsewhere, it is a drift."""
_BESIDE_WAVES: Final = 36.0
"""In variances of a dwell: what a step of an offset that drifts has to explain beyond slow waves, of which a walk is
made; a walk is likelier a slope with a step than a step alone. A sensitivity does not drift with its offset."""
_KEPT: Final = 0.5
"""Of what a change explains: beside the recorded temperature, or a level of each of few replications."""


def is_step(search: StepSearch, change: Change) -> bool:
    """Return whether a change is one, and not the likeliest step of a drift or of the temperature."""
    outputs = search.on_table if change.output is None else (change.output,)
    pattern = np.concatenate([search.pattern(change, index) for index in outputs])
    left = partial(search.left_of, outputs)
    y = np.concatenate([search.watched[index].departures / search.sd(index) for index in outputs])
    evidence, layout = search.evidence, search.evidence.layout
    step = left(pattern, search.course.during(change)[:, None])
    parts = parts_of_replications(evidence, _PARTS)
    levels = left(pattern, parts[:, None] == np.arange(parts.max() + 1))
    together, rank = explained(np.hstack([step, levels]), y)
    dof, by_parts = len(outputs) * search.course.dof - rank, rank - 1
    variance = max(float(y @ y) - together, NOTHING * float(y @ y)) / dof
    by_step = explained(step, y)[0]
    likelier = by_step - _PER_NUMBER * change.numbers * variance
    drifts = ((left(pattern, columns), free) for columns, free in _drifts(search, change))
    if any(explained(columns, y)[0] - _PER_NUMBER * free * variance > likelier for columns, free in drifts):
        return False
    rest = (together - by_step) / variance
    is_large = by_parts > 0 and rest > by_parts + _LARGEST_REST * by_step / variance
    if is_large and float(f_tail(rest / by_parts, float(by_parts), float(dof))) < _CONTRADICTED:
        return False
    if change.what == "offset" and search.drifting.intersection(outputs):
        *_, (waves, _) = courses_of_drift(search.course.time_order)
        if _kept(step, left(pattern, waves), y) < _BESIDE_WAVES * variance:
            return False
    if _is_of_a_dwell(search, outputs, step, y, by_step):
        return False
    others = []
    if layout.replications <= (_FEW_OF_RETURN if change.end and not change.is_of_table else _FEW_REPLICATIONS):
        others.append(left(pattern, _by_replication(search)))
    if varies(evidence) and evidence.rows.temperature_degc is not None:
        warmth = evidence.rows.temperature_degc - evidence.rows.temperature_degc.mean()
        powers = np.stack([warmth, warmth**2], axis=1)
        others += [left(pattern, powers), left(np.ones_like(pattern), powers)]
    if not others:
        return True
    return _kept(step, np.hstack(others), y) >= _KEPT * by_step


def _kept(step: FloatArray, beside: FloatArray, y: FloatArray) -> float:
    """Return the sum of squares of y along a step beside other columns."""
    return explained(np.hstack([step, beside]), y)[0] - explained(beside, y)[0]


def _is_of_a_dwell(search: StepSearch, outputs: Sequence[int], step: FloatArray, y: FloatArray, by_step: float) -> bool:
    """Return whether a change is shown by one dwell alone, the others in it sensing next to nothing of it."""
    rows = search.course.layout.rows
    struck = np.zeros((rows, 1))
    struck[int(np.abs(y).argmax()) % rows] = 1.0
    blocks = np.eye(len(outputs))[:, :, None, None] * search.evidence.layout.about_points(struck)
    beside = np.concatenate(
        [search.watched[index].beside(np.hstack(list(block))) for index, block in zip(outputs, blocks, strict=True)]
    )
    return _kept(step, beside, y) < _KEPT * by_step


def _drifts(search: StepSearch, change: Change) -> Iterator[tuple[FloatArray | BoolArray, int]]:
    """Yield (N, c) courses of a drift, and how many numbers each has to choose: what a change is held against."""
    yield from courses_of_drift(search.course.time_order)
    if change.end is None or not change.is_of_table:
        # A table that stands differently in every replication is off by itself as well.
        yield _by_replication(search), search.evidence.layout.replications - 1


def _by_replication(search: StepSearch) -> BoolArray:
    """(N, n) the rows of each replication."""
    layout = search.evidence.layout
    return np.asarray(layout.replication[:, None] == np.arange(layout.replications))
