"""A meter whose step is well above the noise: what it repeats is its step, and no replication is loud for a few."""

from collections import Counter

import numpy as np
import pytest

from ams.calibration.calibrate import calibrate
from ams.frames import specific_force
from ams.inputs.request import CalibrationRequest
from ams.observations import Observations

STEP_V, CAMPAIGNS = 1e-4, 8
PITCH, ROLL = (angles.ravel() for angles in np.meshgrid(np.linspace(-60.0, 60.0, 13), np.arange(0.0, 360.0, 30.0)))


def _told(seed: int, noise_steps: float, *, louder: float = 1.0, bent_v: float = 0.0) -> set[str]:
    """Return which kinds are told of a linear sensor read in steps, bent by a term of the square of what it senses.

    ``louder``: by how much the second replication scatters more.
    """
    chance, replications = np.random.default_rng([seed, 7]), (4, 6)[seed % 2]
    point = np.concatenate([chance.permutation(PITCH.size) for _ in range(replications)])
    replication = np.repeat(np.arange(replications) + 1, PITCH.size)
    pitch, roll = np.deg2rad(PITCH[point]), np.deg2rad(ROLL[point])
    force = specific_force(pitch, roll)
    read = force @ [2.5, 0.015, -0.01] + 0.002 + chance.uniform(0.0, 1.0) * STEP_V
    read = read + bent_v * np.sin(3.0 * pitch) * np.cos(2.0 * roll)
    noise_v = noise_steps * STEP_V * np.where(replication == 2, louder, 1.0)
    read = STEP_V * np.round((read + noise_v * chance.standard_normal(point.size)) / STEP_V)
    rows = Observations(replication, point + 1, pitch, roll, {"x": read})
    findings = calibrate(rows, CalibrationRequest()).axes["x"].findings
    return {finding.kind for finding in findings if finding.is_significant}


@pytest.mark.parametrize("noise_steps", [0.02, 0.05, 0.2])
def test_the_step_of_a_meter_is_no_lack_of_fit_and_no_loud_replication(noise_steps: float) -> None:
    """Each was told in most of these campaigns: half of the dwells of a point, and more, read the same."""
    told = Counter(kind for seed in range(CAMPAIGNS) for kind in _told(seed, noise_steps))
    assert told["lack-of-fit"] <= 1
    assert told["uneven-noise"] <= 1


@pytest.mark.parametrize("noise_steps", [0.05, 0.2])
def test_what_repeats_by_more_than_the_step_is_a_lack_of_fit(noise_steps: float) -> None:
    """A bend of two steps that no term of low order follows, beside 0.29 of a step."""
    told = Counter(kind for seed in range(CAMPAIGNS) for kind in _told(seed, noise_steps, bent_v=2.0 * STEP_V))
    assert told["lack-of-fit"] == CAMPAIGNS


def test_a_replication_that_is_loud_by_steps_is_told() -> None:
    told = Counter(kind for seed in range(CAMPAIGNS) for kind in _told(seed, 0.2, louder=4.0))
    assert told["uneven-noise"] == CAMPAIGNS
