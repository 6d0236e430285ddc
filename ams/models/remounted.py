"""A package that was moved on its seat in mid-calibration: one offset and sensitivity, a direction for every mounting.

What a bump or a new mounting changes is how the package lies on the table: its coning angle and azimuth against the
table, not what it gives for a volt of gravity. So k of the last mounting turns into that of an earlier one by two
small rotations about the axes across the sensor, k(m) = R(δ₁, δ₂) k, which keep its length. The rotations are
parameters beside (b, k); they are seen between mountings only, as temperature coefficients are between plateaus.
Source: TP (2), (4), (5) for v = b + k·f.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ams.arrays import BoolArray, FloatArray
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.models.accelerometer import PitchRoll, cyclic
from ams.models.model import Stimulus

PREFIX = "mounting_"
"""Of every parameter that an earlier mounting has of its own."""
_MOUNTING_NAMES = ("coning_deg", "azimuth_deg")
_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_START_STEPS = 8


def is_of_a_mounting(name: str) -> bool:
    """Return whether a parameter belongs to an earlier mounting."""
    return name.startswith(PREFIX)


@dataclass(frozen=True)
class Remounted:
    """``pitch-roll`` over several mountings; its first four parameters are those of the last."""

    nominal_axis: str
    earlier: tuple[int, ...]
    """Labels of the mountings before the last."""
    name: ClassVar[str] = "pitch-roll over several mountings"
    convention: ClassVar[str] = "TP"
    measured_unit: ClassVar[str] = "v"
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = None

    @property
    def primary_names(self) -> tuple[str, ...]:
        turns = (f"{PREFIX}{label}_turn_{which}_rad" for label in self.earlier for which in ("a", "b"))
        return (*PitchRoll.primary_names, *turns)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        mounting_names = (f"{PREFIX}{label}_{name}" for label in self.earlier for name in _MOUNTING_NAMES)
        return (*PitchRoll.parameter_names, *mounting_names)

    def basis(self, stimulus: Stimulus) -> FloatArray:
        raise NotImplementedError("asked for only where basis_key is set")

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        """Estimate every mounting alone, and the rotations between them; none where one alone says too little."""
        basis = self._single.basis(stimulus)
        last = self._of(stimulus, None)
        everything = np.asarray(np.linalg.lstsq(basis, output_v, rcond=None)[0], dtype=np.float64)
        primary = self._alone(basis[last], output_v[last], everything)
        turns = [self._turns_between(primary[1:], self._alone(basis[here], output_v[here], primary)[1:])
                 for here in (self._of(stimulus, label) for label in self.earlier)]  # fmt: skip
        return np.concatenate([primary, *turns])

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        force = specific_force(stimulus.pitch_rad, stimulus.roll_rad)
        return np.asarray(primary[0] + np.einsum("nc,nc->n", force, self._k_of_rows(primary, stimulus)))

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        force = specific_force(stimulus.pitch_rad, stimulus.roll_rad)
        columns = np.zeros((force.shape[0], primary.size), dtype=primary.dtype)
        columns[:, 0], columns[:, 1:4] = 1.0, force
        for index, label in enumerate(self.earlier):
            here, mounting_columns = self._of(stimulus, label), slice(4 + 2 * index, 6 + 2 * index)
            columns[here, 1:4] = force[here] @ self._rotation(primary[mounting_columns])
            columns[here, mounting_columns] = force[here] @ self._by_turns(primary[mounting_columns], primary[1:4])
        return columns

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        k = self._k_of_rows(primary, stimulus)
        pitch, roll = stimulus.pitch_rad, stimulus.roll_rad
        return {
            "pitch": np.einsum("nc,nc->n", specific_force_by_pitch(pitch, roll), k),
            "roll": np.einsum("nc,nc->n", specific_force_by_roll(pitch, roll), k),
        }

    def parameters(self, primary: FloatArray) -> FloatArray:
        rows = primary.reshape(-1, primary.shape[-1])
        return np.stack([self._parameters_of(row) for row in rows]).reshape(*primary.shape[:-1], -1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        rows = np.zeros((len(self.parameter_names), primary.size))
        rows[:4, :4] = self._single.parameters_jacobian(primary[:4])
        for index in range(len(self.earlier)):
            chain = self._by_primary(primary, index)
            rows[4 + 2 * index : 6 + 2 * index] = (
                self._single.parameters_jacobian(self._mounted(primary, index)) @ chain
            )[2:]
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        found = dict(self._single.undetermined(primary[:4], covariance[:4, :4]))
        for index, label in enumerate(self.earlier):
            chain = self._by_primary(primary, index)
            undetermined = self._single.undetermined(self._mounted(primary, index), chain @ covariance @ chain.T)
            found |= {
                f"{PREFIX}{label}_{name}": reason for name, reason in undetermined.items() if name in _MOUNTING_NAMES
            }
        return found

    @property
    def _single(self) -> PitchRoll:
        return PitchRoll(self.nominal_axis)

    def _of(self, stimulus: Stimulus, label: int | None) -> BoolArray:
        """Return the (N,) rows of a mounting; None: of the last, as are rows that name none."""
        mounting = stimulus.mounting
        if mounting is None:
            return np.full(stimulus.pitch_rad.shape, label is None)
        return np.asarray(~np.isin(mounting, self.earlier) if label is None else mounting == label)

    def _alone(self, basis: FloatArray, output_v: FloatArray, otherwise: FloatArray) -> FloatArray:
        if basis.shape[0] < basis.shape[1] or np.linalg.matrix_rank(basis, rtol=1e-3) < basis.shape[1]:
            return otherwise
        return np.asarray(np.linalg.lstsq(basis, output_v, rcond=None)[0])

    def _turns_between(self, k: FloatArray, earlier: FloatArray) -> FloatArray:
        """Return the two rotations that bring the direction of k nearest to that of an earlier mounting."""
        turns, unit = np.zeros(2), k / np.linalg.norm(k)
        wanted = earlier / np.linalg.norm(earlier)
        for _ in range(_START_STEPS):
            left = wanted - self._rotation(turns) @ unit
            turns = turns + np.linalg.lstsq(self._by_turns(turns, unit), left, rcond=None)[0]
        return turns

    def _k_of_rows(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        k = np.tile(primary[1:4], (stimulus.pitch_rad.size, 1))
        for index, label in enumerate(self.earlier):
            k[self._of(stimulus, label)] = self._mounted(primary, index)[1:]
        return k

    def _mounted(self, primary: FloatArray, index: int) -> FloatArray:
        """Return the (4,) offset and k of an earlier mounting."""
        turned = self._rotation(primary[4 + 2 * index : 6 + 2 * index]) @ primary[1:4]
        return np.concatenate([primary[:1], turned])

    def _by_primary(self, primary: FloatArray, index: int) -> FloatArray:
        """Return the (4, P) derivatives of :meth:`_mounted`."""
        columns = slice(4 + 2 * index, 6 + 2 * index)
        chain = np.zeros((4, primary.size))
        chain[0, 0] = 1.0
        chain[1:, 1:4] = self._rotation(primary[columns])
        chain[1:, columns] = self._by_turns(primary[columns], primary[1:4])
        return chain

    def _parameters_of(self, primary: FloatArray) -> FloatArray:
        mountings = [self._single.parameters(self._mounted(primary, index))[2:] for index in range(len(self.earlier))]
        return np.concatenate([self._single.parameters(primary[:4]), *mountings])

    def _rotation(self, turns: FloatArray) -> FloatArray:
        """Return the (3, 3) rotation, first about the next axis but one across the sensor, then about the next."""
        _, j, m = cyclic(self.nominal_axis)
        return np.asarray(_about(j, turns[0]) @ _about(m, turns[1]))

    def _by_turns(self, turns: FloatArray, k: FloatArray) -> FloatArray:
        """Return the (3, 2) derivatives of the rotated k."""
        _, j, m = cyclic(self.nominal_axis)
        first = _about(j, turns[0] + 0.5 * np.pi, 0.0) @ _about(m, turns[1]) @ k
        second = _about(j, turns[0]) @ _about(m, turns[1] + 0.5 * np.pi, 0.0) @ k
        return np.stack([first, second], axis=1)


def _about(axis: int, angle_rad: float, along: float = 1.0) -> FloatArray:
    """Return the rotation about a coordinate axis; with a quarter turn more and nothing ``along``, its derivative."""
    p, q = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((3, 3), dtype=np.result_type(angle_rad, float))
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    matrix[axis, axis] = along
    matrix[p, p] = matrix[q, q] = cosine
    matrix[p, q], matrix[q, p] = -sine, sine
    return matrix
