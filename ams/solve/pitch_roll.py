"""TP's own estimate: Gauss-Newton in (b, S, Ω, A) with a full output covariance U_Y, TP (43) to (50).

The linear form gives the same answer without a start; this one is for a given U_Y and for comparison with print.
"""

import numpy as np

from ams.arrays import FloatArray
from ams.models.accelerometer import PitchRoll, primary_from_parameters, primary_from_parameters_jacobian
from ams.models.model import Stimulus
from ams.solve.gauss_newton import GaussNewtonResult, gauss_newton

NAMES = ("offset_v", "sensitivity_v_per_g", "coning_rad", "azimuth_rad")


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
