"""Pitch alone: every point stands on an index of its own, so that the table's errors and the points' look alike."""

import numpy as np
import pytest
from case_shares import rest_to_thorough

from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.inputs.table_uncertainty import TableUncertainty
from ams.models.accelerometer import PitchOnly
from ams.observations import Observations
from ams.statistics.intervals import t_quantile

ARCSEC = np.pi / 180.0 / 3600.0
NOISE_V = 6e-6
TRUTH = np.array([0.005, 2.5 * np.cos(0.01), -2.5 * np.sin(0.01)])
"""Offset, k_x, k_z of a sensor that is misaligned by 0.01 rad."""


def solved(
    points: int, replications: int, limit_arcsec: float, lack_of_fit: float, campaigns: int = 800
) -> SolvedColumns:
    rng = np.random.default_rng(points + replications)
    pitch = np.deg2rad(np.linspace(-90.0, 90.0, points))
    stood = pitch[:, None] + rng.uniform(-limit_arcsec, limit_arcsec, (points, campaigns)) * ARCSEC
    clean = 0.005 + 2.5 * np.sin(stood + 0.01) + lack_of_fit * NOISE_V * rng.standard_normal((points, campaigns))
    outputs_v = np.tile(clean, (replications, 1))
    outputs_v = outputs_v + NOISE_V * rng.standard_normal(outputs_v.shape)
    rows = Observations(
        replication=np.repeat(np.arange(replications), points),
        point=np.tile(np.arange(points), replications),
        pitch_rad=np.tile(pitch, replications),
        roll_rad=np.zeros(points * replications),
        outputs={},
    )
    table = TableUncertainty(limit_arcsec * ARCSEC, 0.0, "limit")
    return solve_columns(rows, outputs_v, [PitchOnly("x")] * campaigns, table=table)


def halfwidths(found: SolvedColumns) -> np.ndarray:
    spread = np.sqrt(np.diagonal(found.primary_covariance, axis1=1, axis2=2))
    return t_quantile(0.95, found.primary_dof) * spread


@pytest.mark.parametrize(
    ("grid", "limit_arcsec", "lack_of_fit"),
    rest_to_thorough([(5, 1), (5, 2), (7, 6), (13, 1), (25, 1)], [1.0, 5.0], [0.0, 3.0], every=3),
)
def test_few_points_on_indices_of_their_own_err_on_the_safe_side(
    grid: tuple[int, int], limit_arcsec: float, lack_of_fit: float
) -> None:
    """Where the likelihood's zero for the points' own variance was believed, 46 to 88 % held."""
    points, replications = grid
    found = solved(points, replications, limit_arcsec, lack_of_fit)
    held = np.mean(np.abs(found.primary - TRUTH) < halfwidths(found), axis=0)
    assert held.min() > 0.92


@pytest.mark.parametrize("points", [5, 7, 19, 37])
def test_effective_degrees_of_freedom_are_never_below_one_and_intervals_stay_finite(points: int) -> None:
    """Two replications without roll: parts of a degree of freedom once made half-widths of 1e29 V."""
    found = solved(points, 2, 5.0, 0.0, campaigns=200)
    assert found.primary_dof.min() >= 1.0
    wide = halfwidths(found)
    assert np.all(wide < 12.706205 * np.sqrt(np.diagonal(found.primary_covariance, axis1=1, axis2=2)) * (1.0 + 1e-6))
