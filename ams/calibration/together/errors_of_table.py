"""What errors of the table do to the force at its points: what all outputs of a package share.

An error of an index turns the force at the points that stand there, and nowhere else. On a grid every point shares its
indices with others and these with all the rest. Where points stand at angles of their own there are as many indices as
points: what these span is found point by point, or for the few together that share an index, at a cost that grows with
their number and not with the cube of it.
"""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from ams.analysis.diagnostics.step_patterns import What, slip_pattern
from ams.arrays import FloatArray, IntArray
from ams.frames import AXES
from ams.inputs.indices import index_around

SQUARENESS_AND_TILT: Final = 2
"""The first columns, not in this order: axes out of square, and a base that stands off about its forward axis."""
NOTHING: Final = 1e-6
"""Of the square of a column: less is left beside others by rounding."""
_FEW: Final = 8
"""Points that hang together by indices that no others share: for more, one column an index costs less."""


class TableErrors(NamedTuple):
    """Changes of the force at K points by one radian of each error of the table."""

    of_many: FloatArray
    """(K, 3, c) of tilt, squareness, and an error at each index that many points share."""
    slopes: FloatArray
    """(K, 3, a) by each of the axes, where it stands at an index that few share; zero elsewhere. a = 0: none is."""
    at: IntArray
    """(K, 1 + axes) the number of the points that hang together by such indices, and of the index of each axis."""


def errors_of_table(pitch_rad: FloatArray, roll_rad: FloatArray, yaw_rad: FloatArray | None) -> TableErrors:
    """Return tilt, squareness, and an error at each index of each axis."""
    angles: dict[What, FloatArray | None] = {"pitch": pitch_rad, "roll": roll_rad, "yaw": yaw_rad}
    moved = {axis: angle for axis, angle in angles.items() if angle is not None}
    sideways = np.stack([np.zeros_like(roll_rad), np.cos(roll_rad), -np.sin(roll_rad)], axis=1)
    of_axes = np.stack([sideways, sideways * np.sin(pitch_rad)[:, None]], axis=2)
    slopes = [slip_pattern(axis, pitch_rad, roll_rad, yaw_rad) for axis in moved]
    indices = np.stack([index_around(angle)[0] for angle in moved.values()], axis=1)
    is_rare = np.stack([(np.bincount(index) <= _FEW)[index] for index in indices.T], axis=1)
    together = _together(np.where(is_rare, indices, indices.shape[0] + np.arange(indices.shape[0])[:, None]))
    are_few = is_rare & (np.bincount(together) <= _FEW)[together, None]
    of_many = [
        slope[:, :, None] * (index[:, None] == np.unique(index[~of_few]))[:, None, :]
        for slope, index, of_few in zip(slopes, indices.T, are_few.T, strict=True)
    ]
    few = np.stack(slopes, axis=2) * are_few[:, None]
    few = few if are_few.any() else few[:, :, :0]
    return TableErrors(np.concatenate([of_axes, *of_many], axis=2), few, np.column_stack([together, indices]))


class SharedColumns(NamedTuple):
    """Of one output at K points: what it may show by itself, and what all outputs share, by the force."""

    q: FloatArray
    """(K, P) orthonormal, what it may show by itself."""
    of_many: FloatArray
    """(K, 3, c) what that leaves of the columns of others, and of those of the table."""
    slopes: FloatArray
    at: IntArray
    """As in :class:`TableErrors`, whole."""

    @property
    def width(self) -> int:
        """How many columns there are."""
        is_few = np.asarray(self.slopes.any(axis=1))
        of_few = (np.unique(self.at[is_few[:, axis], 1 + axis]) for axis in range(is_few.shape[1]))
        return int(self.of_many.shape[2]) + sum(index.size for index in of_few)


def beside(q: FloatArray, others: FloatArray, table: TableErrors) -> SharedColumns:
    """Return what (K, P) orthonormal ``q`` leave of (K, 3, n) others, which come first, and of the table's errors."""
    whole = np.concatenate([others, table.of_many], axis=2)
    flat = whole.reshape(q.shape[0], -1)
    return SharedColumns(q, (flat - q @ (q.T @ flat)).reshape(whole.shape), table.slopes, table.at)


class Sensed(NamedTuple):
    """What s outputs share, as each of them senses it at K points."""

    of_many: FloatArray
    """(s, K, c)"""
    slopes: FloatArray
    """(s, K, a)"""
    at: IntArray
    """(K, 1 + a)"""
    given: tuple[FloatArray, ...]
    """What each may show by itself."""

    def weighed(self, scale: FloatArray) -> "Sensed":
        """Return them times (s,) scales of the outputs."""
        return self._replace(of_many=self.of_many * scale[:, None, None], slopes=self.slopes * scale[:, None, None])

    def without_indices(self, first: int) -> "Sensed":
        """Return the first columns alone."""
        return self._replace(of_many=self.of_many[:, :, :first], slopes=self.slopes[:, :, :0])

    def spanned(self, first: int) -> "Spanned":
        """Return what the columns span, but for the first ones."""
        return _spanned(self.of_many[:, :, first:], self.slopes, self.at, self.given)


def sensed(each: Sequence[tuple[SharedColumns, FloatArray]]) -> Sensed:
    """Return what outputs share, by the (3,) direction in which each senses the force."""
    of_many = np.stack([shared.of_many.transpose(0, 2, 1) @ direction for shared, direction in each])
    slopes = np.stack([shared.slopes.transpose(0, 2, 1) @ direction for shared, direction in each])
    return Sensed(of_many, slopes, each[0][0].at, tuple(shared.q for shared, _ in each))


def sensed_nominally(axes: Sequence[str], each: Sequence[SharedColumns]) -> Sensed:
    """Return what outputs along nominal axes share."""
    return sensed([(shared, np.eye(3)[AXES.index(axis)]) for shared, axis in zip(each, axes, strict=True)])


class Spanned(NamedTuple):
    """What columns of s outputs below one another span, (s K,)."""

    across: FloatArray
    """(s K, r) orthonormal directions, beside those of few points."""
    of_few: tuple[tuple[IntArray, FloatArray], ...]
    """(M, n) rows that hang together, and (M, n, w) their directions, of unit length or zero."""
    rank: int

    def left_of(self, columns: FloatArray) -> FloatArray:
        """Return what is left of (s K,) or (s K, n) columns."""
        left = columns - self.across @ (self.across.T @ columns)
        return left - _along(self.of_few, columns) if self.of_few else left


def _spanned(of_many: FloatArray, slopes: FloatArray, at: IntArray, given: Sequence[FloatArray]) -> Spanned:
    """Return what (s, K, c) columns and the indices of few points span, beside what is ``given``.

    ``given``: (K, P) orthonormal columns of each output alone. They are taken out of the columns already, and of
    whatever is held against what is returned.
    """
    flat = of_many.reshape(of_many.shape[0] * of_many.shape[1], of_many.shape[2])
    if not slopes.any():
        across = directions_of(flat)
        return Spanned(across, (), across.shape[1])
    longest = float(np.vecdot(flat.T, flat.T).max(initial=0.0))
    of_few = _of_few(slopes, at, longest)
    # Of readings beside the columns given, few points and these columns together leave what the part of the former
    # beside the latter leaves of them.
    whole = below(given)
    left_given = directions_of(whole - _along(of_few, whole), 1.0)
    left = flat - _along(of_few, flat)
    rest = directions_of(left - left_given @ (left_given.T @ left), longest)
    rank = sum(int(np.count_nonzero(directions.any(axis=1))) for _, directions in of_few)
    across = np.hstack([left_given, rest])
    return Spanned(across, of_few, rank + across.shape[1] - whole.shape[1])


def directions_of(columns: FloatArray, least: float = 0.0) -> FloatArray:
    """Return (N, r) orthonormal directions of (N, c) columns; what is left beside others by rounding is none.

    ``least``: the square of the longest, before others were taken out of them.
    """
    squares, vectors = np.linalg.eigh(columns.T @ columns)
    kept = squares > NOTHING * squares.max(initial=least)
    return np.asarray(columns @ (vectors[:, kept] / np.sqrt(squares[kept])))


def below(parts: Sequence[FloatArray]) -> FloatArray:
    """Return (s K, …) columns of s outputs, each of one of them alone."""
    points, widths = parts[0].shape[0], [part.shape[1] for part in parts]
    found, ends = np.zeros((len(parts) * points, sum(widths))), np.cumsum(widths).tolist()
    for row, (part, end, width) in enumerate(zip(parts, ends, widths, strict=True)):
        found[row * points : (row + 1) * points, end - width : end] = part
    return found


def _together(indices: IntArray) -> IntArray:
    """Return (K,) the number of those points of (K, a) indices that share any, or are joined by others that do."""
    number = np.arange(indices.shape[0])
    while True:
        least = number.copy()
        for index in indices.T:
            smallest = np.full(int(index.max()) + 1, number.size)
            np.minimum.at(smallest, index, least)
            least = smallest[index]
        if np.array_equal(least, number):
            return np.asarray(np.unique(number, return_inverse=True)[1])
        number = least


def _of_few(slopes: FloatArray, at: IntArray, least: float) -> tuple[tuple[IntArray, FloatArray], ...]:
    """Return the rows of points that hang together, by how many these are, and the directions of their indices."""
    outputs, points, axes = slopes.shape
    each = list(_by_number(np.flatnonzero(slopes.any(axis=(0, 2))), at[:, 0]))
    found = []
    for few in each:
        index = at[few, 1 : 1 + axes]
        alike = index[:, :, None] == index[:, None, :]
        is_first = np.argmax(alike, axis=1) == np.arange(few.shape[1])[None, :, None]
        columns = slopes[:, few][:, :, :, None] * (alike & is_first[:, None])
        rows = few[:, None] + (points * np.arange(outputs))[:, None]
        size = outputs * few.shape[1]
        found.append((rows.reshape(-1, size), columns.swapaxes(0, 1).reshape(-1, size, few.shape[1] * axes)))
    longest = max((float((columns**2).sum(axis=1).max()) for _, columns in found), default=0.0)
    return tuple((rows, _directions_each(columns, max(longest, least))) for rows, columns in found)


def _by_number(points: IntArray, together: IntArray) -> Iterator[IntArray]:
    """Return (M, g) points that hang together, for each number g of them."""
    order = points[np.argsort(together[points], kind="stable")]
    _, first, count = np.unique(together[order], return_index=True, return_counts=True)
    for size in np.unique(count).tolist():
        yield order[first[count == size][:, None] + np.arange(size)]


def _directions_each(columns: FloatArray, longest: float) -> FloatArray:
    """Return (M, n, w) orthogonal directions of columns, of unit length or zero."""
    squares, vectors = np.linalg.eigh(columns.swapaxes(1, 2) @ columns)
    kept = squares > NOTHING * longest
    return np.asarray(columns @ (vectors * np.where(kept, np.where(kept, squares, 1.0) ** -0.5, 0.0)[:, None, :]))


def _along(of_few: Sequence[tuple[IntArray, FloatArray]], columns: FloatArray) -> FloatArray:
    """Return the part of (s K,) or (s K, n) columns along the directions of few points."""
    flat = columns.reshape(columns.shape[0], -1)
    part = np.zeros_like(flat)
    for rows, directions in of_few:
        part[rows] = directions @ (directions.swapaxes(1, 2) @ flat[rows])
    return part.reshape(columns.shape)
