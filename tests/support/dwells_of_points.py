"""The layout of dwells of which only the point counts."""

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout


def layout_of_points(point: NDArray[np.int64]) -> Layout:
    """Return the layout of (N,) dwells at these points, all of one replication."""
    labels, index = np.unique(point, return_inverse=True)
    return Layout(np.zeros_like(index), index, (1,), tuple(labels.tolist()))
