"""Pitch, yaw and roll from a sting package and a model package (CR IV-B).

Gravity in sting axes gives pitch and yaw, gravity in model axes against it gives roll. The closed form works reading by
reading: (IV-B.9) to (IV-B.11). The iteration takes all readings of a dwell together, for both packages and all three
angles at once, by least squares in the volts: (IV-B.12) to (IV-B.28); it gives the standard deviations.

Gravity cannot tell (Θ, Ψ) from (−Θ, Ψ ± 180°): Ψ is taken within ±90°. At Θ = 0 yaw has no meaning, at Ψ = ±90° the
sign of Θ has none, and roll has none where the sting's x axis is vertical. These are flagged.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ams.arrays import FloatArray
from ams.errors import SolveError
from ams.frames import AXES
from ams.models.cr import CrPair, CrSensor, model_gravity_g, sensed_field, sting_gravity_g

SMALLEST_SINE: Final = 1e-6
"""Below this sine of the angle to a singular attitude, the angle concerned is not stated."""
_ITERATIONS: Final = 50


@dataclass(frozen=True)
class EulerAngles:
    """Angles reading by reading, (N,), NaN where the flag says so."""

    pitch_rad: FloatArray
    yaw_rad: FloatArray
    roll_rad: FloatArray
    flags: tuple[str, ...]


def closed_form(pair: CrPair, sting_v: Mapping[str, FloatArray], model_v: Mapping[str, FloatArray]) -> EulerAngles:
    """Return the angles from three sting outputs and three model outputs, each (N,).

    Source: CR (IV-B.9) to (IV-B.11).
    """
    return angles_from_gravity(sensed_field(pair.sting, sting_v), sensed_field(pair.model, model_v))


def angles_from_gravity(sting: FloatArray, model: FloatArray) -> EulerAngles:
    """Return the angles from gravity in sting axes and in model axes, (N, 3) each, in any unit."""
    g_x, g_y, g_z = np.moveaxis(np.atleast_2d(sting), -1, 0)
    _, m_y, m_z = np.moveaxis(np.atleast_2d(model), -1, 0)
    total = np.sqrt(g_x**2 + g_y**2 + g_z**2)
    level = np.hypot(g_x, g_y) < SMALLEST_SINE * total
    sideways = (np.abs(g_x) < SMALLEST_SINE * total) & ~level
    on_end = np.hypot(g_y, g_z) < SMALLEST_SINE * total
    sign = np.where(g_x > 0.0, -1.0, 1.0)
    yaw = np.arctan2(sign * g_y, np.abs(g_x))
    pitch = sign * np.arctan2(np.hypot(g_x, g_y), g_z)
    roll = np.arctan2(m_y * g_z - m_z * g_y, m_y * g_y + m_z * g_z)
    flags = tuple(_flag(*row) for row in zip(level.tolist(), sideways.tolist(), on_end.tolist(), strict=True))
    return EulerAngles(
        np.where(sideways, np.nan, pitch),
        np.where(level | sideways, np.nan, yaw),
        np.where(on_end, np.nan, roll),
        flags,
    )


def _flag(level: bool, sideways: bool, on_end: bool) -> str:
    if level:
        return "yaw singular: pitch is zero"
    if sideways:
        return "sign of pitch and yaw undetermined: yaw is ±90°"
    return "roll singular: sting axis vertical" if on_end else ""


@dataclass(frozen=True)
class DwellAngles:
    """The angles of one dwell with their covariance."""

    angles_rad: FloatArray
    """(3,) pitch, yaw, roll."""
    covariance_rad2: FloatArray
    """(3, 3)."""
    standard_error: float
    """Of the residuals in units of their standard deviations: near 1 when these are right."""
    iterations: int


def iterate_dwell(
    pair: CrPair,
    sting_v: Mapping[str, FloatArray],
    model_v: Mapping[str, FloatArray],
    *,
    sd_v: float,
    start_rad: FloatArray | None = None,
) -> DwellAngles:
    """Find one attitude from all readings of a dwell, by Gauss-Newton. Source: CR (IV-B.12) to (IV-B.28).

    ``sd_v`` is the standard deviation of one reading, volts. The start is the closed form of the dwell's means unless
    one is given. Unlike CR's two steps the model package's outputs also improve pitch and yaw.
    Raises: SolveError at a singular attitude or without convergence in 50 iterations.
    """
    volts = np.concatenate([_stack(sting_v), _stack(model_v)], axis=0)
    mean = volts.mean(axis=1)
    count = volts.shape[1]
    angles = _start(pair, mean) if start_rad is None else np.asarray(start_rad, dtype=float)
    for iteration in range(1, _ITERATIONS + 1):
        predicted, J = _predict(pair, angles)
        normal = J.T @ J
        if np.linalg.cond(normal) > 1e12:
            raise SolveError(
                f"two packages: the angles are not determined near pitch {np.degrees(angles[0]):.4f}°, yaw "
                f"{np.degrees(angles[1]):.4f}°: singular attitude; state one angle and solve for the others"
            )
        step = np.linalg.solve(normal, J.T @ (mean - predicted))
        angles = angles + step
        if np.max(np.abs(step)) < 1e-12:
            return _finish(volts, pair, angles, sd_v, count, iteration)
    raise SolveError(
        f"two packages: no convergence in {_ITERATIONS} iterations (last step {np.max(np.abs(step)):.2g} rad); "
        "start nearer, or check that the outputs belong to these packages"
    )


def _finish(
    volts: FloatArray, pair: CrPair, angles: FloatArray, sd_v: float, count: int, iteration: int
) -> DwellAngles:
    predicted, J = _predict(pair, angles)
    residuals = (volts - predicted[:, None]) / sd_v
    dof = max(volts.size - 3, 1)
    covariance = np.linalg.inv(J.T @ J) * sd_v**2 / count
    return DwellAngles(angles, covariance, float(np.sqrt(np.sum(residuals**2) / dof)), iteration)


def _start(pair: CrPair, mean_v: FloatArray) -> FloatArray:
    sting = dict(zip(AXES, mean_v[:3, None], strict=True))
    model = dict(zip(AXES, mean_v[3:, None], strict=True))
    found = closed_form(pair, sting, model)
    if found.flags[0]:
        raise SolveError(f"two packages: {found.flags[0]}; give a start, or state one angle and solve for the others")
    return np.array([found.pitch_rad[0], found.yaw_rad[0], found.roll_rad[0]])


def _predict(pair: CrPair, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return six outputs and their (6, 3) derivatives by pitch, yaw and roll."""
    pitch, yaw, roll = angles
    s_p, c_p, s_y, c_y = np.sin(pitch), np.cos(pitch), np.sin(yaw), np.cos(yaw)
    gravity = sting_gravity_g(pitch, yaw)
    by_pitch = np.array([-c_p * c_y, c_p * s_y, -s_p])
    by_yaw = np.array([s_p * s_y, s_p * c_y, 0.0])
    in_model = model_gravity_g(gravity, roll)
    by_roll = np.array([0.0, in_model[2], -in_model[1]])
    K_s, b_s = _lines(pair.sting)
    K_m, b_m = _lines(pair.model)
    outputs = np.concatenate([b_s + K_s @ gravity, b_m + K_m @ in_model])
    sting_rows = K_s @ np.column_stack([by_pitch, by_yaw, np.zeros(3)])
    turned = [model_gravity_g(by_pitch, roll), model_gravity_g(by_yaw, roll), by_roll]
    return outputs, np.vstack([sting_rows, K_m @ np.column_stack(turned)])


def _lines(sensors: Mapping[str, CrSensor]) -> tuple[FloatArray, FloatArray]:
    return np.stack([sensors[axis].k for axis in AXES]), np.array([sensors[axis].bias_v for axis in AXES])


def _stack(outputs_v: Mapping[str, FloatArray]) -> FloatArray:
    return np.stack([np.atleast_1d(outputs_v[axis]) for axis in AXES])
