"""Independent parts of the covariances of several sensor axes that were solved together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.solve.result import VarianceComponent

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ComponentColumns:
    """One part of the covariances of m estimates."""

    name: str
    covariance: FloatArray
    """(m, P, P)"""
    dof: FloatArray
    """(m,) degrees of freedom it was estimated with; infinite for what a certificate states."""

    def rows(self, chosen: Sequence[int]) -> "ComponentColumns":
        """The part of some of the estimates."""
        places = list(chosen)
        return ComponentColumns(self.name, self.covariance[places], self.dof[places])


def components_of(columns: Sequence[ComponentColumns], place: int) -> tuple[VarianceComponent, ...]:
    """Those of one estimate; a part that is not there (no lack of fit) is left out."""
    return tuple(
        VarianceComponent(part.name, part.covariance[place], float(part.dof[place]))
        for part in columns
        if part.name != "lack-of-fit" or part.covariance[place].any()
    )
