"""Whether 95 % intervals keep their promise where the number of replications is chosen by what was measured.

Simulated campaigns of one accelerometer under the rule of ``[stop] half_width_deg``, as
:mod:`procedures.solution.sufficient` has it: enough is the precision inside the replications against a limit, and no
drift that is significant.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from ams.arrays import FloatArray
from ams.calibration.solving.columns import solve_columns
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations

TYPICAL = 8
"""Replications at which noise as declared just meets the limit; the fixed size that stands beside."""
NOISE_V = 1e-5


@dataclass(frozen=True)
class AtStop:
    """Shares of 95 % intervals for offset and sensitivity that hold the truth."""

    stopped: float
    fixed: float
    """With :data:`TYPICAL` replications, whatever they show."""
    replications: float
    """Mean number at the stop."""


def coverage_at_stop(
    campaigns: int, chance: np.random.Generator, least: int = 4, most: int = 12, lack_of_fit: float = 0.0
) -> AtStop:
    """Count over campaigns of 18 attitudes; ``least`` to ``most`` replications, :data:`TYPICAL` among them.

    ``lack_of_fit``: standard deviation, over the noise, of an error of every attitude of its own. Without it intervals
    are on the safe side at any number of replications: a variance of lack of fit is never estimated below zero.
    """
    pitch, roll = (np.deg2rad(a).ravel() for a in np.meshgrid([-60.0, 0.0, 60.0], np.arange(-180.0, 180.0, 60.0)))
    model, truth = PitchRoll("x"), np.array([0.01, 2.5, 0.02, -0.01])
    clean = model.predict(truth, _rows(pitch, roll, 1))
    noise = chance.standard_normal((most, pitch.size, campaigns))
    fixed_v = lack_of_fit * NOISE_V * chance.standard_normal((pitch.size, campaigns))
    stopped, held, fixed, counts = np.zeros(campaigns, dtype=bool), [], [], []
    for n in range(least, most + 1):
        outputs = (clean[None, :, None] + fixed_v + NOISE_V * noise[:n]).reshape(n * pitch.size, campaigns)
        solved = solve_columns(_rows(pitch, roll, n), outputs, [model] * campaigns)
        assert solved.replication is not None
        half = solved.parameters.halfwidths_95[:, :2]
        covers = np.abs(solved.parameters.values[:, :2] - model.parameters(truth)[:2]) <= half
        foreseen = np.sqrt(solved.mixed.precision_variance / n)
        drift = np.any([test.is_significant for test in solved.replication.drift.values()], axis=0)
        enough = (foreseen <= NOISE_V / sqrt(TYPICAL)) & ~drift
        now = ~stopped & (enough | (n == most))
        held.append(covers[now])
        counts += [n] * int(now.sum())
        stopped |= now
        if n == TYPICAL:
            fixed.append(covers)
    return AtStop(float(np.concatenate(held).mean()), float(np.concatenate(fixed).mean()), float(np.mean(counts)))


def _rows(pitch_rad: FloatArray, roll_rad: FloatArray, n: int) -> Observations:
    points = pitch_rad.size
    return Observations(
        np.repeat(np.arange(n), points),
        np.tile(np.arange(points), n),
        np.tile(pitch_rad, n),
        np.tile(roll_rad, n),
        {},
    )
