"""The arrays that are handed about: one name for each kind of number; and blocks of them as one."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Centring = tuple[tuple[float, float, float, float], ...]
"""What is taken off each term of a model, as rows of a constant and three directions; hashable, so no array."""

_TOGETHER: Final = 64
"""Columns of some thousand rows that stay in the processor's memory while several passes are made over them."""


def column_blocks(columns: int) -> Iterator[slice]:
    """Yield the columns of a wide array, as many at a time as are worked on at one stroke."""
    yield from (slice(first, first + _TOGETHER) for first in range(0, columns, _TOGETHER))


def block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    """Return the (Σ N, Σ P) matrix in which each (N, P) block has rows and columns of its own."""
    whole = np.zeros((sum(len(block) for block in blocks), sum(block.shape[1] for block in blocks)))
    row = column = 0
    for block in blocks:
        whole[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    return whole
