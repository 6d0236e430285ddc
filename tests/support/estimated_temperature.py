"""Campaigns over temperature plateaus whose coefficients are estimated: solved one by one, then stacked.

A sensor with temperature terms that are estimated is no longer linear in its parameters, so every campaign has a basis
of its own. Every visit of a plateau shifts offset and sensitivities by its own amount.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from simulated_columns import NOISE_V, REFERENCE_DEGC, TRUTH, force_of

from ams.calibration.solving.columns import SolvedColumns, solve_columns
from ams.models.accelerometer import PitchRoll
from ams.models.thermal import WithTemperature
from ams.observations import Observations
from ams.solve.components import ComponentColumns

FloatArray = NDArray[np.float64]
OFFSET_TC, SENSITIVITY_TC = 3e-5, 2e-4


@dataclass(frozen=True)
class Stacked:
    """What the coverage tests look at of m campaigns."""

    primary: FloatArray
    primary_covariance: FloatArray
    primary_dof: FloatArray
    components: list[ComponentColumns]


def simulate_visits(
    plateaus_degc: Sequence[float],
    replications_a_visit: int,
    campaigns: int,
    rng: np.random.Generator,
    lack_of_fit: float = 0.0,
    visit_error: float = 4.0,
) -> Stacked:
    """Twelve points. The error of a visit is in standard errors of one replication."""
    grid = np.meshgrid(np.deg2rad([-60.0, 0.0, 60.0]), np.deg2rad([-180.0, -90.0, 0.0, 90.0]))
    pitch, roll = (angle.ravel() for angle in grid)
    points, visits = pitch.size, len(plateaus_degc)
    n = visits * replications_a_visit
    basis = force_of(pitch, roll)
    spread = visit_error * NOISE_V * np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)))
    model, solved = WithTemperature(PitchRoll("x"), REFERENCE_DEGC), []
    for _ in range(campaigns):
        plateau = np.repeat(np.asarray(plateaus_degc), replications_a_visit)[:, None]
        temperature = plateau + rng.uniform(-0.3, 0.3, (n, points))
        rise = temperature - REFERENCE_DEGC
        by_replication = TRUTH + np.repeat(spread * rng.standard_normal((visits, 4)), replications_a_visit, axis=0)
        sensed = by_replication[:, 1:] @ basis[:, 1:].T
        output = by_replication[:, :1] + OFFSET_TC * rise + (1.0 + SENSITIVITY_TC * rise) * sensed
        output = (
            output + lack_of_fit * NOISE_V * rng.standard_normal(points) + NOISE_V * rng.standard_normal(rise.shape)
        )
        rows = Observations(
            replication=np.repeat(np.arange(n), points),
            point=np.tile(np.arange(points), n),
            pitch_rad=np.tile(pitch, n),
            roll_rad=np.tile(roll, n),
            outputs={},
            temperature_degc=temperature.ravel(),
        )
        solved.append(solve_columns(rows, output.reshape(-1, 1), [model]))
    return stacked(solved)


def stacked(solved: Sequence[SolvedColumns]) -> Stacked:
    names = dict.fromkeys(part.name for entry in solved for part in entry.components)
    return Stacked(
        np.concatenate([entry.primary for entry in solved]),
        np.concatenate([entry.primary_covariance for entry in solved]),
        np.concatenate([entry.primary_dof for entry in solved]),
        [_part(name, solved) for name in names],
    )


def _part(name: str, solved: Sequence[SolvedColumns]) -> ComponentColumns:
    """Nothing where a campaign found none of it."""
    nothing = ComponentColumns(name, np.zeros_like(solved[0].primary_covariance), np.ones(1))
    parts = [next((part for part in entry.components if part.name == name), nothing) for entry in solved]
    return ComponentColumns(
        name, np.concatenate([part.covariance for part in parts]), np.concatenate([part.dof for part in parts])
    )
