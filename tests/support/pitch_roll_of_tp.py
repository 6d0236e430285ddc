"""TP's own estimate, the reference for calrig's: Gauss-Newton in (b, S, Ω, A) with a full U_Y, TP (43) to (50).

Calibrations are linear in (b, k = S·u) and need no start; this one goes the way of the print, and must agree.
"""

import numpy as np

from ams.arrays import FloatArray
from ams.models.accelerometer import PitchRoll, cyclic, vector_from_angles
from ams.models.model import Stimulus
from ams.solve.gauss_newton import GaussNewtonResult, gauss_newton

NAMES = ("offset_v", "sensitivity_v_per_g", "coning_rad", "azimuth_rad")


def primary_from_parameters(nominal_axis: str, parameters: FloatArray) -> FloatArray:
    """Return the (4,) primary parameters of (b, S, Ω, A) in volts, V/g and radians."""
    offset_v, sensitivity, coning_rad, azimuth_rad = parameters
    return np.concatenate([[offset_v], vector_from_angles(nominal_axis, sensitivity, coning_rad, azimuth_rad)])


def primary_from_parameters_jacobian(nominal_axis: str, parameters: FloatArray) -> FloatArray:
    """Return the (4, 4) derivatives of the primary parameters by (b, S, Ω, A), radians.

    The last column vanishes with Ω.
    """
    _, sensitivity, coning_rad, azimuth_rad = parameters
    columns = np.zeros((4, 4))
    columns[0, 0] = 1.0
    columns[1:, 1] = vector_from_angles(nominal_axis, 1.0, coning_rad, azimuth_rad)
    columns[1:, 2] = vector_from_angles(nominal_axis, sensitivity, coning_rad + 0.5 * np.pi, azimuth_rad)
    _, j, m = (1 + index for index in cyclic(nominal_axis))
    columns[j, 3] = -sensitivity * np.sin(coning_rad) * np.sin(azimuth_rad)
    columns[m, 3] = sensitivity * np.sin(coning_rad) * np.cos(azimuth_rad)
    return columns


def solve_pitch_roll(
    nominal_axis: str,
    stimulus: Stimulus,
    output_v: FloatArray,
    covariance: FloatArray | None = None,
    absolute_covariance: bool = False,
    start: FloatArray | None = None,
) -> GaussNewtonResult:
    """Estimate of (b, S, Ω, A), volts, V/g and radians, from (N,) outputs.

    ``covariance`` is U_Y as for :func:`ams.solve.gauss_newton.gauss_newton`. Without a start the linear form gives it;
    from any start the answer is on the branch 0 ≤ Ω ≤ 90°, S signed, A in (−180°, 180°].

    Raises:
        DesignError: fewer rows than parameters, or a coning angle of zero, where the azimuth does not exist.
        SolveError: U_Y is not positive definite.
    """
    model = PitchRoll(nominal_axis)
    basis = model.basis(stimulus)

    def solve(begin: FloatArray) -> GaussNewtonResult:
        return gauss_newton(
            lambda parameters: np.asarray(basis @ primary_from_parameters(nominal_axis, parameters)),
            lambda parameters: np.asarray(basis @ primary_from_parameters_jacobian(nominal_axis, parameters)),
            begin,
            output_v,
            NAMES,
            covariance,
            absolute_covariance,
        )

    if start is None:
        return solve(_on_branch(model, model.start(stimulus, output_v)))
    result = solve(start)
    return solve(_on_branch(model, primary_from_parameters(nominal_axis, result.estimate)))


def _on_branch(model: PitchRoll, primary: FloatArray) -> FloatArray:
    """Return (b, S, Ω, A) in radians with 0 ≤ Ω ≤ 90°: the same sensor has three other names outside it."""
    parameters = model.parameters(primary)
    parameters[2:] = np.deg2rad(parameters[2:])
    return parameters
