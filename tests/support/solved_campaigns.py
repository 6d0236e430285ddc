"""Campaigns of ``physics_scenes`` solved as columns, and how often their intervals hold the truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from physics_scenes import Campaign, GyroRates

from ams.calibration.packages import calibrate_packages
from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.findings import Finding
from ams.frames import AXES, Attitude, euler_rates_rad_s
from ams.inputs.request import CalibrationRequest
from ams.inputs.shared_errors import SharedError
from ams.inputs.table_uncertainty import IndexErrors, Shape, TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.models.extended import ExtendedPitchRoll, centring_of
from ams.observations import Observations
from ams.statistics.intervals import combined_dof, t_quantile

FloatArray = NDArray[np.float64]
Solved = dict[str, SolvedColumns]
"""Axis to all campaigns of it."""
ARCSEC = np.pi / 180.0 / 3600.0
_STEPS = 60


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


def table_of(
    limit_arcsec: float = 1.0, shape: Shape = "unknown", zero_rad: float | None = None, zero_u_arcsec: float = 0.0
) -> TableUncertainty:
    """The same declaration for pitch and roll; ``zero_u_arcsec``: how well they were set to zero."""
    errors = dict.fromkeys(("pitch", "roll"), IndexErrors(shape, zero_rad, zero_u_arcsec * ARCSEC))
    return TableUncertainty(limit_arcsec * ARCSEC, limit_arcsec * ARCSEC, "limit", errors=errors)


def velocity_dps_of(drawn: GyroRates) -> FloatArray:
    """The (N, 3) rates about the axes of the package, replication by replication."""
    spin = np.array([0.0, 0.0, 1.0]) * drawn.rates_dps[:, None]
    return np.tile(np.einsum("pij,qj->pqi", drawn.to_package, spin).reshape(-1, 3), (drawn.output_v.shape[1], 1))


def rows_of_gyros(drawn: GyroRates, campaign: int = 0) -> Observations:
    """The dwells of one campaign, package axes taken as the table's: what turns is known as a vector."""
    replications, points = drawn.output_v.shape[1], drawn.output_v.shape[2] * drawn.output_v.shape[3]
    still = np.zeros(replications * points)
    return Observations(
        np.repeat(np.arange(replications), points),
        np.tile(np.arange(points), replications),
        still,
        still,
        {axis: drawn.output_v[campaign, ..., index].ravel() for index, axis in enumerate(AXES)},
        yaw_rad=still,
        euler_rate_rad_s=euler_rates_rad_s(np.zeros((still.size, 3)), np.deg2rad(velocity_dps_of(drawn))),
    )


def rows_of(campaign: Campaign) -> Observations:
    """The rows of the grid, replication by replication, without outputs."""
    points, n = np.deg2rad(campaign.points_deg), campaign.setup.replications
    return Observations(
        replication=np.repeat(np.arange(n), len(points)),
        point=np.tile(np.arange(len(points)), n),
        pitch_rad=np.tile(points[:, 0], n),
        roll_rad=np.tile(points[:, 1], n),
        time_s=campaign.schedule.time_s[campaign.schedule.grid_rows()].ravel(),
        outputs={},
    )


def columns_of(campaign: Campaign, axis: str, sensor: int = 0) -> FloatArray:
    """(N, campaigns) outputs of one axis of a sensor in the order of :func:`rows_of`."""
    grid = campaign.grid(campaign.output_v)[:, :, :, sensor, campaign.setup.axes.index(axis)]
    return grid.reshape(campaign.campaigns, -1).T


def rows_of_package(campaign: Campaign, index: int = 0, sensor: int = 0) -> Observations:
    """The rows of one campaign as one of its sensors read them, each with its time and temperature."""
    temperature = campaign.grid(campaign.temperature_degc).reshape(campaign.campaigns, -1)[index]
    outputs = {axis: columns_of(campaign, axis, sensor)[:, index] for axis in campaign.setup.axes}
    return replace(rows_of(campaign), temperature_degc=temperature, outputs=outputs)


def findings_of_lone_x(drawn: Campaign, count: int) -> list[list[Finding]]:
    """The significant findings of x, seen alone, of each of the first campaigns."""
    found = []
    for campaign in range(count):
        rows = rows_of_package(drawn, campaign)
        seen = replace(rows, outputs={"x": rows.outputs["x"]})
        axis = calibrate_packages({"p": seen}, CalibrationRequest())["p"].axes["x"]
        found.append([finding for finding in axis.findings if finding.is_significant])
    return found


def solved(
    campaign: Campaign,
    table: TableUncertainty | None = None,
    shared: Sequence[SharedError] = (),
    *,
    extended: bool = True,
) -> Solved:
    """Every axis of the first sensor, all campaigns of it in one call.

    Not ``extended`` is the linear sensor alone, which the recorded temperature says nothing of.
    """
    warmth = campaign.grid(campaign.temperature_degc).reshape(campaign.campaigns, -1).T if extended else None
    rows, points, found = rows_of(campaign), len(campaign.points_deg), {}
    for axis in campaign.setup.axes:
        centring = centring_of(rows, points, axis) if extended else None
        model = PitchRoll(axis) if centring is None else ExtendedPitchRoll(axis, centring)
        models = [model] * campaign.campaigns
        found[axis] = solve_columns(rows, columns_of(campaign, axis), models, None, table, shared, warmth)
    return found


def coverage(campaign: Campaign, found: Solved, chance: np.random.Generator) -> Coverage:
    """Against the best linear sensor over the design, and against the true output at attitudes drawn from the range."""
    points, limit = campaign.points_deg, campaign.setup.pitch_limit_deg
    best = campaign.package.best_linear(points[:, 0], points[:, 1])
    at_deg = chance.uniform(-limit, limit, _STEPS), chance.uniform(-180.0, 180.0, _STEPS)
    true_v = campaign.true_output_v(*at_deg)[:, :, 0]
    holds, predicted, halves = [], [], []
    for index, (axis, columns) in enumerate(found.items()):
        truth = np.concatenate([best[0][:, 0, index, None], best[1][:, 0, index]], axis=-1)
        uncertainty = np.sqrt(np.diagonal(columns.primary_covariance, axis1=1, axis2=2))
        half = t_quantile(0.95, columns.primary_dof) * uncertainty
        holds.append(np.abs(columns.primary[:, :4] - truth) <= half[:, :4])
        model = columns.problem.models[0]
        assert model.nominal_axis == axis
        directions = model.jacobian(columns.primary[0], Attitude(*np.deg2rad(at_deg)))
        half_v = _half_widths_v(directions, columns)
        predicted.append(np.abs(columns.primary @ directions.T - true_v[:, :, index]) <= half_v)
        halves.append(half_v / np.linalg.norm(truth[:, 1:], axis=1)[:, None] / ARCSEC)
    held = np.stack(holds)
    return Coverage(
        float(held[..., 0].mean()), float(held[..., 1:].mean()), float(np.mean(predicted)), float(np.mean(halves))
    )


def _half_widths_v(directions: FloatArray, found: SolvedColumns) -> FloatArray:
    """(m, places) of the outputs' 95 % confidence."""
    variances = [np.einsum("np,mpq,nq->mn", directions, part.covariance, directions) for part in found.components]
    parts = np.stack(variances)
    dof = combined_dof(parts, np.stack([part.dof for part in found.components])[:, :, None])
    return np.asarray(t_quantile(0.95, dof) * np.sqrt(parts.sum(axis=0)))
