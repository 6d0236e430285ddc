"""How often the F-test takes a table for a soft mount: many campaigns in a few lines of numpy.

The design is that of TP's figure 37, the noise its precision; every index of either axis has an error of its own,
rectangular within the limit, the same in all replications, ±180° being one index.
"""

import numpy as np
from numpy.typing import NDArray

from ams.frames import specific_force
from ams.inputs.table_uncertainty import TableUncertainty
from ams.observations import Observations
from ams.solve.extension import judge_extension
from ams.units import RAD_PER_ARCSEC

FloatArray = NDArray[np.float64]

SENSITIVITY_V_PER_G = 2.5
K_V_PER_G = SENSITIVITY_V_PER_G * np.array([0.99996, 0.0071, 0.0050])
OFFSET_V = 0.005
NOISE_DEG = 1.31e-4
REPLICATIONS = 4


def campaign(rng: np.random.Generator, limit_arcsec: float) -> Observations:
    """Sensor 1 of figure 37 without its soft mount, on a table of ±``limit_arcsec``."""
    pitch, roll = (
        angle.ravel()
        for angle in np.meshgrid(np.arange(-180.0, 181.0, 15.0), np.arange(-180.0, 181.0, 30.0), indexing="ij")
    )
    stood = [np.deg2rad(angle) + _teeth(angle, limit_arcsec * RAD_PER_ARCSEC, rng) for angle in (pitch, roll)]
    clean = OFFSET_V + specific_force(*stood) @ K_V_PER_G
    noise_v = SENSITIVITY_V_PER_G * np.deg2rad(NOISE_DEG)
    rows = REPLICATIONS * pitch.size
    return Observations(
        replication=np.repeat(np.arange(1, REPLICATIONS + 1), pitch.size),
        point=np.tile(np.arange(1, pitch.size + 1), REPLICATIONS),
        pitch_rad=np.tile(np.deg2rad(pitch), REPLICATIONS),
        roll_rad=np.tile(np.deg2rad(roll), REPLICATIONS),
        outputs={"x": np.tile(clean, REPLICATIONS) + noise_v * rng.standard_normal(rows)},
        source="figure 37 without a soft mount",
    )


def _teeth(angle_deg: FloatArray, limit_rad: float, rng: np.random.Generator) -> FloatArray:
    _, index = np.unique(np.round(np.mod(angle_deg, 360.0), 6), return_inverse=True)
    return rng.uniform(-limit_rad, limit_rad, int(index.max()) + 1)[index]


def accepted(runs: int, limit_arcsec: float, seed: int, knows_table: bool = True) -> int:
    """In how many of ``runs`` the extended model is accepted although there is no soft mount."""
    limit_rad = limit_arcsec * RAD_PER_ARCSEC
    table = TableUncertainty(limit_rad, limit_rad, "limit") if knows_table else None
    rngs = np.random.default_rng(seed).spawn(runs)
    return sum(judge_extension(campaign(rng, limit_arcsec), "x", table).is_accepted for rng in rngs)
