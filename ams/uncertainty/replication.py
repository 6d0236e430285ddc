"""Lack of fit and drift from n replications of the same K points, in the form that stands up when both are there.

With P free parameters: precision from what a fit with parameters per replication *and* an effect per point leaves,
(n − 1)(K − P) degrees of freedom; lack of fit from the point effects, K − P; drift of a parameter from the contrasts
between replications, n − 1; both held against precision alone. Simulated false alarms stay at 4 to 6 % in every
combination of lack of fit and drift, where the printed form of TP 8 gives 0 % or more than 30 %.
"""

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.mixed_model import MixedEstimate
from ams.solve.replicated import ReplicatedSums
from ams.solve.result import FTest, Replication, TpReplication
from ams.uncertainty.intervals import f_test, significance
from ams.uncertainty.tp_replication import tp_replication

FloatArray = NDArray[np.float64]

_UNIT = re.compile(r"_(v_per_g2?|v_per_dps|v_per_degc|per_degc|v|deg|degc)$")
_ROUNDING = 32.0 * float(np.finfo(float).eps)
_NO_TEST = FTest(float("nan"), float("nan"), float("nan"), float("nan"), float("nan"), False)


def quantity(parameter_name: str) -> str:
    """``offset`` of ``offset_v``: a parameter's name without its unit, as the replication tests are keyed."""
    return _UNIT.sub("", parameter_name)


def analyse(
    form: LinearForm,
    layout: Layout,
    output_v: FloatArray,
    mixed: MixedEstimate,
    directions: Mapping[str, FloatArray],
    per_replication: Mapping[int, Mapping[str, float]],
) -> Replication:
    """All tests of one sensor axis; ``directions`` maps a quantity to its derivative by the free primary
    parameters, (P,).

    A quantity whose derivative does not exist (NaN: azimuth without coning) has no test. Without degrees of freedom for
    precision, or with residuals at the rounding level of the data, there is none at all.
    """
    sums = mixed.sums
    assert sums is not None
    known = {name: direction for name, direction in directions.items() if np.all(np.isfinite(direction))}
    tested = _default_tests(sums, layout, known) if _has_tests(sums, output_v) else {}
    tp = tp_replication(form, layout, output_v, sums, known if tested else {})
    return Replication(
        replications=layout.replications,
        points=layout.points,
        lack_of_fit=tested.get("lack of fit", _NO_TEST),
        drift={name: tested.get(name, _NO_TEST) for name in directions},
        tp=_with_all(tp, directions),
        precision_v=float(np.sqrt(mixed.precision_variance)),
        lack_of_fit_v=float(np.sqrt(mixed.lack_of_fit_variance)),
        per_replication=per_replication,
    )


def _has_tests(sums: ReplicatedSums, output_v: FloatArray) -> bool:
    if sums.dof_precision <= 0 or sums.dof_lack_of_fit <= 0:
        return False
    return float(np.sqrt(sums.ss_precision[0] / sums.dof_precision)) > _ROUNDING * float(np.abs(output_v).max())


def _default_tests(sums: ReplicatedSums, layout: Layout, directions: Mapping[str, FloatArray]) -> Mapping[str, FTest]:
    precision = float(sums.ss_precision[0]) / sums.dof_precision
    lack_of_fit = float(sums.ss_lack_of_fit[0]) / sums.dof_lack_of_fit
    tests = {"lack of fit": f_test(lack_of_fit / precision, sums.dof_lack_of_fit, sums.dof_precision)}
    dof = layout.replications - 1
    for name, direction in directions.items():
        tests[name] = f_test(contrast_square(sums, direction) / dof / precision, dof, sums.dof_precision)
    return significance(tests)


def contrast_square(sums: ReplicatedSums, direction: FloatArray) -> float:
    """Sum of squares of one direction's contrasts between replications, in units of the variance of a row."""
    contrasts = sums.contrasts[..., 0] @ direction
    covariance = np.einsum("i,risj,j->rs", direction, sums.contrast_covariance, direction)
    covariance += np.trace(covariance) / contrasts.size**2  # the null vector, all ones, that contrasts do not touch
    return float(contrasts @ np.linalg.solve(covariance, contrasts))


def _with_all(tp: TpReplication, names: Mapping[str, FloatArray]) -> TpReplication:
    return replace(tp, drift={name: tp.drift.get(name, _NO_TEST) for name in names})
