"""Three gyros on a rate table at several temperatures, each axis turned at one position, from physics."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

RATES_DPS = (20.0, -20.0, 60.0, -60.0)
PLATEAUS_DEGC = (20.0, 35.0, 5.0, 20.0, 5.0, 35.0)
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}
REFERENCE_DEGC = 20.0
_POINTS = np.vstack([np.zeros(3), *(rate * np.eye(3) for rate in RATES_DPS)])
_ANGLES = ("pitch_deg", "yaw_deg", "roll_deg")


def warm_gyros(seed: int, scatter_degc: float, bend_per_degc2: float = 0.0) -> tuple[pd.DataFrame, Mapping[str, float]]:
    """Two replications at each plateau, 20 µV a dwell; second: the true sensitivities, V/dps, at the reference.

    ``scatter_degc``: standard deviation of the temperature about its plateau, at every dwell. Gyros of a seed have the
    same noise at every scatter. ``bend_per_degc2``: of the sensitivities over temperature.
    """
    chance = np.random.default_rng(seed)
    volts = np.diag(chance.uniform(0.01, 0.02, 3)) + 1e-4 * chance.standard_normal((3, 3))
    by_degc, offset_by_degc = chance.uniform(-4e-4, 4e-4, 3), chance.uniform(-3e-4, 3e-4, 3)
    rows = []
    for replication, plateau_degc in enumerate(np.repeat(PLATEAUS_DEGC, 2), start=1):
        for point in chance.permutation(len(_POINTS)):
            rate_dps, scatter, noise = _POINTS[point], chance.standard_normal(), chance.standard_normal(3)
            rise_degc = plateau_degc + scatter_degc * scatter - REFERENCE_DEGC
            gain = 1.0 + by_degc * rise_degc + bend_per_degc2 * rise_degc**2
            read_v = 1.25 + offset_by_degc * rise_degc + gain * (volts @ rate_dps) + 2e-5 * noise
            roll_dps, pitch_dps, yaw_dps = rate_dps
            turned = (0.0, 0.0, 0.0, pitch_dps, yaw_dps, roll_dps)
            rows.append((replication, point, *turned, rise_degc + REFERENCE_DEGC, 30.0 * len(rows), *read_v))
    rates = ["pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps"]
    names = ["replication", "point", *_ANGLES, *rates, "temperature_degc", "time_s", *COLUMNS.values()]
    return pd.DataFrame(rows, columns=names), dict(zip("xyz", np.linalg.norm(volts, axis=1), strict=True))
