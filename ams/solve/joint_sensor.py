"""One sensor axis of a joint fit: what it reads at a specific force, and how that goes with the force.

The joint fit has package and table in one system, so it needs the slope by the force itself, on which every error of
table and seat acts, and its forces are of several mountings. Offset and sensitivities may lack a component that no
attitude excites (y where roll never moved); the terms of second and third order are those of
:mod:`ams.models.extended`, without their best linear approximation over the points of all mountings.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ams.arrays import Centring, FloatArray
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll, centred_basis, centring_over, slope_of_terms


@dataclass(frozen=True)
class JointSensor:
    """One axis: (1, excited components of the force, terms)."""

    axis: str
    excited: NDArray[np.intp]
    """Components of the specific force that any row excites, of 0 to 2."""
    centring: Centring = ()
    """Of the terms; empty without them. With them every component is excited."""
    is_blind: bool = False
    """Whether the points determine no terms, asked for or not."""

    @property
    def size(self) -> int:
        """Count of the primary parameters that are solved for."""
        return 1 + self.excited.size + len(self.centring)

    @property
    def model(self) -> PitchRoll | ExtendedPitchRoll:
        """The model with every component, as a solution states it."""
        return ExtendedPitchRoll(self.axis, self.centring) if self.centring else PitchRoll(self.axis)

    @property
    def solved(self) -> NDArray[np.intp]:
        """(size,) of what is solved for among the primary parameters of ``model``."""
        return np.concatenate([[0], 1 + self.excited, 4 + np.arange(len(self.centring))])

    def basis(self, force: FloatArray) -> FloatArray:
        """Return the (N, size) columns at (N, c) excited components of the force."""
        linear = np.column_stack([np.ones(force.shape[0]), force])
        return np.hstack([linear, centred_basis(force, self.axis, self.centring)]) if self.centring else linear

    def slope(self, primary: FloatArray, force: FloatArray) -> FloatArray:
        """Return the (N, c) derivatives of the output by the components of the force."""
        linear = np.broadcast_to(primary[1 : 1 + self.excited.size], force.shape)
        terms = primary[1 + self.excited.size :]
        return linear + slope_of_terms(terms, force, self.axis, self.centring) if self.centring else linear


def sensors_of(
    axes: tuple[str, ...], force: FloatArray, excited: NDArray[np.intp], *, has_terms: bool
) -> tuple[JointSensor, ...]:
    """Return the axes at (N, c) forces of all mountings, with the terms where the points determine them."""
    is_whole = excited.size == 3
    centrings = {axis: (centring_over(force, len(force), axis) if is_whole else None) or () for axis in axes}
    return tuple(
        JointSensor(axis, excited, centring if has_terms else (), not centring) for axis, centring in centrings.items()
    )
