"""Whether an axis of the table has play: all outputs of a package turn by the way that it came, each as it lies.

A play θ of the pitch axis moves every output s by ½ θ d·(k_s·∂f/∂α), d = ±1 the sense of the axis' last move, and one
of roll by ½ θ d·(k_s·∂f/∂R). One number for all outputs is estimated, each of them weighed by its scatter, and held
against Fisher's F. No sensor does that by itself: what it remembers of attitudes before acts on its own output. So

- the play is told only where the outputs agree on it, and show it without the one that shows it most;
- an element that follows the force, or what is kept of the dwell before, must not explain the outputs better, one size
  against all sensitivities or a size of each output, nor nearly as well (χ² + p ln n, Schwarz 1978);
- what it scatters by from replication to replication counts, where that is plainly more than the dwells do;
- where an order that is always the same comes to each index of the axis from one side, the play is a curve of index
  errors, and is held against what any curve of them scatters by beside it; where it comes from both, beside any curve.

Where one output alone sees it, it is told with what else it may be, a hysteresis of the sensor's own. The play of a
fixture follows gravity, and repeats at a point whatever the order; that of the table follows the way.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import hypot
from typing import Final

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time import previous_attitude
from ams.analysis.diagnostics.over_time.settling import Estimate, joined
from ams.analysis.diagnostics.sensed_force import sensed_force, turned_by
from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.analysis.diagnostics.steps.approach import last_way
from ams.arrays import FloatArray
from ams.calibration.together.backlash_found import Play
from ams.calibration.together.backlash_shown import ShownPlay, shown_play
from ams.frames import AXES
from ams.inputs.indices import standing_at
from ams.statistics.distributions import f_tail

_OTHERS_SHOW: Final = 0.05
"""Chance of as much without the output that shows it most."""
_UNLIKE: Final = 1e-3
"""Chance of outputs that differ as much and see one play."""
_BESIDE_CURVES: Final = 0.25
"""Of the play's square: where any curve of index errors leaves less, it is held against the scatter of curves."""
_AS_LIKELY: Final = 6.63
"""χ² of one degree of freedom at 1 %: by less a way that is not known is not told from another."""
_LEAST_REPLICATIONS: Final = 3
_PLAIN: Final = 0.003
"""Chance of so large a scatter between replications where dwells know nothing of each other."""
_PLAINER: Final = 4.0
"""In twice the log likelihood: by less a memory of the sensors is not told from play."""
_NOTHING: Final = 1e-9
_NO_AXIS: Final[frozenset[str]] = frozenset()
OutputSeen = tuple[Evidence, int]
"""What the tests look at, and which output of it."""


_NONE: Final = Play("pitch", np.nan, np.nan, np.nan, 1.0, ())


def judge_play(
    outputs: Sequence[OutputSeen], level: float, single_approach: frozenset[str] = _NO_AXIS
) -> tuple[Play, ...]:
    """Return the play of each axis of the table that the outputs show together at a ``level``, the plainer first.

    ``single_approach``: axes that the machine lets come from one side always.
    """
    ways: tuple[float, ...] = ()
    package = _shown(outputs, single_approach, ways)
    if not package or _least_chance(package) > level:
        return ()
    found: list[Play] = []
    axes = package[0].axes
    for _ in axes:
        known = [axes.index(play.axis) for play in found]
        plainest = _plainest(package, known)
        if not plainest.p_value <= level:
            break
        axis = axes.index(plainest.axis)
        ways, between = _likeliest_ways(outputs, single_approach, ways, axis, len(axes))
        package = _shown(outputs, single_approach, ways)
        shared = _as_shown(_plainest(package, known))
        if shared is None:
            break
        best = _by_replications(package, _beside_curves(package, shared, known))
        if not best.p_value <= level:
            break
        uncertainty = hypot(best.standard_uncertainty_rad, between)
        found.append(replace(best, standard_uncertainty_rad=uncertainty))
    if found and _remembers(package, [axes.index(play.axis) for play in found]):
        return ()
    return tuple(replace(play, ways_before=ways) for play in found)


def _shown(
    outputs: Sequence[OutputSeen], single_approach: frozenset[str], ways: tuple[float, ...]
) -> Sequence[ShownPlay]:
    every = (shown_play(evidence, index, single_approach, ways) for evidence, index in outputs)
    return [shown for shown in every if shown is not None]


def _least_chance(package: Sequence[ShownPlay]) -> float:
    """Return the chance of the plainer play, before anything else is asked of it."""
    square = np.sum([shown.square.diagonal() / shown.variance for shown in package], axis=0)
    along = np.sum([shown.along / shown.variance for shown in package], axis=0)
    most = max((x * x / s for x, s in zip(along.tolist(), square.tolist(), strict=True) if s > 0.0), default=0.0)
    return float(f_tail(most, 1.0, sum(shown.dof for shown in package)))


def _likeliest_ways(
    outputs: Sequence[OutputSeen], single_approach: frozenset[str], ways: tuple[float, ...], axis: int, axes: int
) -> tuple[tuple[float, ...], float]:
    """Return the ways, that of one axis where it is not known as it explains most; what is open by that, rad."""
    tried = []
    for way in (0.0, 1.0, -1.0):
        these = tuple(way if at == axis else known for at, known in enumerate(ways or (0.0,) * axes))
        play = next(_play(_shown(outputs, single_approach, these), axis, []), None)
        if play is not None:
            tried.append((play.square, play.size_rad, these))
    likely = [each for each in tried if each[0] >= max(tried)[0] - _AS_LIKELY]
    chosen = likely[0] if likely[0][2][axis] == 0.0 else max(likely)
    return chosen[2], max(abs(size - chosen[1]) for _, size, _ in likely)


def _plainest(package: Sequence[ShownPlay], known: Sequence[int]) -> Play:
    """Return the play that the outputs show most plainly, that of the ``known`` axes beside it."""
    tested = [play for axis in range(len(package[0].axes)) if axis not in known for play in _play(package, axis, known)]
    return min(tested, key=lambda play: (play.p_value, -play.square), default=_NONE)


def _play(package: Sequence[ShownPlay], axis: int, known: Sequence[int]) -> Iterator[Play]:
    """Yield the play of one axis, that of the ``known`` ones beside it, where any output sees it."""
    each = [(shown.base.nominal_axis, _estimate(shown, axis, known)) for shown in package]
    seeing = tuple((name, estimate) for name, estimate in each if estimate.uncertainty > 0.0)
    if not seeing:
        return
    whole = _joined(estimate for _, estimate in seeing)
    yield Play(package[0].axes[axis], whole.size, whole.uncertainty, whole.dof, whole.p_value, seeing)


def _joined(estimates: Iterator[Estimate]) -> Estimate:
    """Return what the outputs say together; their scatters have the degrees of freedom of all."""
    every = list(estimates)
    return replace(joined(every), dof=sum(estimate.dof for estimate in every))


def _estimate(shown: ShownPlay, axis: int, known: Sequence[int]) -> Estimate:
    square, along = shown.square[axis, axis], shown.along[axis]
    if known and square > 0.0:
        beside = shown.square[np.ix_(known, known)]
        across = np.linalg.pinv(beside, rcond=_NOTHING, hermitian=True) @ shown.square[known, axis]
        square, along = square - across @ shown.square[known, axis], along - across @ shown.along[known]
    if not square > _NOTHING * float(shown.k @ shown.k):
        return Estimate(np.nan, np.nan, np.nan)
    return Estimate(float(along / square), float(np.sqrt(shown.variance / square)), shown.dof)


def _as_shown(play: Play) -> Play | None:
    """Return the play as the outputs tell it; None where it is one output's: others that see it do not show it.

    Where no other sees it, it is that of the one output which does.
    """
    each = [estimate for _, estimate in play.of_outputs]
    if len(each) == 1:
        return play
    apart = sum(((estimate.size - play.size_rad) / estimate.uncertainty) ** 2 for estimate in each) / (len(each) - 1)
    if float(f_tail(apart, float(len(each) - 1), play.dof)) < _UNLIKE:
        return None
    most = max(range(len(each)), key=lambda at: abs(each[at].size / each[at].uncertainty))
    others = _joined(estimate for at, estimate in enumerate(each) if at != most)
    if others.p_value <= _OTHERS_SHOW and others.size * play.size_rad > 0.0:
        return play
    return replace(play, of_outputs=(play.of_outputs[most],)) if abs(play.size_rad) < others.uncertainty else None


def _beside_curves(package: Sequence[ShownPlay], play: Play, known: Sequence[int]) -> Play:
    """Return the play as curves of index errors of its axis leave it, where an order that repeats shows it."""
    if any(shown.q is None for shown in package):
        return play
    matrix, right = _with_curves(package, package[0].axes.index(play.axis), known)
    values, vectors = np.linalg.eigh(matrix[1:, 1:])
    kept = values > _NOTHING * values[-1]
    unit = vectors[:, kept] / np.sqrt(values[kept])
    seen, of_curves = unit.T @ matrix[1:, 0], unit.T @ right[1:]
    square = float(matrix[0, 0] - seen @ seen)
    if square >= _BESIDE_CURVES * matrix[0, 0]:
        return _sized(play, float(right[0] - seen @ of_curves) / square, square**-0.5, play.dof)
    size, numbers = float(right[0] / matrix[0, 0]), unit.shape[1] - 1
    beside = of_curves - size * seen
    scatter = float(beside @ beside) / max(numbers, 1)
    if scatter <= 1.0 or numbers < 1:
        return play
    return _sized(play, size, float(np.sqrt(scatter / matrix[0, 0])), float(numbers))


def _with_curves(package: Sequence[ShownPlay], axis: int, known: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Return normal equations of the play of an axis and of its errors at each index, that of ``known`` axes beside."""
    parts = []
    for shown in package:
        columns = np.hstack([shown.left[:, [axis, *known]], shown.projected(_index_columns(shown, axis))])
        joined = np.column_stack([columns, shown.reading])
        parts.append(columns.T @ joined / shown.variance)
    whole = np.sum(parts, axis=0)
    beside, rest = list(range(1, 1 + len(known))), [0, *range(1 + len(known), whole.shape[0])]
    if known:
        whole = whole - whole[:, beside] @ np.linalg.solve(whole[np.ix_(beside, beside)], whole[beside])
    return whole[np.ix_(rest, rest)], whole[rest, -1]


def _by_replications(package: Sequence[ShownPlay], play: Play) -> Play:
    """Return the play held against what it scatters by from replication to replication, where that is plainly more.

    What happened at a few dwells, and dwells that know of each other, show it in some replications and not in others.
    """
    each = [shown.by_replication(shown.axes.index(play.axis)) for shown in package]
    along, square = (np.sum(parts, axis=0) for parts in zip(*each, strict=True))
    is_seen = square > _NOTHING * square.max(initial=0.0)
    sizes, weights = along[is_seen] / square[is_seen], square[is_seen]
    numbers = float(sizes.size - 1)
    if sizes.size < _LEAST_REPLICATIONS:
        return play
    scatter = float(weights @ (sizes - weights @ sizes / weights.sum()) ** 2) / numbers
    if scatter <= 1.0 or float(f_tail(scatter, numbers, play.dof)) > _PLAIN:
        return play
    return _sized(play, play.size_rad, play.standard_uncertainty_rad * float(np.sqrt(scatter)), numbers)


def _sized(play: Play, size: float, uncertainty: float, dof: float) -> Play:
    p_value = max(play.p_value, float(f_tail((size / uncertainty) ** 2, 1.0, dof)))
    return replace(play, size_rad=size, standard_uncertainty_rad=uncertainty, dof=dof, p_value=p_value)


def _index_columns(shown: ShownPlay, axis: int) -> FloatArray:
    """Return the (N, t) change of an output by a radian at each index of an axis."""
    name: What = shown.axes[axis]
    angles = turned_by(shown.base, shown.evidence.rows)
    angle = angles[("pitch", "roll", "yaw").index(name)]
    assert angle is not None, "the axes are those of the table"
    columns, _ = standing_at(angle)
    pattern = slip_pattern(name, *angles)
    return columns * (pattern @ shown.k)[:, None]


def _remembers(package: Sequence[ShownPlay], axes: Sequence[int]) -> bool:
    """Return whether a memory of the sensors explains what the outputs show about as well as play of the axes does."""
    count = float(sum(shown.dof for shown in package))
    square = sum(shown.square[np.ix_(axes, axes)] / shown.variance for shown in package)
    along = sum(shown.along[axes] / shown.variance for shown in package)
    of_play = float(along @ np.linalg.solve(square, along)) - len(axes) * float(np.log(count))
    by_output = np.stack([_explained(shown) for shown in package])
    of_each = np.sum(by_output[:, 0] ** 2 / by_output[:, 1], axis=0) - len(package) * float(np.log(count))
    of_all = by_output[:, 0].sum(axis=0) ** 2 / by_output[:, 1].sum(axis=0) - float(np.log(count))
    return bool(max(of_each.max(), of_all.max()) > of_play - _PLAINER)


def _explained(shown: ShownPlay) -> FloatArray:
    """Return (2, c) products and squares, over the variance, of each memory against the sensitivity."""
    evidence, base = shown.evidence, shown.base
    order, force = evidence.time_order, sensed_force(base, evidence.rows)
    along = force[:, AXES.index(base.nominal_axis)].copy()
    before = force[previous_attitude.dwell_before(order, evidence.layout)] - force
    hysteresis = 0.5 * last_way(along, order, evidence.rows.step)
    columns = np.column_stack([previous_attitude.memories(evidence, base), hysteresis, before])
    left = shown.projected(columns) * float(np.linalg.norm(shown.k))
    squares = np.einsum("sc,sc->c", left, left)
    return np.stack([left.T @ shown.reading, np.maximum(squares, _NOTHING * float(shown.k @ shown.k))]) / shown.variance
