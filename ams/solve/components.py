"""Independent parts of the covariances of several sensor axes that were solved together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import VarianceComponent

NOT_OF_EVERY_AXIS = ("lack-of-fit", "resolution")
"""Parts that one axis may have and another not."""


@dataclass(frozen=True)
class Causes:
    """What one part of the covariances comes from, cause by cause: covariance = scale² effects effectsᵀ.

    The causes of several estimates stand in the same order: the same replication, the same point, the same index of the
    table. That is what the covariance between two sensor axes of a package is made from.
    """

    effects: FloatArray
    """(m, P, r), or (P, r) where they are the same for every estimate."""
    scale: FloatArray
    """(m,)"""
    signs: FloatArray | None = None
    """(r, m) how each cause came out for each estimate, where the causes are of the estimate's own (a point's lack of
    fit): two axes' are correlated as their signs are. None: the cause is one and the same for all (an index)."""

    def of(self, row: int) -> FloatArray:
        """Return the (P, r) effects of one estimate."""
        effects = self.effects if self.effects.ndim == 2 else self.effects[row]
        return np.asarray(self.scale[row] * effects)


@dataclass(frozen=True)
class ComponentColumns:
    """One part of the covariances of m estimates."""

    name: str
    covariance: FloatArray
    """(m, P, P)"""
    dof: FloatArray
    """(m,) degrees of freedom it was estimated with; infinite for what a certificate states."""
    causes: Causes | None = None
    """None: every estimate's are its own, and nobody else's."""


def components_of(columns: Sequence[ComponentColumns], index: int) -> tuple[VarianceComponent, ...]:
    """Return the components of one estimate; a part that is not there (no lack of fit, no steps) is left out."""
    return tuple(
        VarianceComponent(part.name, part.covariance[index], float(part.dof[index]))
        for part in columns
        if part.name not in NOT_OF_EVERY_AXIS or part.covariance[index].any()
    )
