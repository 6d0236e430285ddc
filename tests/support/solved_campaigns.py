"""Campaigns of ``physics_scenes`` solved as columns, and how often their intervals hold the truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from physics_scenes import Campaign

from ams.calibration.columns import SolvedColumns, solve_columns
from ams.frames import Attitude
from ams.inputs.table_uncertainty import IndexErrors, Shape, TableUncertainty
from ams.models.model import Model
from ams.observations import Observations
from ams.statistics.intervals import combined_dof, t_quantile

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0
_PLACES = 60


@dataclass(frozen=True)
class Coverage:
    """Shares of 95 % intervals that hold the truth, over all campaigns and axes."""

    offset: float
    sensitivities: float
    """Of the components of k."""
    prediction: float
    """Of the output at attitudes all over the calibrated range."""
    prediction_half_width_arcsec: float
    """Mean."""

    @property
    def least(self) -> float:
        return min(self.offset, self.sensitivities, self.prediction)


def table_of(limit_arcsec: float = 1.0, shape: Shape = "unknown", zero_rad: float | None = None) -> TableUncertainty:
    """The same declaration for pitch and roll."""
    errors = dict.fromkeys(("pitch", "roll"), IndexErrors(shape, zero_rad))
    return TableUncertainty(limit_arcsec * ARCSEC, limit_arcsec * ARCSEC, "limit", errors=errors)


def rows_of(campaign: Campaign) -> Observations:
    """The rows of the grid, replication by replication, without outputs."""
    points, n = np.deg2rad(campaign.points_deg), campaign.setup.replications
    return Observations(
        replication=np.repeat(np.arange(n), len(points)),
        point=np.tile(np.arange(len(points)), n),
        pitch_rad=np.tile(points[:, 0], n),
        roll_rad=np.tile(points[:, 1], n),
        outputs_v={},
    )


def columns_of(campaign: Campaign) -> FloatArray:
    """(N, campaigns × axes) outputs of the first sensor in the order of :func:`rows_of`, axis after axis."""
    grid = campaign.grid(campaign.output_v)[:, :, :, 0]
    return np.moveaxis(grid, 0, 2).reshape(grid.shape[1] * grid.shape[2], -1)


def solved(campaign: Campaign, model: type[Model], table: TableUncertainty | None) -> SolvedColumns:
    """All axes of all campaigns in one call."""
    models = [model(axis) for axis in campaign.setup.axes] * campaign.campaigns
    return solve_columns(rows_of(campaign), columns_of(campaign), models, table=table)


def coverage(campaign: Campaign, found: SolvedColumns, chance: np.random.Generator) -> Coverage:
    """Against the best linear sensor over the design, and against the true output at attitudes drawn from the range."""
    points, limit = campaign.points_deg, campaign.setup.pitch_limit_deg
    offset, k = campaign.package.best_linear(points[:, 0], points[:, 1])
    truth = np.concatenate([offset[..., None], k], axis=-1)[:, 0].reshape(-1, 4)
    halves = t_quantile(0.95, found.primary_dof) * np.sqrt(np.diagonal(found.primary_covariance, axis1=1, axis2=2))
    holds = np.abs(found.primary[:, :4] - truth) <= halves[:, :4]
    pitch_deg, roll_deg = chance.uniform(-limit, limit, _PLACES), chance.uniform(-180.0, 180.0, _PLACES)
    true_v = np.swapaxes(campaign.true_output_v(pitch_deg, roll_deg)[:, :, 0], 1, 2).reshape(-1, _PLACES)
    there = Attitude(np.deg2rad(pitch_deg), np.deg2rad(roll_deg))
    models = found.problem.models
    directions = np.stack([models[row].jacobian(found.primary[row], there) for row in range(len(campaign.setup.axes))])
    directions = np.tile(directions, (campaign.campaigns, 1, 1))
    half_v = _half_widths_v(directions, found)
    off_v = np.abs(np.einsum("mnp,mp->mn", directions, found.primary) - true_v)
    scale = np.linalg.norm(truth[:, 1:], axis=1)[:, None] * ARCSEC
    return Coverage(
        float(holds[:, 0].mean()),
        float(holds[:, 1:].mean()),
        float((off_v <= half_v).mean()),
        float((half_v / scale).mean()),
    )


def _half_widths_v(directions: FloatArray, found: SolvedColumns) -> FloatArray:
    """(m, places) of the outputs' 95 % confidence."""
    parts = np.stack(
        [np.einsum("mnp,mpq,mnq->mn", directions, part.covariance, directions) for part in found.components]
    )
    dof = combined_dof(parts, np.stack([part.dof for part in found.components])[:, :, None])
    return np.asarray(t_quantile(0.95, dof) * np.sqrt(parts.sum(axis=0)))
