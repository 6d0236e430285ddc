"""A model with further parameters behind its own, which hold at a reference: what every such model says alike.

The further parameters are primary ones, too; the reference (a temperature, a time) is stated behind them and is no
parameter of the solution.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.models.model import Model


@dataclass(frozen=True)
class WithAddedParameters(ABC):
    """What does not depend on which parameters were added."""

    base: Model

    @property
    @abstractmethod
    def added_names(self) -> tuple[str, ...]:
        """Of the parameters behind those of ``base``."""

    @property
    @abstractmethod
    def reference(self) -> tuple[str, float]:
        """Name and value of where they hold."""

    @property
    def name(self) -> str:
        return self.base.name

    @property
    def measured_unit(self) -> str:
        return self.base.measured_unit

    @property
    def convention(self) -> str:
        return self.base.convention

    @property
    def nominal_axis(self) -> str:
        return self.base.nominal_axis

    @property
    def primary_names(self) -> tuple[str, ...]:
        return (*self.base.primary_names, *self.added_names)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        return (*self.base.parameter_names, *self.added_names, self.reference[0])

    def parameters(self, primary: FloatArray) -> FloatArray:
        reference = np.broadcast_to(self.reference[1], (*primary.shape[:-1], 1))
        base, added = self._split(primary)
        return np.concatenate([self.base.parameters(base), added, reference], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        base, count = self.base.parameters_jacobian(self._split(primary)[0]), len(self.added_names)
        rows = np.zeros((base.shape[0] + count + 1, base.shape[1] + count))
        rows[: base.shape[0], : base.shape[1]] = base
        rows[base.shape[0] : -1, base.shape[1] :] = np.eye(count)
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        base = self._split(primary)[0]
        return self.base.undetermined(base, covariance[: base.size, : base.size])

    def _split(self, primary: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Split (…, P) into those of ``base``, and those that were added."""
        count = len(self.added_names)
        return primary[..., :-count], primary[..., -count:]
