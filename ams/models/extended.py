"""The extended model: v = b + k·f + fᵀQf with tr Q = 0, f the specific force in package axes.

It is what a soft mount inside the package does: the pads give way under the load and tilt the sensor a little more. On
the unit sphere the five terms of a traceless Q are independent of offset and sensitivities, and they have the two
periods in pitch and the one in roll of TP's figures 37 to 41. The extended model is linear like its base, so every
solver takes it; whether it is accepted is decided in :mod:`ams.solve.extension`.

A roll-free sin 2α is also what a table axis does and a roll-free cos 2α what droop does: only a reversed mount tells
them apart, and it is said wherever the model is reported.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from ams.arrays import FloatArray
from ams.frames import specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.models.accelerometer import PITCH_ROLL_FORM, PITCH_ROLL_SOURCE, PITCH_ROLL_TEXT, PitchRoll
from ams.models.model import Stimulus
from ams.models.sensor_model import ACCELEROMETER_TEXT, SYMBOLS_TEXT, Equation, SensorModel

Q_NAMES: Final = ("q_xx_v_per_g2", "q_xy_v_per_g2", "q_xz_v_per_g2", "q_yy_v_per_g2", "q_yz_v_per_g2")
"""Elements of the symmetric Q; q_zz = −q_xx − q_yy."""
CONFOUNDED: Final = (
    "a roll-free sin 2α may belong to the table's pitch axis and a roll-free cos 2α to droop of the table: "
    "only a second calibration with the package mounted the other way round tells them from the package"
)

_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}


def quadratic_basis(force: FloatArray) -> FloatArray:
    """Return the (N, 5) derivatives of fᵀQf by the elements of ``Q_NAMES``, for (N, 3) specific force."""
    x, y, z = np.moveaxis(force, -1, 0)
    return np.stack([x * x - z * z, 2 * x * y, 2 * x * z, y * y - z * z, 2 * y * z], axis=-1)


def matrix_from_elements(q: FloatArray) -> FloatArray:
    """Return the (3, 3) symmetric traceless Q from its five elements in the order of ``Q_NAMES``."""
    xx, xy, xz, yy, yz = q
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])


@dataclass(frozen=True)
class ExtendedPitchRoll:
    """TP's model with roll and the five terms of Q beside it."""

    nominal_axis: str
    name: ClassVar[str] = "pitch-roll-extended"
    convention: ClassVar[str] = "TP"
    measured_unit: ClassVar[str] = "v"
    primary_names: ClassVar[tuple[str, ...]] = (*PitchRoll.primary_names, *Q_NAMES)
    parameter_names: ClassVar[tuple[str, ...]] = (*PitchRoll.parameter_names, *Q_NAMES)
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "pitch-roll-extended"

    def basis(self, stimulus: Stimulus) -> FloatArray:
        force = specific_force(stimulus.pitch_rad, stimulus.roll_rad)
        return np.concatenate([np.ones((force.shape[0], 1)), force, quadratic_basis(force)], axis=1)

    def start(self, stimulus: Stimulus, output_v: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.lstsq(self.basis(stimulus), output_v, rcond=None)[0])

    def predict(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:
        return np.asarray(self.basis(stimulus) @ primary)

    def jacobian(self, primary: FloatArray, stimulus: Stimulus) -> FloatArray:  # noqa: ARG002 (linear)
        return self.basis(stimulus)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        pitch, roll = stimulus.pitch_rad, stimulus.roll_rad
        slope = primary[1:4] + 2.0 * specific_force(pitch, roll) @ matrix_from_elements(primary[4:])
        return {
            "pitch": np.sum(specific_force_by_pitch(pitch, roll) * slope, axis=-1),
            "roll": np.sum(specific_force_by_roll(pitch, roll) * slope, axis=-1),
        }

    def parameters(self, primary: FloatArray) -> FloatArray:
        derived = PitchRoll(self.nominal_axis).parameters(primary[..., :4])
        return np.concatenate([derived, primary[..., 4:]], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        rows = np.eye(9)
        rows[:4, :4] = PitchRoll(self.nominal_axis).parameters_jacobian(primary[:4])
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        return PitchRoll(self.nominal_axis).undetermined(primary[:4], covariance[:4, :4])


_QUADRATIC_TEXT = (
    " + q_xx_v_per_g2*(f_x^2 - f_z^2) + 2*q_xy_v_per_g2*f_x*f_y + 2*q_xz_v_per_g2*f_x*f_z "
    "+ q_yy_v_per_g2*(f_y^2 - f_z^2) + 2*q_yz_v_per_g2*f_y*f_z"
)


def _equation(nominal_axis: str) -> Equation | None:
    if nominal_axis not in PITCH_ROLL_TEXT:
        return None
    derived = PITCH_ROLL_TEXT[nominal_axis] + _QUADRATIC_TEXT + SYMBOLS_TEXT + "W = coning_deg, A = azimuth_deg"
    return Equation(PITCH_ROLL_SOURCE[nominal_axis], ACCELEROMETER_TEXT + _QUADRATIC_TEXT, derived)


EXTENDED = SensorModel(
    name="pitch-roll-extended",
    make=ExtendedPitchRoll,
    set_form=replace(PITCH_ROLL_FORM, equation=_equation, quadratic=Q_NAMES),
    is_asked_for=False,
)
