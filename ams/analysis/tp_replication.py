"""The replication analysis exactly as NASA/TP-1999-209835 section 8 has it.

Kept because its numbers are in print. Its tests assume that only one effect is there at a time; the default forms in
:mod:`ams.analysis.replication` keep their false-alarm rate when lack of fit and drift meet.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ams.arrays import FloatArray
from ams.calibration_result import TpReplication
from ams.solve.layout import Layout
from ams.solve.linear_form import LinearForm
from ams.solve.replicated import ReplicatedSums
from ams.statistics.intervals import FTestColumns, after_holm, f_tests


@dataclass(frozen=True)
class TpColumns:
    """TP's analysis of m sensor axes."""

    sigma_bias_v: FloatArray
    sigma_prec_v: FloatArray
    bias: FTestColumns
    drift: dict[str, FTestColumns]

    def of(self, column: int) -> TpReplication:
        """Return the replication results of one sensor axis."""
        return TpReplication(
            sigma_bias_v=float(self.sigma_bias_v[column]),
            sigma_prec_v=float(self.sigma_prec_v[column]),
            t_bias=float(self.bias.t[column]),
            f_bias_95=float(self.bias.f_95),
            drift={name: test.of(column) for name, test in self.drift.items()},
        )


def tp_replication(
    form: LinearForm, layout: Layout, sums: ReplicatedSums, names: Sequence[str], directions: FloatArray
) -> TpColumns:
    """Return bias and drift from residuals pooled over all replications.

    ``directions`` (m, q, P) belong to ``names``.
    """
    rows, points, size = layout.rows, layout.points, form.basis.shape[1]
    dof_bias, dof_prec = points - size, rows - points
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (sums.ss_pooled_bias / max(dof_bias, 1)) / (sums.ss_pooled_precision / max(dof_prec, 1))
    return TpColumns(
        sigma_bias_v=np.sqrt(sums.ss_pooled_bias / rows),
        sigma_prec_v=np.sqrt(sums.ss_pooled_precision / rows),
        bias=f_tests({"": np.where(sums.ss_pooled_precision > 0.0, ratio, np.nan)}, dof_bias, dof_prec)[""],
        drift=_drift(form, layout, sums, names, directions),
    )


def _drift(
    form: LinearForm, layout: Layout, sums: ReplicatedSums, names: Sequence[str], directions: FloatArray
) -> dict[str, FTestColumns]:
    n = layout.replications
    dof = layout.rows - n * form.basis.shape[1]
    within = (sums.ss_precision + sums.ss_lack_of_fit) / max(dof, 1)
    spread = sums.separate - sums.separate.sum(axis=0) / n
    along = np.einsum("nim,mqi->mqn", spread, directions)
    per_replication = ((directions @ (n * form.unscaled_covariance)) * directions).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = (along**2).sum(axis=-1) / (n - 1) / per_replication / within[:, None]
    return after_holm(f_tests(dict(zip(names, ratios.T, strict=True)), n - 1, dof))
