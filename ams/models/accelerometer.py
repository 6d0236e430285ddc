"""Accelerometer models of NASA/TP-1999-209835: with roll, TP (2), (4), (5), and without, TP (1).

With roll one form serves all three sensors: v = b + S·(u·f) with u the unit vector of the sensitive axis. A sensor of
nominal axis i has u = cos Ω e(i) + sin Ω (cos A e(i+1) + sin A e(i+2)), indices cyclic. The output is linear in
(b, k = S·u), which are the primary parameters; S, Ω and A follow from k on the branch 0 ≤ Ω ≤ 90°, S signed.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from math import atan2, degrees, hypot, nan, sqrt
from typing import ClassVar, Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import DesignError
from ams.frames import AXES, Attitude, specific_force, specific_force_by_pitch, specific_force_by_roll
from ams.models.model import LinearModel, Stimulus
from ams.models.sensor_model import ACCELEROMETER_TEXT, SYMBOLS_TEXT, Equation, SensorModel, SetForm

LINEAR_COLUMNS: Final = 4
"""Of a linear sensor, the first of every basis: offset and three sensitivities."""
_NOTHING_FIXED: Mapping[str, tuple[float, float]] = {}
_OBSERVABLE_CONING_U = 4.0
"""Standard uncertainties of the vector across the axis, as estimated. From a true coning angle of five on, what is then
reported is covered in 95 %; asking for five leaves the campaigns that happen to look sharp, and 90 % (simulated)."""
_ROUNDING_CONING_RAD = 1e-10
_ROUNDING_SENSITIVITY = 1e-12
"""Of the offset, per g: what a constant output leaves by rounding."""
_DEG_PER_RAD = degrees(1.0)


def cyclic(nominal_axis: str) -> tuple[int, int, int]:
    """Return the indices of e(i), e(i+1), e(i+2) for a nominal axis ``x``, ``y`` or ``z``."""
    first = AXES.index(nominal_axis)
    return first, (first + 1) % 3, (first + 2) % 3


def vector_from_angles(nominal_axis: str, sensitivity: float, coning_rad: float, azimuth_rad: float) -> FloatArray:
    """Return (3,) k = S·u of TP (2), (4), (5)."""
    i, j, m = cyclic(nominal_axis)
    k = np.zeros(3, dtype=np.result_type(sensitivity, coning_rad, azimuth_rad, float))
    k[i] = sensitivity * np.cos(coning_rad)
    k[j] = sensitivity * np.sin(coning_rad) * np.cos(azimuth_rad)
    k[m] = sensitivity * np.sin(coning_rad) * np.sin(azimuth_rad)
    return k


def _not_following(k: FloatArray, covariance: FloatArray, offset_v: float) -> str:
    """Return why angles say nothing, empty where they do: an output that gravity does not move (unplugged, stuck)."""
    length, u = hypot(*k.tolist()), sqrt(max(sum(covariance.diagonal().tolist()), 0.0) / k.size)
    if length > max(_OBSERVABLE_CONING_U * u, _ROUNDING_SENSITIVITY * abs(offset_v)):
        return ""
    return (
        f"the output does not follow gravity: its sensitivity {length:.3g} V/g is within {_OBSERVABLE_CONING_U:g} "
        f"standard uncertainties ({u:.3g} V/g) of zero; look for an unplugged or stuck channel"
    )


@dataclass(frozen=True)
class PitchRoll(LinearModel):
    """TP (2), (4), (5): offset, sensitivity, coning and azimuth, with pitch and roll known."""

    nominal_axis: str
    name: ClassVar[str] = "pitch-roll"
    convention: ClassVar[str] = "TP"
    measured_unit: ClassVar[str] = "v"
    primary_names: ClassVar[tuple[str, ...]] = ("offset_v", "k_x_v_per_g", "k_y_v_per_g", "k_z_v_per_g")
    parameter_names: ClassVar[tuple[str, ...]] = ("offset_v", "sensitivity_v_per_g", "coning_deg", "azimuth_deg")
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "pitch-roll"

    def basis(self, stimulus: Stimulus) -> FloatArray:
        force = specific_force(stimulus.pitch_rad, stimulus.roll_rad)
        return np.concatenate([np.ones((force.shape[0], 1)), force], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        k = primary[1:4]
        return {
            "pitch": specific_force_by_pitch(stimulus.pitch_rad, stimulus.roll_rad) @ k,
            "roll": specific_force_by_roll(stimulus.pitch_rad, stimulus.roll_rad) @ k,
        }

    def parameters(self, primary: FloatArray) -> FloatArray:
        i, j, m = (1 + index for index in cyclic(self.nominal_axis))
        sign = np.where(primary[..., i] < 0.0, -1.0, 1.0)
        along, first, second = (sign * primary[..., index] for index in (i, j, m))
        across = np.hypot(first, second)
        azimuth_deg = np.rad2deg(np.arctan2(second, first))
        azimuth_deg = np.where(azimuth_deg <= -180.0, 180.0, azimuth_deg)
        sensitivity = sign * np.hypot(along, across)
        found = np.empty((*primary.shape[:-1], 4))
        found[..., 0], found[..., 1], found[..., 3] = primary[..., 0], sensitivity, azimuth_deg
        found[..., 2] = np.rad2deg(np.arctan2(across, along))
        return found

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        i, j, m = (1 + index for index in cyclic(self.nominal_axis))
        k = primary.tolist()
        across, length = hypot(k[j], k[m]), hypot(*k[1:]) or nan
        sign = -1.0 if k[i] < 0.0 else 1.0
        rows = [[0.0] * 4 for _ in range(4)]
        rows[0][0] = 1.0
        rows[1][1:] = [sign * component / length for component in k[1:]]
        first, second = (k[j] / across, k[m] / across) if across > 0.0 else (nan, nan)
        along = _DEG_PER_RAD * abs(k[i]) / length**2
        rows[2][i], rows[2][j], rows[2][m] = -_DEG_PER_RAD * sign * across / length**2, along * first, along * second
        by_turn = _DEG_PER_RAD / across if across > 0.0 else nan
        rows[3][j], rows[3][m] = -by_turn * second, by_turn * first
        return np.array(rows)

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        """Return coning and azimuth where they cannot be told.

        That is where the coning angle is within about five of its standard uncertainties of zero.
        """
        if unmoved := _not_following(primary[1:4], covariance[1:4, 1:4], float(primary[0])):
            return dict.fromkeys(("coning_deg", "azimuth_deg"), unmoved)
        i, j, m = (1 + index for index in cyclic(self.nominal_axis))
        k, variances = primary.tolist(), covariance.diagonal().tolist()
        across, length = hypot(k[j], k[m]), hypot(*k[1:]) or nan
        coning = atan2(across, abs(k[i]))
        u = sqrt(max(0.5 * (variances[j] + variances[m]), 0.0)) / length
        if coning > _ROUNDING_CONING_RAD and coning >= _OBSERVABLE_CONING_U * u:
            return {}
        reason = (
            f"coning angle {degrees(coning):.3g}° is within {_OBSERVABLE_CONING_U:g} standard uncertainties "
            f"({degrees(u):.3g}°) of zero: "
            "its direction cannot be told and an interval for it would not cover; use the vector of sensitivities"
        )
        return {"coning_deg": reason, "azimuth_deg": reason}


@dataclass(frozen=True)
class PitchOnly(LinearModel):
    """TP (1), v = b + S sin(α − φ): offset, sensitivity and pitch misalignment, roll staying zero.

    For a sensor along z the same physics reads v = b − S cos(α − φ).
    """

    nominal_axis: str
    name: ClassVar[str] = "pitch-only"
    convention: ClassVar[str] = "TP"
    measured_unit: ClassVar[str] = "v"
    primary_names: ClassVar[tuple[str, ...]] = ("offset_v", "k_x_v_per_g", "k_z_v_per_g")
    parameter_names: ClassVar[tuple[str, ...]] = ("offset_v", "sensitivity_v_per_g", "pitch_misalignment_deg")
    fixed: ClassVar[Mapping[str, tuple[float, float]]] = _NOTHING_FIXED
    basis_key: ClassVar[Hashable | None] = "pitch-only"

    def __post_init__(self) -> None:
        if self.nominal_axis not in ("x", "z"):
            raise DesignError(
                f"model pitch-only: got nominal axis {self.nominal_axis}, allowed x or z: "
                "without roll a sensor along y senses nothing; use pitch-roll"
            )

    def basis(self, stimulus: Stimulus) -> FloatArray:
        turned = np.abs(np.sin(stimulus.roll_rad)) + (np.cos(stimulus.roll_rad) < 0.0)
        if np.any(turned > 1e-9):
            worst_deg = float(np.rad2deg(stimulus.roll_rad[int(np.argmax(turned))]))
            raise DesignError(
                f"model pitch-only: roll must stay 0°: got {worst_deg:g}°; nothing was solved; use the model pitch-roll"
            )
        pitch = stimulus.pitch_rad
        return np.stack([np.ones_like(pitch), np.sin(pitch), -np.cos(pitch)], axis=1)

    def angle_jacobian(self, primary: FloatArray, stimulus: Stimulus) -> Mapping[str, FloatArray]:
        pitch = stimulus.pitch_rad
        return {
            "pitch": primary[1] * np.cos(pitch) + primary[2] * np.sin(pitch),
            "roll": np.zeros_like(pitch),
        }

    def _turned(self, primary: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (S cos φ, S sin φ) for either nominal axis."""
        if self.nominal_axis == "x":
            return primary[..., 1], primary[..., 2]
        return primary[..., 2], -primary[..., 1]

    def parameters(self, primary: FloatArray) -> FloatArray:
        along, across = self._turned(primary)
        sign = np.where(along < 0.0, -1.0, 1.0)
        misalignment_deg = np.rad2deg(np.arctan2(sign * across, sign * along))
        return np.stack([primary[..., 0], sign * np.hypot(along, across), misalignment_deg], axis=-1)

    def parameters_jacobian(self, primary: FloatArray) -> FloatArray:
        along, across = self._turned(primary)
        sensitivity = self.parameters(primary)[1]
        by_turned = np.array(
            [[along / sensitivity, across / sensitivity], np.rad2deg([-across, along]) / sensitivity**2]
        )
        turn = np.eye(2) if self.nominal_axis == "x" else np.array([[0.0, 1.0], [-1.0, 0.0]])
        rows = np.zeros((3, 3))
        rows[0, 0] = 1.0
        rows[1:, 1:] = by_turned @ turn
        return rows

    def undetermined(self, primary: FloatArray, covariance: FloatArray) -> Mapping[str, str]:
        unmoved = _not_following(primary[1:], covariance[1:, 1:], float(primary[0]))
        return {"pitch_misalignment_deg": unmoved} if unmoved else {}


PITCH_ROLL_TEXT = {
    "x": "v = b + S*(cos W sin alpha - sin W cos alpha sin(R + A))",
    "y": "v = b + S*(-cos W cos alpha sin R + sin W (sin A sin alpha - cos A cos alpha cos R))",
    "z": "v = b + S*(-cos W cos alpha cos R + sin W (cos A sin alpha - sin A cos alpha sin R))",
}
PITCH_ROLL_SOURCE = {"x": "TP (2)", "y": "TP (4)", "z": "TP (5)"}
_PITCH_ONLY_TEXT = {"x": "v = b + S*sin(alpha - p)", "z": "v = b - S*cos(alpha - p)"}
_C_FORCE = """
    f[0] = sin(pitch);
    f[1] = -cos(pitch) * sin(roll);
    f[2] = -cos(pitch) * cos(roll);
"""


def _pitch_roll_equation(nominal_axis: str) -> Equation | None:
    if nominal_axis not in PITCH_ROLL_TEXT:
        return None
    derived = PITCH_ROLL_TEXT[nominal_axis] + SYMBOLS_TEXT + "W = coning_deg, A = azimuth_deg"
    return Equation(PITCH_ROLL_SOURCE[nominal_axis], ACCELEROMETER_TEXT, derived)


def _pitch_only_equation(nominal_axis: str) -> Equation | None:
    if nominal_axis not in _PITCH_ONLY_TEXT:
        return None
    derived = _PITCH_ONLY_TEXT[nominal_axis] + SYMBOLS_TEXT + "p = pitch_misalignment_deg"
    return Equation("TP (1)", ACCELEROMETER_TEXT + " at R = 0; k_y_v_per_g is 0", derived)


def _along_cone(nominal_axis: str, angles_rad: FloatArray) -> FloatArray:
    coning, azimuth = angles_rad
    first = "xyz".index(nominal_axis)
    unit = np.zeros(3)
    unit[first] = np.cos(coning)
    unit[(first + 1) % 3] = np.sin(coning) * np.cos(azimuth)
    unit[(first + 2) % 3] = np.sin(coning) * np.sin(azimuth)
    return unit


def _along_misalignment(nominal_axis: str, angles_rad: FloatArray) -> FloatArray:
    cosine, sine = np.cos(angles_rad[0]), np.sin(angles_rad[0])
    return np.array([cosine, 0.0, sine]) if nominal_axis == "x" else np.array([-sine, 0.0, cosine])


def force_at(attitude: Attitude) -> FloatArray:
    """Return the (…, 3) specific force, local g. Source: TP (2), (4), (5)."""
    return specific_force(attitude.pitch_rad, attitude.roll_rad)


PITCH_ROLL_FORM = SetForm(
    convention="TP",
    symbol="f",
    inputs=("pitch_deg", "roll_deg"),
    field=force_at,
    equation=_pitch_roll_equation,
    along=_along_cone,
    c_field=_C_FORCE,
)
_PITCH_ONLY_FORM = replace(
    PITCH_ROLL_FORM, equation=_pitch_only_equation, angles=("pitch_misalignment_deg",), along=_along_misalignment
)
PITCH_ROLL = SensorModel(name="pitch-roll", make=PitchRoll, set_form=PITCH_ROLL_FORM)
PITCH_ONLY = SensorModel(name="pitch-only", make=PitchOnly, columns=("pitch",), set_form=_PITCH_ONLY_FORM)
