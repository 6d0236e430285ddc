"""Three gyros on a rate table whose axes may lean and whose seats may be askew, as a table of dwells, from physics."""

import numpy as np
import pandas as pd

RATES_DPS = (0.0, 25.0, -25.0, 50.0, -50.0, 100.0, -100.0)
POSITIONS = (("yaw", 0.0), ("yaw", 180.0), ("yaw", 90.0), ("yaw", -90.0), ("roll", 0.0))
COLUMNS = {axis: f"{axis}_v" for axis in "xyz"}


OFFSET_V = 0.02
EARTH_DPS = 15.041067 / 3600.0


def ground_dps(latitude_deg: float, heading_deg: float) -> np.ndarray:
    """(3,) the rate of the ground along forward, right and down of a table that stands level."""
    latitude, heading = np.deg2rad([latitude_deg, heading_deg])
    north = np.cos(latitude)
    return EARTH_DPS * np.array([north * np.cos(heading), -north * np.sin(heading), -np.sin(latitude)])


def gyros(
    seed: int,
    *,
    squareness_arcsec: float = 0.0,
    seats_arcsec: float = 0.0,
    noise_v: float = 2e-5,
    ground: np.ndarray | None = None,
) -> tuple[pd.DataFrame, np.ndarray]:
    """Three gyros that turn about yaw at four rolls and about roll; second: their true conings, degrees.

    ``squareness_arcsec``: by which the roll axis leans, to either side; ``seats_arcsec``: by which the package is
    turned about each of its axes, anew at every position; ``noise_v``: of a dwell; ``ground``: what turns the table
    beside its own rates, of which whole turns leave what lies along their axis.
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
            seen = spin * rate if ground is None else spin * rate + _of_ground(ground, axis, roll, turns=rate != 0.0)
            read = OFFSET_V + volts @ seen + noise_v * chance.standard_normal(3)
            turned = (0.0, rate, 0.0) if axis == "yaw" else (0.0, 0.0, rate)
            rows.append((replication, point, 0.0, 0.0, roll, *turned, 60.0 * len(rows), *read))
    angles = ["pitch_deg", "yaw_deg", "roll_deg", "pitch_rate_dps", "yaw_rate_dps", "roll_rate_dps", "time_s"]
    table = pd.DataFrame(rows, columns=["replication", "point", *angles, *COLUMNS.values()])
    return table, np.rad2deg(np.arccos(np.diag(lies)))


def _of_ground(ground: np.ndarray, axis: str, roll_deg: float, *, turns: bool) -> np.ndarray:
    """(3,) along the axes of the package, °/s."""
    sine, cosine = np.sin(np.deg2rad(roll_deg)), np.cos(np.deg2rad(roll_deg))
    forward, right, down = ground
    if not turns:
        return np.array([forward, cosine * right + sine * down, cosine * down - sine * right])
    return down * np.array([0.0, sine, cosine]) if axis == "yaw" else np.array([forward, 0.0, 0.0])
