"""An index of a table has one error whatever its axis reads there: every dwell was a tooth of its own before."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.inputs.table_uncertainty import IndexErrors, Shape, TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations
from ams.statistics.intervals import t_quantile

ARCSEC = np.pi / 180.0 / 3600.0
NOISE_V = 2e-5
REPLICATIONS, CAMPAIGNS = 4, 200
PITCH, ROLL = (
    grid.ravel() for grid in np.meshgrid(np.arange(-80.0, 81.0, 20.0), np.arange(-180.0, 180.0, 45.0), indexing="ij")
)
TRUTH = np.array([0.005, 2.5, 0.02, -0.01])
"""Offset and sensitivities of x."""
SCATTERS_DEG = (0.0, 1e-6, 1e-5, 1e-4, 1e-3)


def rows_read_back(scatter_deg: float, seed: int = 3) -> Observations:
    rng, points = np.random.default_rng(seed), PITCH.size
    pitch, roll = (
        np.deg2rad(np.tile(angle, REPLICATIONS) + scatter_deg * rng.standard_normal(REPLICATIONS * points))
        for angle in (PITCH, ROLL)
    )
    replication, point = np.divmod(np.arange(REPLICATIONS * points), points)
    return Observations(replication, point, pitch, roll, {})


def teeth_rad(limit_arcsec: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return (N,) errors of pitch and roll, independent from index to index."""
    each = []
    for angle in (PITCH, ROLL):
        indices, index = np.unique(angle, return_inverse=True)
        each.append(np.tile(rng.uniform(-limit_arcsec, limit_arcsec, indices.size)[index] * ARCSEC, REPLICATIONS))
    return each[0], each[1]


def outputs_v(rows: Observations, limit_arcsec: float, campaigns: int = CAMPAIGNS) -> np.ndarray:
    """Return (N, campaigns) of x at the rows' angles and the teeth of each campaign."""
    rng, every = np.random.default_rng(7), []
    for _ in range(campaigns):
        of_pitch, of_roll = teeth_rad(limit_arcsec, rng)
        clean = TRUTH[0] + specific_force(rows.pitch_rad + of_pitch, rows.roll_rad + of_roll) @ TRUTH[1:]
        every.append(clean + NOISE_V * rng.standard_normal(clean.size))
    return np.stack(every, axis=1)


def table_of(limit_arcsec: float, shape: Shape) -> TableUncertainty:
    errors = dict.fromkeys(("pitch", "roll"), IndexErrors(shape))
    return TableUncertainty(limit_arcsec * ARCSEC, limit_arcsec * ARCSEC, "limit", errors=errors)


def solved(rows: Observations, outputs: np.ndarray, limit_arcsec: float, shape: Shape = "independent") -> SolvedColumns:
    return solve_columns(rows, outputs, [PitchRoll("x")] * outputs.shape[1], table=table_of(limit_arcsec, shape))


def uncertainties(found: SolvedColumns) -> np.ndarray:
    return np.sqrt(np.diagonal(found.primary_covariance, axis1=1, axis2=2))


@pytest.mark.parametrize("limit_arcsec", [2.0, 10.0])
@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG)
def test_intervals_hold_whatever_the_axes_read_at_an_index(scatter_deg: float, limit_arcsec: float) -> None:
    """A tooth a dwell held 0.4 to 0.7 of the offsets at a scatter of 0.0001°."""
    stood = outputs_v(rows_read_back(0.0), limit_arcsec)
    found = solved(rows_read_back(scatter_deg), stood, limit_arcsec)
    half = t_quantile(0.95, found.primary_dof) * uncertainties(found)
    held = np.mean(np.abs(found.primary - TRUTH) < half, axis=0)
    assert held.min() > 0.9


@pytest.mark.parametrize("shape", ["independent", "unknown", "smooth"])
@pytest.mark.parametrize("limit_arcsec", [2.0, 10.0])
@pytest.mark.parametrize("scatter_deg", SCATTERS_DEG[1:])
def test_the_tables_part_of_an_uncertainty_does_not_know_the_scatter(
    scatter_deg: float, limit_arcsec: float, shape: Shape
) -> None:
    """The axes stand where they read, so that their scatter is none of the readings'."""
    exact, scattered = rows_read_back(0.0), rows_read_back(scatter_deg)
    of_exact, of_scattered = (
        uncertainties(solved(rows, outputs_v(rows, limit_arcsec, 20), limit_arcsec, shape))
        for rows in (exact, scattered)
    )
    np.testing.assert_allclose(of_scattered, of_exact, rtol=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_a_table_without_play_has_none_where_its_axes_scatter(seed: int) -> None:
    rng, rows = np.random.default_rng(500 + seed), rows_read_back(1e-4, seed)
    of_pitch, of_roll = teeth_rad(10.0, rng)
    exact = rows_read_back(0.0)
    force = specific_force(exact.pitch_rad + of_pitch, exact.roll_rad + of_roll)
    sensors = 2.5 * (np.eye(3) + 0.01 * rng.standard_normal((3, 3)))
    clean = force @ sensors.T
    outputs = clean + NOISE_V * rng.standard_normal(clean.shape)
    seen = Observations(
        rows.replication, rows.point, rows.pitch_rad, rows.roll_rad, dict(zip("xyz", outputs.T, strict=True))
    )
    found = calibrate(seen, CalibrationRequest(table=table_of(10.0, "unknown")))
    told = {finding.kind for axis in found.axes.values() for finding in axis.findings if finding.is_significant}
    assert "backlash" not in told
    assert found.verdict != "not usable"
