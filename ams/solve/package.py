"""The covariance between the axes of one package.

Every part of an axis' covariance comes from causes (:class:`~ams.solve.components.Causes`). Where two axes were solved
from the same rows their causes are the same: an index of the table has one error for all axes, a replication one
disturbance of the package. A point's lack of fit may or may not be the same in two axes; there the residuals tell, by
their correlation over the points. What belongs to one axis alone (its temperature coefficients) has no covariance with
another's.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import PackageCovariance, VarianceComponent
from ams.inputs.shared_errors import SharedError
from ams.solve.components import ComponentColumns


@dataclass(frozen=True)
class SolvedAxis:
    """One axis: a row of columns that were solved together."""

    label: str
    primary_names: Sequence[str]
    components: Sequence[ComponentColumns]
    row: int
    shared_errors: Sequence[SharedError] = ()

    def part(self, name: str) -> ComponentColumns | None:
        return next((part for part in self.components if part.name == name), None)

    def shares(self, name: str, other: "SolvedAxis") -> bool:
        """Return whether a part has the same causes in another axis; a load resistor is each channel's own."""
        these, others = ([e for e in axis.shared_errors if e.name == name] for axis in (self, other))
        return these == others and not any(error.is_of_one_channel for error in these)


def package_covariance(axes: Sequence[SolvedAxis]) -> PackageCovariance:
    """Return the covariance of all axes of a package."""
    names = dict.fromkeys(part.name for axis in axes for part in axis.components)
    order = tuple((axis.label, name) for axis in axes for name in axis.primary_names)
    return PackageCovariance(order, tuple(_component(name, axes) for name in names))


def _component(name: str, axes: Sequence[SolvedAxis]) -> VarianceComponent:
    edges = list(accumulate((len(axis.primary_names) for axis in axes), initial=0))
    slices = [slice(low, high) for low, high in pairwise(edges)]
    covariance = np.zeros((edges[-1], edges[-1]))
    there = [(block, axis, part) for block, axis in zip(slices, axes, strict=True) if (part := axis.part(name))]
    for number, (block, axis, part) in enumerate(there):
        covariance[block, block] = part.covariance[axis.row]
        for other_block, other, others in there[:number]:
            if axis.shares(name, other):
                between = _between(part, axis.row, others, other.row)
                covariance[block, other_block], covariance[other_block, block] = between, between.T
    return VarianceComponent(name, covariance, min(float(part.dof[axis.row]) for _, axis, part in there))


def _between(columns: ComponentColumns, row: int, other: ComponentColumns, other_row: int) -> FloatArray:
    """Return the (P, P') covariance of two axes' estimates from the same causes; zero where they are not the same."""
    nothing = np.zeros((columns.covariance.shape[-1], other.covariance.shape[-1]))
    if columns.causes is None or other.causes is None:
        return nothing
    effects, others = columns.causes.of(row), other.causes.of(other_row)
    if effects.shape[1] != others.shape[1]:
        return nothing
    likeness = _correlation(columns.causes.signs, row, other.causes.signs, other_row)
    return np.asarray(likeness * effects @ others.T)


def _correlation(signs: FloatArray | None, row: int, others: FloatArray | None, other_row: int) -> float:
    """Return how the causes' outcomes for two axes correlate; 1 where they are one and the same."""
    if signs is None or others is None:
        return 1.0
    a, b = signs[:, row], others[:, other_row]
    squares = float(a @ a) * float(b @ b)
    return float(a @ b) / squares**0.5 if squares > 0.0 else 0.0
