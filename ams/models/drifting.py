"""A drift of the offset, linear in time within the run, for any model: v(t) = v + d (t − t0), t in hours.

It is an ordinary parameter of the solution: estimated with the others, with its covariance and its interval. The
reference time t0 is the middle of the run, so that offset and drift hardly depend on one another; where a model is
evaluated without a time it stands at t0. Source: TP 8 (drift over time), recommendation 4 (orders of the points that
keep time orthogonal to pitch).
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import AxisCalibration
from ams.errors import ObservationsError
from ams.models.added_parameters import WithAddedParameters
from ams.models.model import Model, Stimulus
from ams.observations import Observations

DRIFT_NAME: Final = "offset_drift_v_per_h"
REFERENCE_NAME: Final = "reference_time_s"
SECONDS_PER_HOUR: Final = 3600.0


@dataclass(frozen=True)
class WithTime(WithAddedParameters):
    """A model with the drift behind its own parameters."""

    reference_s: float

    @property
    def added_names(self) -> tuple[str, ...]:
        return (DRIFT_NAME,)

    @property
    def reference(self) -> tuple[str, float]:
        return REFERENCE_NAME, self.reference_s

    @property
    def fixed(self) -> Mapping[str, tuple[float, float]]:
        return self.base.fixed

    @property
    def basis_key(self) -> Hashable | None:
        return None if self.base.basis_key is None else (self.base.basis_key, "time", self.reference_s)

    def basis(self, stimulus: Stimulus) -> FloatArray:
        return np.column_stack([self.base.basis(stimulus), self._hours(stimulus)])

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        return np.append(self.base.start(stimulus, output_v), 0.0)

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.asarray(self.base.predict(primary[:-1], stimulus) + primary[-1] * self._hours(stimulus))

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.column_stack([self.base.jacobian(primary[:-1], stimulus), self._hours(stimulus)])

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        return self.base.angle_jacobian(primary[:-1], stimulus)

    def _hours(self, stimulus: Stimulus) -> FloatArray:
        if stimulus.time_s is None:
            return np.zeros_like(stimulus.pitch_rad)
        return np.asarray((stimulus.time_s - self.reference_s) / SECONDS_PER_HOUR)


def with_time(base: Model, observations: Observations) -> WithTime:
    """Return the model with a drift about the middle of the observations.

    Raises: ObservationsError where no times were recorded, or all rows have the same.
    """
    time = observations.time_s
    if time is None or not np.ptp(time) > 0.0:
        found = "no times were recorded" if time is None else "all rows have the same time"
        raise ObservationsError(
            f"{observations.source}: time term: {found}; nothing was solved; "
            "give a column time_s or leave the time term out"
        )
    return WithTime(base, float(0.5 * (time.min() + time.max())))


def at_reference_time(axis: AxisCalibration) -> AxisCalibration:
    """Return the solution as it stands at its reference time, unchanged where it has no drift.

    The drift is no longer among the primary parameters, so that nothing evaluates it at another time; it stays among
    the parameters, with its uncertainty.
    """
    if DRIFT_NAME not in axis.primary_names:
        return axis
    return with_primary(axis, [name for name in axis.primary_names if name != DRIFT_NAME])


def with_primary(axis: AxisCalibration, names: Sequence[str]) -> AxisCalibration:
    """Return the solution with these primary parameters alone, in their order."""
    kept = np.array([axis.primary_names.index(name) for name in names])
    square = np.ix_(kept, kept)
    return replace(
        axis,
        primary_names=tuple(axis.primary_names[index] for index in kept),
        primary=axis.primary[kept],
        primary_covariance=axis.primary_covariance[square],
        tp_primary_covariance=axis.tp_primary_covariance[square],
        primary_dof=axis.primary_dof[kept],
        variance_components=tuple(
            replace(part, covariance=part.covariance[square]) for part in axis.variance_components
        ),
    )
