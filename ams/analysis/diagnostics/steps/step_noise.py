"""How loud the dwells are that a change in mid-run is told by: a replication that was shaken is no change.

What dwells add up to along a column c is Σ c a, a of variance w v at each; where their noise v is not one, its variance
is Σ c² w v and not that of all, v̄ Σ c² w. The dwells tell it by themselves, as Σ c² a² (White 1980), and where they
are few by how much the whole of their replication scatters.
"""

from typing import Final

import numpy as np

from ams.arrays import FloatArray, IntArray
from ams.statistics.distributions import f_tail

_UNSTEADY: Final = 1e-4
"""Chance of as much more than all dwells where all scatter alike."""


def times_as_loud(along: FloatArray, weight: FloatArray, column: FloatArray, replication: IntArray, dof: int) -> float:
    """Return how many times the variance of all dwells those have that tell a change; 1 where chance may do as much.

    ``along`` (N,): what each adds; ``weight`` (N,): its variance for noise of one; ``column`` (N,): the change, less
    its mean at each point; ``replication`` (N,): from 0; ``dof``: of all dwells.
    """
    shown = weight * column**2
    square = float(shown.sum())
    left = along - weight * column * (float(along @ column) / square if square > 0.0 else 0.0)
    typical = float(left @ left) / max(float(weight.sum()), np.finfo(float).tiny)
    if not typical * square > 0.0:
        return 1.0
    scatter = np.bincount(replication, left**2) / np.maximum(np.bincount(replication, weight), np.finfo(float).tiny)
    shares = np.bincount(replication, shown)
    dwells = np.array([square**2 / float(shown @ shown), square**2 / np.sum(shares**2 / np.bincount(replication))])
    ratios = np.array([float(column**2 @ left**2), float(shares @ scatter)]) / (typical * square)
    is_plain = f_tail(np.maximum(ratios, 1.0), dwells, float(dof)) < _UNSTEADY
    return float(np.where(is_plain, ratios, 1.0).max(initial=1.0))
