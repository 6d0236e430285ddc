"""Replications of one package of three linear sensors at written-out attitudes, and their solution."""

import numpy as np
from physics_scenes.rotations import ARCSEC, specific_force

from ams.calibration.calibrate import calibrate
from ams.calibration_result import Calibration
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

PITCHES, ROLLS = 7, 8
POINTS = PITCHES * ROLLS


def campaign(seed: int, replications: int = 4, *, steps: bool = False) -> Observations:
    """±60° of pitch there and back, every 45° of roll to and fro, sensors 0.3° off their axes at 1.65″ a dwell."""
    chance = np.random.default_rng([70, seed])
    pitches, rolls = np.arange(-60.0, 61.0, 20.0), np.arange(-180.0, 180.0, 45.0)
    there_and_back = [*range(0, PITCHES, 2), *range(PITCHES - 2, 0, -2)]
    visits = [
        (pitch, roll)
        for turn, pitch in enumerate(there_and_back)
        for roll in (range(ROLLS) if turn % 2 == 0 else range(ROLLS - 1, -1, -1))
    ]
    pitch, roll = np.deg2rad(np.array([(pitches[turn], rolls[stop]) for turn, stop in visits])).T
    points = np.array([turn * ROLLS + stop + 1 for turn, stop in visits])
    pitch, roll = np.tile(pitch, replications), np.tile(roll, replications)
    k_v_per_g = np.diag(chance.uniform(2.3, 2.7, 3)) @ (np.eye(3) + 0.006 * chance.standard_normal((3, 3)))
    volts = 0.01 * chance.standard_normal(3) + specific_force(pitch, roll) @ k_v_per_g.T
    volts += 2.5 * 1.65 * ARCSEC * chance.standard_normal(volts.shape)
    return Observations(
        np.repeat(np.arange(replications) + 1, POINTS), np.tile(points, replications), pitch, roll,
        dict(zip("xyz", volts.T, strict=True)), step=np.arange(pitch.size) + 100 if steps else None,
        run="R17" if steps else "", source="a.csv",
    )  # fmt: skip


def solved(rows: Observations) -> Calibration:
    return calibrate(rows, CalibrationRequest(nominal_axes={axis: axis for axis in rows.outputs}))
