"""As how many tests those count that are not independent of one another.

The chance that any of m tests rings at a level α each is at most Σ P(Aᵢ) − Σ P(Aᵢ ∩ Aⱼ), the second sum over the edges
of any tree that joins them: two that all but say the same thing count little more than one. The best tree is the one
that spans the most. Sources: Hunter (1976), Worsley (1982); for the chance that two ring at once Plackett (1954).
"""

import numpy as np

from ams.arrays import FloatArray
from ams.statistics.distributions import normal_quantile

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def counted(correlation: FloatArray, level: float) -> float:
    """Return as how many tests (c, c) correlated normal variables count, each two-sided at ``level``: c at most."""
    both = ring_together(correlation, level)
    size, spared = both.shape[0], 0.0
    nearest = both[0].copy()
    nearest[0] = -1.0
    is_in = np.arange(size) == 0
    for _ in range(size - 1):  # Prim: the nearest of those outside joins the tree
        index = int(np.argmax(nearest))
        spared += float(nearest[index])
        is_in[index] = True
        nearest = np.where(is_in, -1.0, np.maximum(nearest, both[index]))
    return float(size - spared / level)


def ring_together(correlation: FloatArray, level: float) -> FloatArray:
    """Return the chance that two normal variables are both beyond their two-sided ``level``, to the same side of it.

    To opposite sides they are beyond far less often; leaving that out errs towards independence.
    """
    square = float(normal_quantile(1.0 - 0.5 * level)) ** 2
    half = 0.5 * np.arcsin(np.clip(np.abs(correlation), 0.0, 1.0))
    angles = half[..., None] * (1.0 + _NODES)
    grown = half * (np.exp(-square / (1.0 + np.sin(angles))) @ _WEIGHTS) / (2.0 * np.pi)
    return np.asarray(2.0 * ((0.5 * level) ** 2 + grown))
