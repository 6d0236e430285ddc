"""Whether something comes and goes in step with the replications: all outputs of a package, alike in each replication.

Hum of the mains that beats with the readings, a chamber or an air conditioning that cycles: what has a replication, a
half or a third of it for its period is the same in every replication where the order of the points is, and no scatter
between them holds it. Of each wave over the dwells of a replication a part goes with the attitudes and is in offset and
sensitivities; there and back, one cosine a replication is f_x itself. What the points show is the rest.

One wave at a time of one, two and three periods is asked for by the means of the points: as one voltage on all outputs,
as a tilt of the base about both of its axes, and by an amount of each output. Beside it stands what an output may show
by itself, the terms of low order, and what all of them show of the table, its squareness, its tilt and any curve of
index errors of each axis. What it explains is held against Fisher's F. Source: decision 105.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.tested_terms import terms_of_accelerometer
from ams.analysis.diagnostics.time_order import means_of_points
from ams.arrays import FloatArray
from ams.calibration.together.errors_of_table import (
    Sensed,
    SharedColumns,
    Spanned,
    beside,
    errors_of_table,
    sensed,
    sensed_nominally,
)
from ams.calibration.together.in_step_between import judge_between
from ams.calibration.together.in_step_found import TILTS, WAVES, InStep, Way, waves_at, waves_of
from ams.calibration.together.shown_outputs import (
    MAY_SHOW,
    OutputSeen,
    ShownOutput,
    attitude_where_read,
    rolled_base,
    shown_output,
)
from ams.remembered import remembered
from ams.statistics.distributions import f_tail

_FEWEST: Final = 2
"""Outputs: of one alone, index errors and terms have all of it."""
_SEEN: Final = 0.01
"""Of the square of a wave: of which less is left beside all else, is a part of that."""
_GROUPS: Final[tuple[tuple[Way, int], ...]] = tuple(
    (way, wave) for way in ("meter", "base", "outputs") for wave in range(1, WAVES + 1)
)
_OF_METER: Final = slice(0, 2 * WAVES)
_OF_BASE: Final = slice(2 * WAVES, 6 * WAVES)
"""Among the columns of an output."""
_TILTED: Final = 4 * WAVES
"""The first of those that all outputs share."""


class _Design(NamedTuple):
    """Of one output at K points."""

    waves: FloatArray
    """(K, 6) beside what it may show by itself."""
    shared: SharedColumns
    """Of the tilts and of the table."""


class _Directions(NamedTuple):
    """Of unit length, of s outputs below one another."""

    of_table: Spanned
    of_waves: FloatArray
    """(s K, r) what is seen of each group, one after the other."""
    ranks: tuple[int, ...]
    """Of each group."""


def judge_in_step(outputs: Sequence[OutputSeen], level: float) -> InStep | None:
    """Return what comes and goes in step with the replications, where it is shown at a ``level``; None: nothing is."""
    if len(outputs) < _FEWEST:
        return None
    if not all(evidence.order_repeats for evidence, _ in outputs):
        return judge_between(outputs, level)
    shown = [found for evidence, index in outputs if (found := _shown(evidence, index)) is not None]
    if len(shown) < _FEWEST or len({output.left.size for output in shown}) > 1:
        return None
    dof = sum(output.dof for output in shown)
    nominal = _nominal(tuple(output.axis for output in shown), tuple(output.design for output in shown))
    alike = np.concatenate([output.left for output in shown])
    if not np.min(_chances(nominal, alike, dof)) * len(_GROUPS) <= MAY_SHOW * level:
        return None
    scale = np.array([(output.left @ output.left / output.dof) ** -0.5 for output in shown])
    per_g = np.array([output.per_g for output in shown])
    shared = sensed([(output.design.shared, output.k / output.per_g) for output in shown])
    columns = _columns([output.design.waves for output in shown], shared, per_g)
    directions = _directions(columns * scale[:, None, None], shared.weighed(scale), scale, per_g)
    reading = np.concatenate([each * output.left for each, output in zip(scale, shown, strict=True)])
    chances = _chances(directions, reading, dof) * len(_GROUPS)
    if not np.min(chances) <= level:
        return None
    way = _GROUPS[int(np.argmin(chances))][0]
    of_way = sorted((float(p), wave) for (each, wave), p in zip(_GROUPS, chances, strict=True) if each == way)
    waves = tuple(wave for p, wave in of_way if p <= level)
    return _estimated(shown, columns, scale, way, waves, (directions, reading, dof), of_way[0][0])


def _estimated(
    shown: Sequence[ShownOutput[_Design]],
    columns: FloatArray,
    scale: FloatArray,
    way: Way,
    waves: tuple[int, ...],
    given: tuple[_Directions, FloatArray, float],
    p_value: float,
) -> InStep:
    directions, reading, dof = given
    per_g = np.array([output.per_g for output in shown])
    left, lengths = _left(columns * scale[:, None, None], directions.of_table, way, waves, scale, per_g)
    squares, vectors = np.linalg.eigh(left.T @ left)
    seen = vectors[:, squares > _SEEN]
    covariance = seen / squares[squares > _SEEN] @ seen.T
    sizes = covariance @ (left.T @ reading)
    rest = directions.of_table.left_of(reading) - left @ sizes
    dof -= directions.of_table.rank + seen.shape[1]
    sizes, deviations = sizes / lengths, np.sqrt(np.diagonal(covariance) * (rest @ rest) / dof) / lengths
    pairs, of_pairs = sizes.reshape(-1, 2), deviations.reshape(-1, 2)
    largest = int(np.argmax(np.linalg.norm(pairs[:: len(waves)], axis=1))) * len(waves)
    along = pairs[largest] / np.linalg.norm(pairs[largest])
    axes = tuple(output.axis for output in shown)
    return InStep(way, waves, sizes, axes, float(np.linalg.norm(along * of_pairs[largest])), dof, p_value)


def _shown(evidence: Evidence, output: int) -> ShownOutput[_Design] | None:
    """Return what one output shows; None of one that tells nothing of it."""
    base = rolled_base(evidence, output)
    if base is None:
        return None
    stood = attitude_where_read(evidence, base)
    waves = means_of_points(evidence.layout, waves_of(evidence.time_order, evidence.layout))
    terms = terms_of_accelerometer(evidence, base)
    design = _design(stood.pitch_rad, stood.roll_rad, stood.yaw_rad, evidence.basis, terms, waves)
    return shown_output(evidence, output, base, design, design.shared.q)


@remembered(16)
def _design(
    pitch_rad: FloatArray,
    roll_rad: FloatArray,
    yaw_rad: FloatArray | None,
    basis: FloatArray,
    terms: FloatArray,
    waves: FloatArray,
) -> _Design:
    tilts = [by(pitch_rad, roll_rad, yaw_rad)[:, :, None] * waves[:, None, :] for by in TILTS]
    q = spanned(np.hstack([basis, terms]))
    shared = beside(q, np.concatenate(tilts, axis=2), errors_of_table(pitch_rad, roll_rad, yaw_rad))
    return _Design(waves - q @ (q.T @ waves), shared)


@remembered(16)
def _nominal(axes: tuple[str, ...], designs: tuple[_Design, ...]) -> _Directions:
    """Return the directions of outputs along nominal axes, all of one weight and one sensitivity."""
    alike, shared = np.ones(len(axes)), sensed_nominally(axes, [design.shared for design in designs])
    return _directions(_columns([design.waves for design in designs], shared, alike), shared, alike, alike)


def _columns(waves: Sequence[FloatArray], shared: Sensed, per_g: FloatArray) -> FloatArray:
    """Return (s, K, 18) waves of a volt, and tilts by a radian, as each output has them over its own k."""
    of_meter = np.stack(waves) / per_g[:, None, None]
    return np.concatenate([of_meter, shared.of_many[:, :, :_TILTED]], axis=2)


def _directions(columns: FloatArray, shared: Sensed, scale: FloatArray, per_g: FloatArray) -> _Directions:
    """Return the directions of (s, K, 18) columns beside the table, each output times its ``scale``, (s,)."""
    of_table, found = shared.spanned(_TILTED), list[FloatArray]()
    for way, wave in _GROUPS:
        left, _ = _left(columns, of_table, way, (wave,), scale, per_g)
        squares, vectors = np.linalg.eigh(left.T @ left)
        is_seen = squares > _SEEN
        found.append(left @ (vectors[:, is_seen] / np.sqrt(squares[is_seen])))
    return _Directions(of_table, np.hstack(found), tuple(each.shape[1] for each in found))


def _left(
    columns: FloatArray, of_table: Spanned, way: Way, waves: tuple[int, ...], scale: FloatArray, per_g: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return (s K, n) what the table leaves of some waves of a way, over what they are, and (n,) how long those are.

    By outputs: over the sensitivity of each.
    """
    outputs, points, _ = columns.shape
    at = waves_at(waves)
    if way == "outputs":
        by_output = columns[:, :, at] * per_g[:, None, None]
        whole = (by_output[:, :, None, :] * np.eye(outputs)[:, None, :, None]).reshape(outputs * points, -1)
        lengths = np.repeat(scale, len(at))
    elif way == "meter":
        whole = columns[:, :, at].reshape(outputs * points, -1)
        lengths = np.full(len(at), np.linalg.norm(scale / per_g))
    else:
        of_base = columns[:, :, _OF_BASE].reshape(outputs, points, len(TILTS), -1)[..., at]
        whole = of_base.reshape(outputs * points, -1)
        lengths = np.full(whole.shape[1], np.linalg.norm(scale))
    lengths = lengths * (0.5 * points) ** 0.5
    return of_table.left_of(whole) / lengths, lengths


def _chances(directions: _Directions, reading: FloatArray, dof: float) -> FloatArray:
    """Return the chance of what each group explains of (s K,) readings; 1 of one that is not seen."""
    left = directions.of_table.left_of(reading)
    ranks = np.array(directions.ranks)
    ends = np.cumsum(ranks)
    passed = np.append(0.0, np.cumsum((directions.of_waves.T @ reading) ** 2))
    explained = passed[ends] - passed[ends - ranks]
    free = dof - directions.of_table.rank - ranks
    rest = np.maximum(float(left @ left) - explained, 0.0) / free
    numbers = np.maximum(ranks, 1)
    return np.where(ranks > 0, f_tail(explained / numbers / rest, numbers.astype(float), free), 1.0)
