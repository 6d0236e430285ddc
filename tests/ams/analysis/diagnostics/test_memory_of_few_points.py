"""A sensor that remembers the attitude before, at so few points that their means say nothing of it."""

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

TWELVE = np.deg2rad([(p, r) for p in (-45.0, 0.0, 45.0) for r in (-180.0, -90.0, 0.0, 90.0)])


@pytest.mark.parametrize("kept_sd", [5.0, 20.0, 100.0])
def test_a_memory_is_told_by_what_differs_between_replications_alone(kept_sd: float) -> None:
    """Each replication goes its own way; what it was turned by, times ``kept_sd`` of the noise, stays in the output."""
    for seed in range(4):
        chance = np.random.default_rng(seed)
        location = np.concatenate([chance.permutation(len(TWELVE)) for _ in range(4)])
        pitch, roll = TWELVE[location].T
        force = specific_force(pitch, roll)[:, 0]
        before = np.where(np.arange(force.size) % len(TWELVE) == 0, force, np.roll(force, 1))
        noise = chance.standard_normal(force.size) + kept_sd * (before - force)
        outputs = {"x": 0.002 + 2.5 * force + 2e-5 * noise}
        rows = Observations(np.repeat([1, 2, 3, 4], len(TWELVE)), location + 1, pitch, roll, outputs)
        findings = calibrate(rows, CalibrationRequest()).axes["x"].findings
        assert "autocorrelation" in {finding.kind for finding in findings if finding.is_significant}
