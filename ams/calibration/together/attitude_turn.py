"""Whether the package turns with its attitude: all its outputs by one rotation that passes for terms of each.

Where the centre of mass of a package stands off a mount that yields, it turns by r × f; a shaft that wobbles or sags
turns it about the axes of the arm, and cables by pitch or by roll. A rotation leaves |f| = 1, and every output s reads
k_s·∂f/∂θ θ(α, R) more: K₂, K_ip, K_io and others of every output, none of which is the sensor's.

One θ of each course is estimated from the means of the points of all outputs, beside the linear sensor and what the
order of the points leaves of each, and beside squareness, tilt and any curve of index errors, which all share. It is
held against the scatter beside all terms of low order (Fisher's F), and against these terms: sensors' own differ from
output to output, and one θ of few numbers explains little of them; one that the package has leaves nothing of them.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.evidence import Evidence
from ams.analysis.diagnostics.over_time.order_columns import left_by_order
from ams.analysis.diagnostics.point_means import spanned
from ams.analysis.diagnostics.sensed_force import Accelerometer, turned_by
from ams.analysis.diagnostics.tested_terms import terms_of_accelerometer
from ams.arrays import FloatArray
from ams.calibration.together.attitude_turn_found import (
    COLUMNS,
    AttitudeTurn,
    Course,
    columns_of,
    rotations,
    turned_with_attitude,
)
from ams.calibration.together.errors_of_table import (
    SharedColumns,
    Spanned,
    below,
    beside,
    directions_of,
    errors_of_table,
    sensed,
    sensed_nominally,
)
from ams.calibration.together.shown_outputs import LEAST_DOF, MAY_SHOW, OutputSeen, attitude_where_read, rolled_base
from ams.models.accelerometer import LINEAR_COLUMNS
from ams.models.extended import ExtendedPitchRoll
from ams.remembered import remembered
from ams.statistics.distributions import f_tail

_FEWEST: Final = 2
"""Outputs."""
_OTHERS_SHOW: Final = 0.01
"""Chance of as much without the output that shows it most."""
_SEEN: Final = 0.02
"""Of the square of a column, summed over the outputs: of which less is left beside the table, is an error of that."""
_SIGMAS: Final = 3.0
"""Standard deviations of what the terms explain by noise."""
_LEFT: Final = 0.02
"""Of what the rotation explains: more, beyond noise, is not left to the terms of the sensors where it is all of it."""
_PLAINER: Final = 8.0
"""Than few terms of single outputs: in χ² + p ln n + 2 ln (of how many they are the best)."""
_PASSES: Final = 3
"""That find what each output scatters by."""
_OF_COURSES: Final = sum(COLUMNS.values())


class _Design(NamedTuple):
    """Of one output at K points."""

    shared: SharedColumns
    """Courses and errors of the table, beside the linear sensor and what the order of the points leaves."""
    terms: FloatArray
    """(K, 8) of unit length: each term of low order beside these."""
    every: FloatArray
    """(K, t) of unit length: all that they, and those that it is fitted with, span beside these."""
    rotations: FloatArray
    """(K, 3, c) of the courses."""


class _Shown(NamedTuple):
    """Of one output."""

    axis: str
    design: _Design
    k: FloatArray
    """(3,) over their length."""
    left: FloatArray
    """(K,) of its means over its sensitivity, beside ``q``."""
    variance: float
    """Of a mean, beside the terms."""
    precision_variance: float
    """The same by the replications."""
    dof: float
    """Of the variance."""


class _Explained(NamedTuple):
    """By one course: squares over the variances of the outputs."""

    course: Course
    columns: FloatArray
    """(s, K, c)"""
    spans: Spanned
    """By the errors of the table."""
    beside: FloatArray
    """(s K,) what these leave of the outputs."""
    products: FloatArray
    """(s,) of what each output shows and what the rotation does to it."""
    squares: FloatArray
    """(s,) of what the rotation does."""
    by_turn: float
    seen: int
    """Numbers of it that are seen."""
    by_terms: float
    """By all terms of the outputs beside it."""
    by_terms_dof: int
    by_few: FloatArray
    """(f,) by the best one, two and more terms of single outputs without it."""
    of_turn: float
    of_few: FloatArray
    """(f,) what their numbers, and the choice among them, count against the rotation and against these."""
    noise: float
    """What is left beside it and all terms."""
    repeating: float
    """Of that, what the scatter between replications does not explain."""
    dof: float
    """Of that."""


def judge_attitude_turn(outputs: Sequence[OutputSeen], level: float) -> AttitudeTurn | None:
    """Return the rotation that goes with attitude, where the outputs show it together at a ``level``; None: none."""
    if len(outputs) < _FEWEST:
        return None
    shown = [found for evidence, index in outputs if (found := _shown(evidence, index)) is not None]
    if len(shown) < _FEWEST or len({output.left.size for output in shown}) > 1:
        return None
    level /= len(COLUMNS)
    courses = _may_show(shown, MAY_SHOW * level)
    explained = [_explained(shown, course) for course in courses]
    plain = sorted((p_value, each) for each, by in enumerate(explained) if (p_value := _chance(by)) <= level)
    if not plain:
        return None
    p_value, plainest = plain[0]
    least = explained[plainest].by_turn - _PLAINER
    others = tuple(explained[each].course for _, each in plain[1:] if explained[each].by_turn > least)
    return _estimated(shown, p_value, explained[plainest], others, len(outputs))


def _chance(found: _Explained) -> float:
    """Return the chance of a course by noise; 1 where the terms of the outputs say as much, or more beside it."""
    variance, count = found.noise / found.dof, found.by_terms_dof
    most = int(np.argmax(found.squares))
    whole, product = (float(np.delete(each, most).sum()) for each in (found.squares, found.products))
    if not (product > 0.0 and float(f_tail(product**2 / whole / variance, 1.0, found.dof)) <= _OTHERS_SHOW):
        return 1.0
    by_noise = variance * (count + _SIGMAS * np.sqrt(2.0 * count))
    if found.by_terms - by_noise > _LEFT * found.by_turn or found.by_terms > found.by_turn:
        return 1.0
    if found.repeating > found.by_turn / variance:
        return 1.0
    if not found.by_turn / variance - found.of_turn >= np.max(found.by_few / variance - found.of_few) + _PLAINER:
        return 1.0
    return float(f_tail(found.by_turn / found.seen / variance, float(found.seen), found.dof))


def _explained(shown: Sequence[_Shown], course: Course) -> _Explained:
    """Return what a course explains of all outputs, each weighed by what it scatters by beside that and its terms."""
    variance, points = np.array([output.variance for output in shown]), shown[0].left.size
    precision = np.array([output.precision_variance for output in shown])
    terms, every = (below([part(output) for output in shown]) for part in (_terms_of, _every_of))
    columns = sensed([(output.design.shared, output.k) for output in shown])
    for _ in range(_PASSES):
        weighed = columns.weighed(variance**-0.5)
        reading = np.concatenate([output.left / np.sqrt(each) for output, each in zip(shown, variance, strict=True)])
        spans = weighed.spanned(_OF_COURSES)
        left = spans.left_of(reading)
        turned = _seen(weighed.of_many[:, :, columns_of(course)], spans)
        by_turn = turned @ (turned.T @ left)
        of_terms = directions_of(spans.left_of(every) - turned @ (turned.T @ every))
        by_terms = of_terms.T @ (left - by_turn)
        rest = (left - by_turn - of_terms @ by_terms).reshape(-1, points)
        dof = sum(output.dof for output in shown) - spans.rank - turned.shape[1]
        variance = variance * np.vecdot(rest, rest) * (len(shown) / dof)
    of_each, as_read = (each.reshape(-1, points) for each in (by_turn, left))
    numbers, of_number = turned.shape[1], float(np.log(left.size))
    return _Explained(
        course,
        weighed.of_many,
        spans,
        left,
        products=np.vecdot(of_each, as_read),
        squares=np.vecdot(of_each, of_each),
        by_turn=float(by_turn @ by_turn),
        seen=numbers,
        by_terms=float(by_terms @ by_terms),
        by_terms_dof=by_terms.size,
        by_few=_few(spans.left_of(terms), left, numbers + 1),
        of_turn=numbers * of_number + 2.0 * float(np.log(len(COLUMNS))),
        of_few=(of_number + 2.0 * float(np.log(terms.shape[1]))) * np.arange(1.0, numbers + 2.0),
        noise=float(np.vecdot(rest, rest).sum()),
        repeating=dof - float((precision * np.vecdot(rest, rest) / variance).sum()),
        dof=dof,
    )


def _terms_of(output: _Shown) -> FloatArray:
    return output.design.terms


def _every_of(output: _Shown) -> FloatArray:
    return output.design.every


def _few(terms: FloatArray, beside: FloatArray, most: int) -> FloatArray:
    """Return (most,) what one, two and more terms of single outputs explain, each the best beside those before."""
    left, rest, explained = terms.copy(), beside, []
    for _ in range(most):
        squares = np.vecdot(left.T, left.T)
        seen = squares > _SEEN
        along = np.where(seen, (left.T @ rest) ** 2 / np.where(seen, squares, 1.0), 0.0)
        best = int(np.argmax(along))
        explained.append(float(along[best]))
        if explained[-1] > 0.0:
            direction = left[:, best] / np.sqrt(squares[best])
            rest = rest - direction * (direction @ rest)
            left -= np.outer(direction, direction @ left)
    return np.asarray(np.cumsum(explained))


def _seen(columns: FloatArray, spans: Spanned) -> FloatArray:
    """Return (s K, r) directions of what the table leaves of the (s, K, c) columns of a course."""
    flat = columns.reshape(-1, columns.shape[2])
    whole = np.sqrt((flat**2).sum(axis=0))
    flat = flat / np.where(whole > 0.0, whole, 1.0)
    left = spans.left_of(flat)
    squares, vectors = np.linalg.eigh(left.T @ left)
    kept = squares > _SEEN
    return np.asarray(left @ (vectors[:, kept] / np.sqrt(squares[kept])))


def _estimated(
    shown: Sequence[_Shown], p_value: float, found: _Explained, others: tuple[Course, ...], outputs: int
) -> AttitudeTurn:
    flat = found.columns[:, :, columns_of(found.course)].reshape(found.beside.size, -1)
    lengths = np.linalg.norm(flat, axis=0)
    left = found.spans.left_of(flat) / lengths
    covariance = np.linalg.pinv(left.T @ left, rcond=_SEEN, hermitian=True)
    sizes = covariance @ (left.T @ found.beside) / lengths
    covariance = covariance * (found.noise / found.dof) / np.multiply.outer(lengths, lengths)
    turns = shown[0].design.rotations[:, :, columns_of(found.course)]
    square = np.tensordot(turns, turns, ((0, 1), (0, 1))) / turns.shape[0]
    about = np.sqrt(((turns @ sizes) ** 2).mean(axis=0))
    slope = square @ sizes / float(np.linalg.norm(about))
    return AttitudeTurn(
        found.course,
        others,
        sizes,
        covariance,
        found.dof,
        p_value,
        about,
        float(np.sqrt(slope @ covariance @ slope)),
        outputs,
    )


def _shown(evidence: Evidence, output: int) -> _Shown | None:
    """Return what one output shows; None of one that tells nothing of it, or too little to weigh it by."""
    base = rolled_base(evidence, output)
    if base is None:
        return None
    stood = attitude_where_read(evidence, base)
    pitch_rad, roll_rad, yaw_rad = turned_by(base, stood)
    if yaw_rad is not None:
        return None
    count = _count_of_terms(base)
    terms, in_order = terms_of_accelerometer(evidence, base), left_by_order(evidence, base, evidence.layout.points)
    design = _design(pitch_rad, roll_rad, evidence.basis, terms, in_order, count)
    dof = float(evidence.layout.points - design.shared.q.shape[1] - design.every.shape[1])
    if dof < LEAST_DOF:
        return None
    k = evidence.primary[output][1:LINEAR_COLUMNS]
    columns = slice(LINEAR_COLUMNS, LINEAR_COLUMNS + count)
    fitted = evidence.basis[:, columns] @ evidence.alone[columns, output]
    means = (evidence.point_effects[:, output] + fitted) / np.linalg.norm(k)
    left = means - design.shared.q @ (design.shared.q.T @ means)
    by_terms = design.every.T @ left
    variance = float(left @ left - by_terms @ by_terms) / dof
    if not variance > 0.0:
        return None
    precision = float(evidence.precision_variance[output]) / evidence.layout.typical_readings / float(k @ k)
    return _Shown(base.nominal_axis, design, k / np.linalg.norm(k), left, variance, precision, dof)


def _count_of_terms(base: Accelerometer) -> int:
    """Return how many terms of low order a model is fitted with."""
    return len(base.centring) if isinstance(base, ExtendedPitchRoll) else 0


@remembered(16)
def _design(
    pitch_rad: FloatArray, roll_rad: FloatArray, basis: FloatArray, terms: FloatArray, in_order: FloatArray, count: int
) -> _Design:
    linear = np.delete(basis, np.s_[LINEAR_COLUMNS : LINEAR_COLUMNS + count], axis=1)
    q = spanned(np.hstack([linear, in_order]))
    turned = turned_with_attitude(pitch_rad, roll_rad)
    every = np.hstack([basis[:, LINEAR_COLUMNS : LINEAR_COLUMNS + count], terms])
    left = terms - q @ (q.T @ terms)
    lengths = np.linalg.norm(left, axis=0)
    return _Design(
        beside(q, turned, errors_of_table(pitch_rad, roll_rad, None)),
        left / np.where(lengths > 0.0, lengths, 1.0),
        directions_of(every - q @ (q.T @ every)),
        rotations(pitch_rad, roll_rad),
    )


def _may_show(shown: Sequence[_Shown], level: float) -> list[Course]:
    """Return what the outputs may show at a level: each by its nominal axis, all of one weight."""
    axes = tuple(output.axis for output in shown)
    directions, ends, of_table = _nominal(axes, tuple(output.design.shared for output in shown))
    dof = sum(output.dof for output in shown) - of_table
    if dof < LEAST_DOF:
        return []
    reading = np.concatenate([output.left * output.variance**-0.5 for output in shown])
    squares = np.add.reduceat(np.append((directions.T @ reading) ** 2, 0.0), [0, *ends[:-1]])
    seen = np.diff([0, *ends]).astype(float)
    p_values = f_tail(squares / np.maximum(seen, 1.0), np.maximum(seen, 1.0), dof)
    return [course for course, p, count in zip(COLUMNS, p_values, seen, strict=True) if count and p <= level]


@remembered(16)
def _nominal(axes: tuple[str, ...], designs: tuple[SharedColumns, ...]) -> tuple[FloatArray, tuple[int, ...], int]:
    """Return (s K, r) directions of the courses along nominal axes beside the table, where each ends, and the table's.

    Of the table how many there are.
    """
    columns = sensed_nominally(axes, designs)
    spans = columns.spanned(_OF_COURSES)
    found = [_seen(columns.of_many[:, :, columns_of(course)], spans) for course in COLUMNS]
    ends = np.cumsum([each.shape[1] for each in found]).tolist()
    return np.hstack(found), tuple(ends), spans.rank
