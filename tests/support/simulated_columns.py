"""Thousands of campaigns of one sensor along x at a time: one column each, everything that can err redrawn in each.

Independent of the rig's twin and of the solvers: the specific force is written out, the errors are added to volts.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.inputs.request import select_rows
from ams.inputs.table_uncertainty import IndexErrors, TableUncertainty
from ams.models.accelerometer import PitchRoll
from ams.models.model import Model
from ams.models.thermal import TemperatureCoefficients, WithTemperature
from ams.observations import Observations

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0
NOISE_V = 6e-6
TRUTH = np.array([0.005, 2.4999, 0.0179, 0.0125])
OFFSET_TC, SENSITIVITY_TC = 3e-6, 2e-5
REFERENCE_DEGC = 20.0


def force_of(pitch_rad: FloatArray, roll_rad: FloatArray) -> FloatArray:
    """(N, 4) one and the specific force, TP (2)."""
    level = np.cos(pitch_rad)
    ones = np.ones_like(pitch_rad)
    return np.stack([ones, np.sin(pitch_rad), -level * np.sin(roll_rad), -level * np.cos(roll_rad)], axis=1)


@dataclass(frozen=True)
class Scene:
    """What errs, in units of the noise of one reading, or as told."""

    lack_of_fit: float = 0.0
    """Standard deviation of an error of every point of its own, over the noise."""
    drift: float = 0.0
    """Standard deviation of every parameter between replications, over its standard error from one replication."""
    index_limit_arcsec: float = 0.0
    """Half-width of the rectangular error of every index of pitch and roll."""
    temperature: bool = False
    """All at about 24 °C, with coefficients that are known to a tenth of their size."""
    dropped: float = 0.0
    """Share of the rows that are missing."""
    replications: int = 6
    truth: FloatArray = field(default_factory=lambda: TRUTH)


@dataclass(frozen=True)
class Simulated:
    solved: SolvedColumns
    truth: FloatArray


POINTS = 42


def simulate(scene: Scene, campaigns: int, rng: np.random.Generator, noise_v: FloatArray | None = None) -> Simulated:
    """Campaigns of 42 points, ±90° pitch by 30° and six roll angles, solved.

    ``noise_v``: (N, m) of the means of the dwells; None: white, :data:`NOISE_V`.
    """
    grid = np.meshgrid(np.deg2rad(np.arange(-90.0, 91.0, 30.0)), np.deg2rad(np.arange(-180.0, 121.0, 60.0)))
    pitch, roll = (angle.ravel() for angle in grid)
    n, points = scene.replications, pitch.size
    observations = Observations(
        replication=np.repeat(np.arange(n), points),
        point=np.tile(np.arange(points), n),
        pitch_rad=np.tile(pitch, n),
        roll_rad=np.tile(roll, n),
        outputs={},
        temperature_degc=np.tile(24.0 + rng.uniform(-1.0, 1.0, points), n) if scene.temperature else None,
    )
    outputs_v = _outputs_v(scene, observations, campaigns, rng, noise_v)
    if scene.dropped > 0.0:
        kept = rng.uniform(size=observations.rows) >= scene.dropped
        observations, outputs_v = select_rows(observations, kept), outputs_v[kept]
    table = teeth_within(scene.index_limit_arcsec) if scene.index_limit_arcsec else None
    solved = solve_columns(observations, outputs_v, [model_of(scene)] * campaigns, table=table)
    return Simulated(solved, scene.truth)


def teeth_within(limit_arcsec: float) -> TableUncertainty:
    """A table whose teeth are declared independent, pitch and roll."""
    errors = dict.fromkeys(("pitch", "roll"), IndexErrors("independent"))
    return TableUncertainty(*[limit_arcsec * ARCSEC] * 2, "limit", errors=errors)


def model_of(scene: Scene, axis: str = "x") -> Model:
    if not scene.temperature:
        return PitchRoll(axis)
    known = TemperatureCoefficients(OFFSET_TC, SENSITIVITY_TC, 0.1 * OFFSET_TC, 0.1 * SENSITIVITY_TC)
    return WithTemperature(PitchRoll(axis), REFERENCE_DEGC, known)


def warmed(outputs: FloatArray, offset_v: FloatArray, rise_degc: FloatArray, rng: np.random.Generator) -> FloatArray:
    """(…, m) outputs with temperature coefficients that are off by a tenth, each column's its own."""
    if not rise_degc.any():
        return outputs
    offset_tc = OFFSET_TC * (1.0 + 0.1 * rng.standard_normal(offset_v.size))
    sensitivity_tc = SENSITIVITY_TC * (1.0 + 0.1 * rng.standard_normal(offset_v.size))
    return outputs + offset_tc * rise_degc + sensitivity_tc * rise_degc * (outputs - offset_v)


def _outputs_v(
    scene: Scene,
    observations: Observations,
    campaigns: int,
    rng: np.random.Generator,
    noise_v: FloatArray | None = None,
) -> FloatArray:
    """(N, m)"""
    n, rows = scene.replications, observations.rows
    points = rows // n
    basis = force_of(observations.pitch_rad, observations.roll_rad)
    per_replication = np.linalg.inv(basis[:points].T @ basis[:points])
    drifts = scene.drift * NOISE_V * np.sqrt(np.diag(per_replication)) * rng.standard_normal((campaigns, n, 4))
    parameters = scene.truth + drifts
    sensed = np.einsum("ki,mri->rkm", basis[:points], parameters).reshape(rows, campaigns)
    if scene.index_limit_arcsec:
        sensed = sensed + np.tile(_index_errors_v(scene, observations, points, campaigns, rng), (n, 1))
    if observations.temperature_degc is not None:
        rise = (observations.temperature_degc - REFERENCE_DEGC)[:, None]
        sensed = warmed(sensed, parameters[:, 0, 0], rise, rng)
    lack_of_fit = scene.lack_of_fit * NOISE_V * rng.standard_normal((points, campaigns))
    noise_v = NOISE_V * rng.standard_normal((rows, campaigns)) if noise_v is None else noise_v
    return sensed + np.tile(lack_of_fit, (n, 1)) + noise_v


def _index_errors_v(
    scene: Scene, observations: Observations, points: int, campaigns: int, rng: np.random.Generator
) -> FloatArray:
    """(K, m) what the errors of the indices do to the output, by the sines of the true angles."""
    true = []
    for angle in (observations.pitch_rad[:points], observations.roll_rad[:points]):
        location = np.unique(np.round(angle, 6), return_inverse=True)[1]
        limit = scene.index_limit_arcsec * ARCSEC
        true.append(angle[:, None] + rng.uniform(-limit, limit, (location.max() + 1, campaigns))[location])
    nominal = force_of(observations.pitch_rad[:points], observations.roll_rad[:points]) @ scene.truth
    stood = force_of(true[0].ravel(), true[1].ravel()) @ scene.truth
    return stood.reshape(points, campaigns) - nominal[:, None]
