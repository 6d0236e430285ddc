"""Whether what a search found is a change in mid-run, or the likeliest step of a drift or of the temperature.

A step chooses its place among all dwells, so that it explains a drift that has just been seen nearly as well as a drift
does, and a drift such a step. Which it is, is decided where twice the log likelihoods, less what their numbers cost,
differ by :data:`_DECIDED` or more; by less it is either.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Final, Literal

import numpy as np

from ams.analysis.diagnostics.over_time.temperature import explained, varies
from ams.analysis.diagnostics.steps.step_scan import Change
from ams.analysis.diagnostics.time_order import courses_of_drift, parts_of_replications
from ams.arrays import BoolArray, FloatArray
from ams.calibration.steps.step_search import NOTHING, StepSearch
from ams.statistics.distributions import f_tail

_PARTS: Final = 4
"""Of a replication, each with a level of its own in what a change is held against."""
_PER_NUMBER: Final = 4.0
"""Of what a course explains, in variances of a dwell, for every number that it has to choose: the rest says which is
likelier. By Akaike (1974) 2, by Schwarz (1978) 7 for a thousand dwells."""
_DECIDED: Final = 8.0
"""In variances of a dwell, as twice the log likelihood: fifty to one (Kass and Raftery 1995: from 6 on strong)."""
_FEW_REPLICATIONS: Final = 3
_FEW_OF_RETURN: Final = 5
"""Of so many, whose offsets are each what they are by chance, one stands by itself often enough."""
_CONTRADICTED: Final = 0.01
"""The chance below which parts of the run contradict a change."""
_LARGEST_REST: Final = 0.1
"""Of what a change explains: where the same pattern does more than this elsewhere, it is a drift."""
_BESIDE_WAVES: Final = 36.0
"""In variances of a dwell: what a step of what drifts has to explain beyond slow waves, of which a walk is made; a walk
is likelier a slope with a step than a step alone. A sensitivity does not drift with its offset."""
_KEPT: Final = 0.5
"""Of what a change explains: beside the recorded temperature, or a level of each of few replications."""
Likelier = Literal["step", "either", "drift"]


def likelier(search: StepSearch, change: Change) -> Likelier:
    """Return whether a change is one, or the likeliest step of a drift or of the temperature; or either of them."""
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
    judged = _beside_drifts(search, change, pattern, y, variance)
    if judged == "drift":
        return judged
    rest = (together - by_step) / variance
    is_large = by_parts > 0 and rest > by_parts + _LARGEST_REST * by_step / variance
    if is_large and float(f_tail(rest / by_parts, float(by_parts), float(dof))) < _CONTRADICTED:
        return "drift"
    if any(change.what in search.drifting_of(index) for index in outputs):
        *_, (waves, _) = courses_of_drift(search.course.time_order)
        if _kept(step, left(pattern, waves), y) < _BESIDE_WAVES * variance:
            return "drift"
    if _is_of_a_dwell(search, outputs, step, y, by_step):
        return "drift"
    others = []
    if layout.replications <= (_FEW_OF_RETURN if change.end and not change.is_of_table else _FEW_REPLICATIONS):
        others.append(left(pattern, _by_replication(search)))
    if varies(evidence) and evidence.rows.temperature_degc is not None:
        warmth = evidence.rows.temperature_degc - evidence.rows.temperature_degc.mean()
        powers = np.stack([warmth, warmth**2], axis=1)
        others += [left(pattern, powers), left(np.ones_like(pattern), powers)]
    if others and _kept(step, np.hstack(others), y) < _KEPT * by_step:
        return "drift"
    return judged


def _beside_drifts(search: StepSearch, change: Change, pattern: FloatArray, y: FloatArray, variance: float) -> Likelier:
    """Return which is likelier by what a step and drifts explain, each less what its numbers cost.

    One output may drift in offset and sensitivity at once, along one course, as one that warms up does; it may step in
    both as well. Levels of the replications hold a step between two of them whole, and several outputs do not drift
    alike, nor as a turn: beside these it is enough to be likelier.
    """
    outputs = search.on_table if change.output is None else (change.output,)
    taken: list[tuple[FloatArray, ...]] = [(pattern,)]
    is_shared = change.is_of_table or len(outputs) > 1
    if len(outputs) == 1:
        watched, sd = search.watched[outputs[0]], search.sd(outputs[0])
        taken.append((np.ones(pattern.size) / sd, watched.sensed / sd))

    def likelihood(columns: FloatArray | BoolArray, free: int, patterns: Sequence[FloatArray]) -> float:
        every = np.hstack([search.left_of(outputs, each, columns) for each in patterns])
        return explained(every, y)[0] / variance - _PER_NUMBER * free

    during, levels = search.course.during(change)[:, None], list(_levels(search, change))
    steps = [likelihood(during, change.numbers + len(patterns) - 1, patterns) for patterns in taken]
    beyond = [
        (
            max(steps[: at + 1]) - likelihood(columns, len(patterns) * free, patterns),
            is_level or (is_shared and at == 0),
        )
        for at, patterns in enumerate(taken)
        for is_level, courses in ((False, courses_of_drift(search.course.time_order)), (True, levels))
        for columns, free in courses
    ]
    if any(by < 0.0 for by, _ in beyond):
        return "drift"
    return "step" if all(by >= (0.0 if is_enough else _DECIDED) for by, is_enough in beyond) else "either"


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


def _levels(search: StepSearch, change: Change) -> Iterator[tuple[BoolArray, int]]:
    """Yield (N, n) the levels of the replications, and how many numbers they have to choose; none for what returned."""
    if change.end is None or not change.is_of_table:
        # A table that stands differently in every replication is off by itself as well.
        yield _by_replication(search), search.evidence.layout.replications - 1


def _by_replication(search: StepSearch) -> BoolArray:
    """(N, n) the rows of each replication."""
    layout = search.evidence.layout
    return np.asarray(layout.replication[:, None] == np.arange(layout.replications))
