"""Three gyros on a rate table whose axes may lean and whose seats may be askew, as a table of dwells, from physics."""

import numpy as np
import pandas as pd

RATES_DPS = (0.0, 25.0, -25.0, 50.0, -50.0, 100.0, -100.0)
POSITIONS = (("yaw", 0.0), ("yaw", 180.0), ("yaw", 90.0), ("yaw", -90.0), ("roll", 0.0))
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}


def gyros(seed: int, *, squareness_arcsec: float = 0.0, seats_arcsec: float = 0.0) -> tuple[pd.DataFrame, np.ndarray]:
    """Three gyros that turn about yaw at four rolls and about roll, 20 µV a dwell; second: their true conings, degrees.

    ``squareness_arcsec``: by which the roll axis leans, to either side; ``seats_arcsec``: by which the package is
    turned about each of its axes, anew at every position.
    """
    chance = np.random.default_rng(seed)
    lies = np.eye(3) + np.deg2rad(0.2) * chance.standard_normal((3, 3)) * (1.0 - np.eye(3))
    lies /= np.linalg.norm(lies, axis=1)[:, None]
    volts = 0.02 * (1.0 + 0.01 * chance.uniform(-1.0, 1.0, 3))[:, None] * lies
    leans = np.deg2rad(squareness_arcsec / 3600.0) * chance.standard_normal(2)
    about = {
        (axis, roll): np.array([0.0, np.sin(np.deg2rad(roll)), np.cos(np.deg2rad(roll))])
        if axis == "yaw"
        else np.array([1.0, *leans])
        for axis, roll in POSITIONS
    }
    seats = {position: np.deg2rad(seats_arcsec / 3600.0) * chance.standard_normal(3) for position in POSITIONS}
    rows = []
    for replication in range(1, 5):
        stood = [(position, rate) for position in POSITIONS for rate in RATES_DPS]
        for point, ((axis, roll), rate) in enumerate(stood, start=1):
            spin = about[axis, roll] - np.cross(seats[axis, roll], about[axis, roll])
            read = 0.02 + volts @ spin * rate + 2e-5 * chance.standard_normal(3)
            turned = (0.0, rate, 0.0) if axis == "yaw" else (0.0, 0.0, rate)
            rows.append((replication, point, 0.0, 0.0, roll, *turned, 60.0 * len(rows), *read))
    angles = ["pitch_deg", "yaw_deg", "roll_deg", "pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps", "time_s"]
    table = pd.DataFrame(rows, columns=["replication", "point", *angles, *COLUMNS.values()])
    return table, np.rad2deg(np.arccos(np.diag(lies)))
