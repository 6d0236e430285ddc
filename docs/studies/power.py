"""Power of the drift tests, ours and TP's side by side, written as Markdown.

    python docs/studies/power.py OUTPUT_FILE

2 000 campaigns of TP's grid (±90° pitch by 10°, the roll circle by 30°, 247 points) in six replications for every line,
solved at once. A line's drift is the standard deviation of offset and sensitivity between replications in units of
their standard error from one replication; in arc seconds for a sensor whose dwells scatter by 0.5 arc second.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.stats import f

from ams.calibration.solving.columns import solve_columns
from ams.models.accelerometer import PitchRoll
from ams.observations import Observations

CAMPAIGNS = 2000
REPLICATIONS = 6
NOISE_ARCSEC = 0.5
SENSITIVITY_V_PER_G = 2.5
NOISE_V = NOISE_ARCSEC / 3600.0 * np.pi / 180.0 * SENSITIVITY_V_PER_G
PRIMARY = np.array([0.005, SENSITIVITY_V_PER_G, 0.018, 0.012])
DRIFTS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
LACKS_OF_FIT = (0.0, 1.0, 3.0)
HEAD = """# Power of the drift tests

Made by `python docs/studies/power.py docs/studies/power.md`: {campaigns} simulated campaigns a line, {points} points,
{replications} replications, dwells that scatter by {noise} arc second, every test at 5 %. The drift is the standard
deviation of the parameter between replications, in units of its standard error from one replication ({offset:.3f}″ for
the offset, {sensitivity:.3f} ppm for the sensitivity). *Theory* is the exact power of our test against a parameter that
wanders like that: T/(1 + δ²) is F(n − 1, (n − 1)(K − 4)). The first line of each block is the false alarms.
"""
TABLE = """
## Lack of fit of {lack_of_fit:g} times the noise

| drift δ | offset, ″ | theory | offset, ours | offset, TP | sensitivity, ours | sensitivity, TP |
|---|---|---|---|---|---|---|
"""
TAIL = """
Without lack of fit the two forms are equally sharp. With it TP's divides by residuals that contain the lack of fit:
the alarms vanish with the power. Ours holds the drift against what differs between replications alone, and does not
notice the lack of fit. What neither sees is a drift that the order of the points turns into something else; the time
term of the solution is for that.
"""


def design() -> Observations:
    """TP's grid; outputs are given apart."""
    grid = np.meshgrid(np.deg2rad(np.arange(-90.0, 91.0, 10.0)), np.deg2rad(np.arange(-180.0, 181.0, 30.0)))
    pitch, roll = (angle.ravel() for angle in grid)
    return Observations(
        replication=np.repeat(np.arange(REPLICATIONS), pitch.size),
        point=np.tile(np.arange(pitch.size), REPLICATIONS),
        pitch_rad=np.tile(pitch, REPLICATIONS),
        roll_rad=np.tile(roll, REPLICATIONS),
        outputs={},
    )


def standard_errors(observations: Observations) -> np.ndarray:
    """(4,) of the primary parameters from one replication, volts."""
    basis = PitchRoll("x").basis(observations)[: observations.rows // REPLICATIONS]
    return NOISE_V * np.sqrt(np.diag(np.linalg.inv(basis.T @ basis)))


def alarms(
    observations: Observations, drift: float, lack_of_fit: float, rng: np.random.Generator, campaigns: int = CAMPAIGNS
) -> tuple[float, float, float, float]:
    """Shares of alarms: offset ours, offset TP's, sensitivity ours, sensitivity TP's."""
    basis = PitchRoll("x").basis(observations)
    points = observations.rows // REPLICATIONS
    spread = drift * standard_errors(observations) * np.array([1.0, 1.0, 0.0, 0.0])
    parameters = PRIMARY + spread * rng.standard_normal((campaigns, REPLICATIONS, 4))
    outputs_v = np.einsum("ki,mri->rkm", basis[:points], parameters)
    outputs_v += lack_of_fit * NOISE_V * rng.standard_normal((points, campaigns))
    outputs_v += NOISE_V * rng.standard_normal(outputs_v.shape)
    solved = solve_columns(observations, outputs_v.reshape(-1, campaigns), [PitchRoll("x")] * campaigns)
    assert solved.replication is not None
    ours, tp = solved.replication.drift, solved.replication.tp.drift
    tests = (ours["offset"], tp["offset"], ours["sensitivity"], tp["sensitivity"])
    offset, offset_tp, sensitivity, sensitivity_tp = (float(np.mean(test.t > test.f_95)) for test in tests)
    return offset, offset_tp, sensitivity, sensitivity_tp


def theory(drift: float, points: int) -> float:
    """Power of an F test against a random effect."""
    dof = REPLICATIONS - 1, (REPLICATIONS - 1) * (points - 4)
    return float(f.sf(f.ppf(0.95, *dof) / (1.0 + drift**2), *dof))


def page(rng: np.random.Generator) -> Iterator[str]:
    """The page, piece by piece."""
    observations = design()
    points = observations.rows // REPLICATIONS
    errors = standard_errors(observations)
    offset_arcsec = float(np.rad2deg(errors[0] / SENSITIVITY_V_PER_G) * 3600.0)
    yield HEAD.format(
        campaigns=CAMPAIGNS, points=points, replications=REPLICATIONS, noise=NOISE_ARCSEC,
        offset=offset_arcsec, sensitivity=1e6 * errors[1] / SENSITIVITY_V_PER_G,
    )  # fmt: skip
    for lack_of_fit in LACKS_OF_FIT:
        yield TABLE.format(lack_of_fit=lack_of_fit)
        for drift in DRIFTS:
            shares = alarms(observations, drift, lack_of_fit, rng)
            cells = " | ".join(f"{100.0 * share:.1f} %" for share in (theory(drift, points), *shares))
            yield f"| {drift:g} | {drift * offset_arcsec:.3f} | {cells} |\n"
    yield TAIL


if __name__ == "__main__":
    Path(sys.argv[1]).write_text("".join(page(np.random.default_rng(8))), encoding="utf-8")
