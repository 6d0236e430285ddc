"""A sensor that follows the recorded temperature at once has no lag, also where no temperature is modelled."""

import numpy as np

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

POINTS = np.array([(p, r) for p in range(-60, 61, 15) for r in range(-180, 180, 45)], dtype=float)
REPLICATIONS, DWELL_S = 4, 120.0


def _told(followed_h: float, seed: int) -> set[str]:
    """The room swings by 1.5 °C in six hours; the sensor is at it, or follows it with a time constant."""
    chance = np.random.default_rng(seed)
    order = np.concatenate([chance.permutation(len(POINTS)) for _ in range(REPLICATIONS)])
    time_s = DWELL_S * np.arange(len(order))
    room = 20.0 + 1.5 * np.sin(2.0 * np.pi * time_s / 21600.0 + chance.uniform(0.0, 6.0))
    body = room.copy()
    if followed_h > 0.0:
        for at in range(1, len(body)):
            body[at] = body[at - 1] + (room[at] - body[at - 1]) * (1.0 - np.exp(-DWELL_S / (3600.0 * followed_h)))
    pitch, roll = np.deg2rad(POINTS[order]).T
    force = specific_force(pitch, roll)
    read = 0.002 + 2.5 * force + (2e-5 + 5e-5 * force) * (body - 20.0)[:, None]
    read = read + 1.8e-5 * chance.standard_normal(read.shape)
    rows = Observations(
        np.repeat(np.arange(1, REPLICATIONS + 1), len(POINTS)), order + 1, pitch, roll,
        dict(zip("xyz", read.T, strict=True)), time_s=time_s,
        temperature_degc=room + 0.01 * chance.standard_normal(len(room)),
    )  # fmt: skip
    solved = calibrate(rows, CalibrationRequest())
    return {f.kind for axis in solved.axes.values() for f in axis.findings if f.is_significant}


def test_what_follows_at_once_has_no_lag_and_what_follows_late_has() -> None:
    at_once, late = [_told(0.0, seed) for seed in range(8)], [_told(0.5, seed) for seed in range(8)]
    assert all("temperature-residual" in kinds for kinds in at_once)
    assert sum("temperature-lag" in kinds for kinds in at_once) == 0
    assert all("temperature-lag" in kinds for kinds in late)
