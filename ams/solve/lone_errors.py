"""Common errors that reach one row alone: at angles of its own a dwell shares no index of the table with any other.

Such an error is variance of that row and no column: all that reach it add up, so that rows at angles of their own have
no more columns than a grid has.
"""

import numpy as np

from ams.arrays import FloatArray


def lone_apart(common: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the (…, K) variances of rows by errors of one row alone, and the (…, K, q) columns of the others.

    ``common``: (…, K, q), whose covariance G Gᵀ is that of both. A column that reaches nothing is left out.
    """
    reached = common.any(axis=tuple(range(common.ndim - 2)))
    reaches = np.count_nonzero(reached, axis=0)
    lone = common[..., reaches == 1]
    return np.asarray(np.vecdot(lone, lone)), common[..., reaches > 1]


def column_by_row(common: FloatArray) -> FloatArray:
    """Return (…, K, q) columns of the same covariance, with one for all errors that reach the same row alone."""
    variance, others = lone_apart(common)
    reached = np.flatnonzero(variance.any(axis=tuple(range(variance.ndim - 1))))
    alone = np.sqrt(variance)[..., reached, None] * np.eye(variance.shape[-1])[reached][:, reached]
    whole = np.zeros((*variance.shape, reached.size))
    whole[..., reached, :] = alone
    return np.concatenate([others, whole], axis=-1)
