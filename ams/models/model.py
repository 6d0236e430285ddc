"""What a model is: one small object that the solvers use without knowing which sensor it stands for.

A model has *primary* parameters, in which it is linear or nearly so and whose intervals keep their coverage everywhere
(offset and the vector of sensitivities k = S·u, MATH of TP theorems I to III), and *parameters* as the reports and the
files name them (sensitivity, coning, azimuth), in the unit that their name ends in, derived from the primary ones.

To add a model, write a class with these members anywhere and pass an instance per sensor axis to
:func:`ams.calibration.calibrate.calibrate`; no solver changes.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping
from typing import Protocol

import numpy as np

from ams.arrays import FloatArray, IntArray


class Stimulus(Protocol):
    """What the package was exposed to, row by row: both ``Observations`` and ``Attitude`` are one."""

    @property
    def pitch_rad(self) -> FloatArray: ...
    @property
    def roll_rad(self) -> FloatArray: ...
    @property
    def yaw_rad(self) -> FloatArray | None: ...
    @property
    def temperature_degc(self) -> FloatArray | None: ...
    @property
    def time_s(self) -> FloatArray | None: ...
    @property
    def euler_rate_rad_s(self) -> FloatArray | None:
        """(N, 3) rates of pitch, yaw and roll; None at rest."""

    @property
    def mounting(self) -> IntArray | None:
        """(N,) label of the mounting; None where there is one only."""

    @property
    def reference_level(self) -> FloatArray | None:
        """(N,) known value of the quantity in its own unit; None where attitude or motion is known instead."""

    @property
    def level_errors(self) -> FloatArray | None:
        """(N, q) what one standard uncertainty of each of q errors does to ``reference_level``."""

    @property
    def scanned_v(self) -> FloatArray | None:
        """(N, q) volts on each of the q channels of a scanner that leaks; None: none does."""

    @property
    def gravity_errors_rad(self) -> FloatArray | None:
        """(N, 3, q) along package axes, what one standard uncertainty of each of q errors turns gravity by."""

    @property
    def from_level(self) -> FloatArray | None:
        """(N, 3, 3) mean rotation from level axes into the package's while a row was read; None: not known."""


class Model(Protocol):
    """One sensor axis as a function of what it is exposed to."""

    @property
    def name(self) -> str:
        """As the files have it: ``pitch-roll``."""

    @property
    def convention(self) -> str:
        """``TP``, ``CR`` or ``SR``."""

    @property
    def measured_unit(self) -> str:
        """Unit of the outputs it states, as it is written in a key: ``v``, ``counts``."""

    @property
    def nominal_axis(self) -> str:
        """``x``, ``y`` or ``z``."""

    @property
    def primary_names(self) -> tuple[str, ...]:
        """(P,) names of the primary parameters, ending in their unit."""

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """(L,) names of the derived parameters, ending in their unit."""

    @property
    def fixed(self) -> Mapping[str, tuple[float, float]]:
        """Primary parameters that are known beforehand: name to value and standard uncertainty."""

    @property
    def basis_key(self) -> Hashable | None:
        """Two models with the same key have the same :meth:`basis` for the same rows; None where there is none."""

    def basis(self, stimulus: Stimulus) -> FloatArray:
        """Return (N, P') with v = basis · (free primary parameters) exactly.

        Asked for only where ``basis_key`` is set.
        """

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        """Return (P,) primary parameters good enough to iterate from; asked for only where there is no basis."""

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        """Return the (N,) outputs, in ``measured_unit``."""

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        """Return the (N, P) derivatives of :meth:`predict` by every primary parameter, fixed ones included."""

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        """Return the (N,) derivatives of :meth:`predict` by the angles, volts per radian.

        Keyed ``pitch``, ``roll`` (``yaw``).
        """

    def parameters(self, primary: FloatArray) -> FloatArray:
        """Return the (…, L) derived parameters of (…, P) primary ones, in the units of their names."""

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        """Return the (L, P) derivatives of :meth:`parameters`.

        A row that does not exist (azimuth at no coning) is NaN.
        """

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        """Return the derived parameters that this estimate cannot state, each with the reason in words."""


class LinearModel(ABC):
    """What the models share that are linear in all their primary parameters: v = basis · primary."""

    @abstractmethod
    def basis(self, stimulus: Stimulus) -> FloatArray:
        """Return (N, P) as :meth:`Model.basis` does."""

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.lstsq(self.basis(stimulus), output_v, rcond=None)[0])

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.asarray(self.basis(stimulus) @ primary)

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:  # noqa: ARG002 (linear)
        return self.basis(stimulus)
