"""A replicated pitch-roll campaign in a few lines of numpy, independent of the rig's twin.

The table is commanded to the nominal angles and truly stands at nominal plus the error of that index (rectangular, one
for every index of each axis, redrawn per seed); the solver is told the nominal angles.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ams.observations import Observations

FloatArray = NDArray[np.float64]
ARCSEC = np.pi / 180.0 / 3600.0

OFFSET_V = {"x": 0.005, "y": -0.02, "z": 0.011}
VECTOR_V_PER_G = {
    "x": np.array([2.49990, 0.0179, 0.0125]),
    "y": np.array([0.0091, -2.4800, 0.0150]),
    "z": np.array([-0.0110, 0.0200, 2.5100]),
}


@dataclass(frozen=True)
class Campaign:
    pitch_deg: FloatArray = field(default_factory=lambda: np.linspace(-90.0, 90.0, 7))
    roll_deg: FloatArray = field(default_factory=lambda: np.linspace(-180.0, 180.0, 7))
    replications: int = 4
    noise_arcsec: float = 0.5
    index_limit_arcsec: float = 0.0
    lack_of_fit_arcsec: float = 0.0
    """Standard deviation of an error of every point of its own, the same in every replication."""
    offset_drift_arcsec: float = 0.0
    sensitivity_drift: float = 0.0
    """Standard deviation of the relative change of sensitivity between replications."""

    def observe(self, rng: np.random.Generator) -> Observations:
        grid = np.meshgrid(self.pitch_deg, self.roll_deg, indexing="ij")
        pitch, roll = (np.deg2rad(angle).ravel() for angle in grid)
        points, n = pitch.size, self.replications
        true_pitch, true_roll = (self._stood(angle, rng) for angle in grid)
        force = np.stack(
            [np.sin(true_pitch), -np.cos(true_pitch) * np.sin(true_roll), -np.cos(true_pitch) * np.cos(true_roll)],
            axis=1,
        )
        outputs = {axis: self._outputs(axis, force, rng).ravel() for axis in ("x", "y", "z")}
        return Observations(
            replication=np.repeat(np.arange(1, n + 1), points),
            point=np.tile(np.arange(1, points + 1), n),
            pitch_rad=np.tile(pitch, n),
            roll_rad=np.tile(roll, n),
            outputs=outputs,
        )

    def _stood(self, angle_deg: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Nominal plus the error of the index; ±180° are one index."""
        _, index = np.unique(np.round(np.mod(angle_deg, 360.0), 6).ravel(), return_inverse=True)
        limit = self.index_limit_arcsec * ARCSEC
        errors = rng.uniform(-limit, limit, index.max() + 1)
        return np.deg2rad(angle_deg).ravel() + errors[index]

    def _outputs(self, axis: str, force: FloatArray, rng: np.random.Generator) -> FloatArray:
        """(n, K) volts; arc seconds are turned to volts by the sensitivity."""
        k, points, n = VECTOR_V_PER_G[axis], force.shape[0], self.replications
        arcsec_v = ARCSEC * np.linalg.norm(k)
        offset = OFFSET_V[axis] + self.offset_drift_arcsec * arcsec_v * rng.standard_normal((n, 1))
        scale = 1.0 + self.sensitivity_drift * rng.standard_normal((n, 1))
        fixed = self.lack_of_fit_arcsec * arcsec_v * rng.standard_normal(points)
        return offset + scale * (force @ k) + fixed + self.noise_arcsec * arcsec_v * rng.standard_normal((n, points))
