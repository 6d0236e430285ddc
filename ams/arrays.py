"""The arrays that are handed about: one name for each kind of number."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Centring = tuple[tuple[float, float, float, float], ...]
"""What is taken off each term of a model, as rows of a constant and three directions; hashable, so no array."""
