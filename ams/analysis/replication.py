"""Lack of fit and drift from n replications of the same K points, in the form that stands up when both are there.

With P free parameters: precision from what a fit with parameters per replication *and* an effect per point leaves,
(n − 1)(K − P) degrees of freedom; lack of fit from the point effects, K − P; drift of a parameter from the contrasts
between replications, n − 1; both held against precision alone. Simulated false alarms stay at 4 to 6 % in every
combination of lack of fit and drift, where the printed form of TP 8 gives 0 % or more than 30 %.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.analysis.tp_replication import TpColumns, tp_replication
from ams.arrays import FloatArray
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.replicated import ReplicatedSums
from ams.statistics.intervals import FTestColumns, after_holm, f_tests

_UNIT = re.compile(r"_(v_per_g[23]?|g_per_v|g|v_per_dps|v_per_degc|v_per_h|per_degc|v|deg|degc)$")
_ROUNDING = 32.0 * float(np.finfo(float).eps)
"""Of the largest output: a scatter below it is of the arithmetic."""
_LACK_OF_FIT = "lack of fit"


@dataclass(frozen=True)
class ReplicationColumns:
    """All tests of m sensor axes."""

    lack_of_fit: FTestColumns
    drift: dict[str, FTestColumns]
    """By quantity: ``offset``, ``sensitivity`` …"""
    tp: TpColumns


def quantity(parameter_name: str) -> str:
    """Return a parameter's name without its unit, as the replication tests are keyed: ``offset`` of ``offset_v``."""
    return _UNIT.sub("", parameter_name)


def analyse(
    form: LinearForm,
    layout: Layout,
    largest_v: FloatArray,
    sums: ReplicatedSums,
    names: Sequence[str],
    directions: FloatArray,
) -> ReplicationColumns:
    """Return all tests of m sensor axes.

    ``directions`` (m, q, P) are the derivatives of the quantities ``names`` by the free primary parameters,
    ``largest_v`` (m,) the largest outputs.

    A quantity whose derivative does not exist (NaN: azimuth without coning) has no test. Without degrees of freedom for
    precision, or with residuals at the rounding level of the data, there is none at all.
    """
    above_rounding = np.sqrt(sums.ss_precision / max(sums.dof_precision, 1)) > _ROUNDING * largest_v
    has_tests = above_rounding & (sums.dof_precision > 0) & (sums.dof_lack_of_fit > 0)
    precision = np.where(has_tests, sums.ss_precision, np.nan) / max(sums.dof_precision, 1)
    lack_of_fit = sums.ss_lack_of_fit / max(sums.dof_lack_of_fit, 1)
    dof, dof_precision = layout.replications - 1, sums.dof_precision
    ratios = sums.contrast_squares(directions) / dof / precision[:, None]
    tests = f_tests({_LACK_OF_FIT: lack_of_fit / precision}, sums.dof_lack_of_fit, dof_precision)
    tests |= f_tests(dict(zip(names, ratios.T, strict=True)), dof, dof_precision)
    tests = after_holm(tests)
    directions = np.where(has_tests[:, None, None], directions, np.nan)
    return ReplicationColumns(
        lack_of_fit=tests.pop(_LACK_OF_FIT),
        drift=tests,
        tp=tp_replication(form, layout, sums, names, directions),
    )
