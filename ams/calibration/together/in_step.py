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

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.tested_terms import terms_of_accelerometer
from ams.analysis.diagnostics.time_order import means_of_points
from ams.arrays import FloatArray
from ams.calibration.together.errors_of_table import directions_of, errors_of_table
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
from ams.frames import AXES
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
_OF_TABLE: Final = slice(6 * WAVES, None)
"""Among the columns of an output."""


class _Design(NamedTuple):
    """Of one output at K points."""

    q: FloatArray
    """(K, P) what it may show by itself."""
    waves: FloatArray
    """(K, 6) what that leaves of the waves."""
    shared: FloatArray
    """(K, 3, c) what it leaves of the tilts and of the table, by the force."""


class _Directions(NamedTuple):
    """Of unit length, of s outputs below one another."""

    of_table: FloatArray
    """(s K, t)"""
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
    nominal = _nominal(tuple(output.axis for output in shown), *_parts(shown))
    alike = np.concatenate([output.left for output in shown])
    if not np.min(_chances(nominal, alike, dof)) * len(_GROUPS) <= MAY_SHOW * level:
        return None
    columns = np.stack([_columns(output.design, output.k / output.per_g, output.per_g) for output in shown])
    scale = np.array([(output.left @ output.left / output.dof) ** -0.5 for output in shown])
    directions = _directions(columns * scale[:, None, None], scale, np.array([output.per_g for output in shown]))
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
    beside = reading - directions.of_table @ (directions.of_table.T @ reading) - left @ sizes
    dof -= directions.of_table.shape[1] + seen.shape[1]
    sizes, deviations = sizes / lengths, np.sqrt(np.diagonal(covariance) * (beside @ beside) / dof) / lengths
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
    return shown_output(evidence, output, base, design, design.q)


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
    shared = np.concatenate([*tilts, errors_of_table(pitch_rad, roll_rad, yaw_rad)], axis=2)
    flat = shared.reshape(pitch_rad.size, -1)
    return _Design(q, waves - q @ (q.T @ waves), (flat - q @ (q.T @ flat)).reshape(shared.shape))


def _parts(shown: Sequence[ShownOutput[_Design]]) -> Iterator[FloatArray]:
    for output in shown:
        yield output.design.waves
        yield output.design.shared


@remembered(16)
def _nominal(axes: tuple[str, ...], *parts: FloatArray) -> _Directions:
    """Return the directions of outputs along nominal axes, all of one weight and one sensitivity."""
    each = zip(axes, parts[::2], parts[1::2], strict=True)
    columns = [np.hstack([waves, shared[:, AXES.index(axis)]]) for axis, waves, shared in each]
    return _directions(np.stack(columns), np.ones(len(axes)), np.ones(len(axes)))


def _columns(design: _Design, direction: FloatArray, per_g: float) -> FloatArray:
    """Return (K, c) waves of a volt, tilts by a radian and the table's errors, as one output has them over its own k.

    ``direction``: (3,) of its sensitive axis.
    """
    return np.hstack([design.waves / per_g, design.shared.transpose(0, 2, 1) @ direction])


def _directions(columns: FloatArray, scale: FloatArray, per_g: FloatArray) -> _Directions:
    """Return the directions of (s, K, c) columns, each output times its ``scale``, (s,)."""
    others = columns[:, :, _OF_TABLE].reshape(-1, columns.shape[2] - _OF_TABLE.start)
    of_table = directions_of(others)
    found = []
    for way, wave in _GROUPS:
        left, _ = _left(columns, of_table, way, (wave,), scale, per_g)
        squares, vectors = np.linalg.eigh(left.T @ left)
        is_seen = squares > _SEEN
        found.append(left @ (vectors[:, is_seen] / np.sqrt(squares[is_seen])))
    return _Directions(of_table, np.hstack(found), tuple(each.shape[1] for each in found))


def _left(
    columns: FloatArray, of_table: FloatArray, way: Way, waves: tuple[int, ...], scale: FloatArray, per_g: FloatArray
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
    return (whole - of_table @ (of_table.T @ whole)) / lengths, lengths


def _chances(directions: _Directions, reading: FloatArray, dof: float) -> FloatArray:
    """Return the chance of what each group explains of (s K,) readings; 1 of one that is not seen."""
    beside = directions.of_table.T @ reading
    ranks = np.array(directions.ranks)
    ends = np.cumsum(ranks)
    passed = np.append(0.0, np.cumsum((directions.of_waves.T @ reading) ** 2))
    explained = passed[ends] - passed[ends - ranks]
    free = dof - beside.size - ranks
    rest = np.maximum(float(reading @ reading) - float(beside @ beside) - explained, 0.0) / free
    numbers = np.maximum(ranks, 1)
    return np.where(ranks > 0, f_tail(explained / numbers / rest, numbers.astype(float), free), 1.0)
