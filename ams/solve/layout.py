"""Which row belongs to which replication and which point: the bookkeeping under every replicated solution."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ams.arrays import FloatArray, IntArray
from ams.errors import ObservationsError
from ams.observations import Observations
from ams.remembered import known, remembered


@dataclass(frozen=True, eq=False)
class Layout:
    """n replications of K points, N rows; every (replication, point) pair at most once.

    Rows that are labelled alike share one layout, which is known by its identity.
    """

    replication: IntArray
    """(N,) index 0 … n−1."""
    point: IntArray
    """(N,) index 0 … K−1."""
    replication_labels: tuple[int, ...]
    point_labels: tuple[int, ...]

    @property
    def rows(self) -> int:
        return int(self.replication.size)

    @property
    def replications(self) -> int:
        return len(self.replication_labels)

    @property
    def points(self) -> int:
        return len(self.point_labels)

    @cached_property
    def is_complete(self) -> bool:
        return self.rows == self.replications * self.points

    @cached_property
    def readings(self) -> FloatArray:
        """(K,) rows of every point."""
        return np.bincount(self.point, minlength=self.points).astype(float)

    @cached_property
    def typical_readings(self) -> float:
        """Of a point: the mean of all."""
        return float(self.readings.mean())

    @cached_property
    def relative_readings(self) -> FloatArray:
        """(K,) rows of every point over their mean."""
        return self.readings / self.typical_readings

    @cached_property
    def dwell(self) -> IntArray:
        """(N,) number of every row in the grid of all replications and points."""
        return known(self.replication * self.points + self.point)

    @cached_property
    def order(self) -> IntArray | None:
        """(N,) rows sorted by replication, then point; reshapes to (n, K) where complete. None: they stand so."""
        key = self.dwell
        return None if np.all(key[1:] > key[:-1]) else np.argsort(key)

    def missing(self) -> dict[int, tuple[int, ...]]:
        """Return the labels of the points that each replication lacks, by its label."""
        if self.is_complete:
            return {}
        present = np.zeros((self.replications, self.points), dtype=bool)
        present[self.replication, self.point] = True
        labels = np.array(self.point_labels)
        return {
            label: tuple(int(point) for point in labels[~here])
            for label, here in zip(self.replication_labels, present, strict=True)
            if not here.all()
        }

    def without_a_common_point(self) -> tuple[int, ...]:
        """Return the labels of the replications that no chain of common points joins to the first."""
        if self.is_complete or self.replications == 1:
            return ()
        present = np.zeros((self.replications, self.points), dtype=bool)
        present[self.replication, self.point] = True
        joined = np.arange(self.replications) == 0
        while (reached := present[:, present[joined].any(axis=0)].any(axis=1)).sum() > joined.sum():
            joined = reached
        return tuple(np.array(self.replication_labels)[~joined].tolist())

    def block(self, values: NDArray[Any]) -> NDArray[Any] | None:
        """Return the (K, …) values of one replication where (N, …) values are the same in each, one below the other.

        None elsewhere.
        """
        return _block(values, self.replications) if self.is_complete and self.order is None else None

    def sum_by_replication(self, values: FloatArray) -> FloatArray:
        """Return the (n, …) sums of (N, …) values."""
        return _sum_by(self.replication, values, self.replications)

    def sum_by_point(self, values: FloatArray) -> FloatArray:
        """Return the (K, …) sums of (N, …) values."""
        if self.is_complete and self.order is None:
            return np.asarray(values.reshape(self.replications, self.points, *values.shape[1:]).sum(axis=0))
        return _sum_by(self.point, values, self.points)

    def about_points(self, values: FloatArray) -> FloatArray:
        """Return (N, …) values less the mean of their point."""
        means = self.mean_by_point(values)
        if self.is_complete and self.order is None:
            return np.asarray((values.reshape(self.replications, *means.shape) - means).reshape(values.shape))
        return np.asarray(values - means[self.point])

    def mean_by_point(self, values: FloatArray) -> FloatArray:
        """Return the (K, …) means of (N, …) values."""
        if self.is_complete:
            return np.asarray(self.sum_by_point(values) / self.replications)
        return np.asarray((self.sum_by_point(values).T / self.readings).T)


@remembered(32)
def _block(values: NDArray[Any], replications: int) -> NDArray[Any] | None:
    blocks = values.reshape(replications, -1, *values.shape[1:])
    return blocks[0].copy() if (blocks[1:] == blocks[0]).all() else None


def _sum_by(index: IntArray, values: FloatArray, size: int) -> FloatArray:
    flat = values.reshape(values.shape[0], -1)
    sums = np.empty((size, flat.shape[1]))
    for column in range(flat.shape[1]):
        sums[:, column] = np.bincount(index, weights=flat[:, column], minlength=size)
    return sums.reshape(size, *values.shape[1:])


def layout_of(observations: Observations) -> Layout:
    """Sort the labels out.

    Raises:
        ObservationsError: there are no rows, a (replication, point) pair stands twice, or replications share no point.
    """
    if observations.rows == 0:
        raise ObservationsError(f"{observations.source}: no rows: nothing to solve; measure at least one replication")
    layout, twice = _layout(observations.replication, observations.point)
    if twice is not None:
        raise ObservationsError(
            f"{observations.source}: replication {layout.replication_labels[twice // layout.points]}, "
            f"point {layout.point_labels[twice % layout.points]} stands more than once; allowed once; "
            "nothing was solved; remove the repeated row or give it a point label of its own"
        )
    if apart := layout.without_a_common_point():
        named = f"replication{'s' * (len(apart) > 1)} {', '.join(map(str, apart))}"
        raise ObservationsError(
            f"{observations.source}: {named} and replication {layout.replication_labels[0]} have no point in common, "
            "nor through another replication: what drifts between them cannot be told from what differs between "
            "points; nothing was solved; give the same attitude the same number in column point of every replication, "
            "or, where they measured different attitudes, write them as one replication"
        )
    return layout


@remembered(8)
def _layout(replications: IntArray, points: IntArray) -> tuple[Layout, int | None]:
    """Return the layout, and the first pair that stands twice."""
    replication_labels, replication = _indexed(replications)
    point_labels, point = _indexed(points)
    pair = replication * point_labels.size + point
    readings = np.bincount(pair)
    twice = int(pair[np.flatnonzero(readings[pair] > 1)[0]]) if readings.max() > 1 else None
    return Layout(replication, point, tuple(replication_labels.tolist()), tuple(point_labels.tolist())), twice


def _indexed(labels: IntArray) -> tuple[IntArray, IntArray]:
    """Return sorted distinct labels, and the place of every label among them."""
    low, span = int(labels.min()), int(labels.max()) - int(labels.min()) + 1
    if span > 16 * labels.size:
        distinct, index = np.unique(labels, return_inverse=True)
        return distinct.astype(np.int64), index.astype(np.int64)
    present = np.bincount(labels - low, minlength=span) > 0
    return np.flatnonzero(present) + low, (np.cumsum(present) - 1)[labels - low]
