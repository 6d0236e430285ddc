"""The replication analysis exactly as NASA/TP-1999-209835 section 8 has it.

Kept because its numbers are in print. Its tests assume that only one effect is there at a time; the default forms in
:mod:`ams.uncertainty.replication` keep their false-alarm rate when lack of fit and drift meet.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.replicated import ReplicatedSums
from ams.solve.result import FTest, TpReplication
from ams.uncertainty.intervals import f_quantile, f_test, significance

FloatArray = NDArray[np.float64]


def t_bias(sigma_bias: float, sigma_prec: float, points: int, replications: int, parameters: int) -> float:
    """T_bias from the printed columns of TP table 2, any common unit."""
    mean_square_bias = sigma_bias**2 * replications * points / (points - parameters)
    mean_square_precision = sigma_prec**2 * replications / (replications - 1)
    return mean_square_bias / mean_square_precision


def f_bias(points: int, replications: int, parameters: int, level: float = 0.95) -> float:
    """F(K − L, K(n − 1)) that T_bias is held against."""
    return f_quantile(level, points - parameters, points * (replications - 1))


def tp_replication(
    form: LinearForm,
    layout: Layout,
    output_v: FloatArray,
    sums: ReplicatedSums,
    directions: Mapping[str, FloatArray],
) -> TpReplication:
    """Bias and drift from residuals pooled over all replications; ``directions`` are rows of (P,) by quantity."""
    residuals = output_v - form.basis @ form.solve(output_v)
    weights = np.ones(layout.rows) if form.weights is None else form.weights
    readings = layout.sum_by_point(weights)
    mean = layout.sum_by_point(weights * residuals) / readings
    ss_bias = float(np.sum(readings * mean**2))
    ss_prec = float(np.sum(weights * (residuals - mean[layout.point]) ** 2))
    rows, points, size = layout.rows, layout.points, form.basis.shape[1]
    dof_bias, dof_prec = points - size, rows - points
    has_test = dof_bias > 0 and dof_prec > 0 and ss_prec > 0.0
    return TpReplication(
        sigma_bias_v=float(np.sqrt(ss_bias / rows)),
        sigma_prec_v=float(np.sqrt(ss_prec / rows)),
        t_bias=(ss_bias / dof_bias) / (ss_prec / dof_prec) if has_test else float("nan"),
        f_bias_95=f_quantile(0.95, dof_bias, dof_prec) if has_test else float("nan"),
        drift=_drift(form, layout, sums, directions),
    )


def _drift(
    form: LinearForm, layout: Layout, sums: ReplicatedSums, directions: Mapping[str, FloatArray]
) -> Mapping[str, FTest]:
    n, size = layout.replications, form.basis.shape[1]
    dof = layout.rows - n * size
    within = float(sums.ss_precision[0] + sums.ss_lack_of_fit[0]) / dof if dof > 0 else 0.0
    if within == 0.0:
        return {}
    spread = sums.separate[..., 0] - sums.separate[..., 0].mean(axis=0)
    one_replication = n * form.unscaled_covariance
    tests = {}
    for quantity, direction in directions.items():
        between = float(np.sum((spread @ direction) ** 2)) / (n - 1) / float(direction @ one_replication @ direction)
        tests[quantity] = f_test(between / within, n - 1, dof)
    return significance(tests)
