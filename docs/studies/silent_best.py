"""How often the best test that there could be would see what happens in a scene of the study of silent scenes.

Its form, its moment and its size in every axis are known to it: one degree of freedom at 5 %, beside offset and
sensitivities of a linear sensor, which are free. What the scene adds to the readings (the same campaign drawn with it
and without) is taken at what offset and sensitivities leave of it. No test of real readings knows as much: below 0.95
nobody can tell the scene in 95 % of the campaigns.
"""

from collections.abc import Mapping

import numpy as np
from physics_scenes import Campaign, campaigns
from scipy.stats import norm  # type: ignore[import-untyped]
from silent_declared import separated
from solved_campaigns import ARCSEC, rows_of

from ams.arrays import FloatArray
from ams.frames import specific_force

_LEVEL, _COUNT, _SEED = 0.05, 100, 1100
_NOT_JUDGED = ("table-", "use-", "two-packages-", "field-", "quantisation")
"""Errors of a table lie within a declared limit, which is no single form; rows in use are judged one by one; a
magnetometer is no accelerometer; and the steps of a meter have no form that anybody could know.
"""


def best_power(scene: str, size: float, design: Mapping[str, float]) -> float | None:
    """Return the mean power over campaigns; None for scenes that it says nothing of."""
    if scene.startswith(_NOT_JUDGED):
        return None
    design, _ = separated(design)
    with_it, without = (campaigns(scene, each, np.random.default_rng(_SEED), _COUNT, **design) for each in (size, 0.0))
    added, rows = _outputs(with_it) - _outputs(without), rows_of(with_it)
    linear = np.column_stack([np.ones(rows.rows), specific_force(rows.pitch_rad, rows.roll_rad)])
    free = np.linalg.qr(linear)[0]
    left = added - np.einsum("rf,cfs->crs", free, np.einsum("rf,crs->cfs", free, added))
    noise_v = with_it.setup.noise_arcsec * ARCSEC * 2.5
    seen = np.sqrt(np.einsum("crs,crs->c", left, left)) / noise_v
    bound = norm.isf(_LEVEL / 2.0)
    return float(np.mean(norm.sf(bound - seen) + norm.cdf(-bound - seen)))


def _outputs(drawn: Campaign) -> FloatArray:
    """(campaigns, rows, outputs) of the grid."""
    grid = drawn.grid(drawn.output_v)
    return grid.reshape(drawn.campaigns, grid.shape[1] * grid.shape[2], -1)
